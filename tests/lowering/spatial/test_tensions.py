"""The forces in the links: pendulums by hand, d'Alembert along a curve in 60 digits, unlike masses, Newton's law of the cart."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain import build
from phichain.ir import count_operations, evaluate, evaluate_exactly, total_operations
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference
from phichain.scene import Scene
from tests.lowering.chains import Arguments, gap, kinds, label, random_arguments
from tests.lowering.test_momentum import exact_state
from tests.reference_cases import relative_error

WIDE: dict[str, Any] = {"mass": [1.0, 1e-4, 0.3, 1e-3, 1.0], "length": [1.0, 1e-4, 0.5, 1e-2, 1.0]}
"""Masses and lengths over four decades, light links between heavy ones."""


def found(chain: Scene, arguments: Arguments) -> np.ndarray:
    """The tensions in double precision."""
    return np.asarray(evaluate(lower_function(derive(chain), "tensions", "loops"), arguments)["out"])


def drawn(chain: Scene, seed: int = 3) -> Arguments:
    return random_arguments(chain, lower_function(derive(chain), "tensions", "loops"), seed)


@pytest.mark.parametrize("com", [0.8, 0.5])
def test_a_pendulum_pulls_by_its_weight_and_its_swing(com: float) -> None:
    """m r w^2 + m g cos(theta), in the plane and in space alike."""
    theta, w = 0.7, 2.0
    expected = 0.3 * (com * w**2 + 9.81 * np.cos(theta))
    planar = Scene("one", 1, mass=0.3, length=0.8, com=com)
    assert abs(found(planar, {"q": np.array([theta]), "v": np.array([w])})[0] - expected) < 1e-15 * expected
    spatial = Scene("one", 1, space="spatial", mass=0.3, length=0.8, com=com)
    state = {"q": np.array([np.sin(theta), 0.0, np.cos(theta)]), "v": np.array([0.0, w, 0.0])}
    assert abs(found(spatial, state)[0] - expected) < 1e-15 * expected


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds()], ids=label)
def test_a_chain_at_rest_carries_what_hangs_on_it(chain: Scene) -> None:
    """T_k = g sum_{a>=k} m_a hanging, and the same pressed instead of pulled upright; rods beyond a hanging link change nothing."""
    arguments = drawn(chain) | {"v": np.zeros(chain.nv)} | ({"u": np.zeros(chain.nu)} if chain.nu else {})
    mass = np.asarray(arguments["mass"] if chain.mass == "runtime" else chain.mass)
    gravity = float(arguments["gravity"]) if chain.gravity == "runtime" else chain.gravity
    weight = gravity * np.cumsum(mass[::-1])[::-1]
    down = np.array([0.0, 0.0, 1.0])
    q = np.zeros(chain.nq) if chain.is_planar else np.concatenate([np.zeros(2 * chain.has_cart), *[down] * chain.links])
    assert gap(found(chain, arguments | {"q": q}), weight) < 1e-15
    if not chain.is_planar and chain.stiffness is None:
        assert gap(found(chain, arguments | {"q": -q}), -weight) < 1e-15


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds()], ids=label)
def test_they_are_the_forces_along_a_motion(chain: Scene) -> None:
    """In 60 digits: masses' accelerations as second differences of their positions along a curve with the chain's own q', q''."""
    program, arguments = lower_function(derive(chain), "tensions", "loops"), drawn(chain, 4)
    known: dict[str, Any] = {name: value.ravel().tolist() for name, value in arguments.items()}
    with mp.workdps(60):
        known = {name: [mp.mpf(x) for x in values] for name, values in known.items()}
        if not chain.is_planar:
            known |= exact_state(chain, known)
        made = evaluate_exactly(program, known, 60)["out"]
        forward = lower_function(derive(chain), "forward_dynamics", "loops")
        a = evaluate_exactly(forward, known, 60)["a"]
        expected = forces_along(chain, known, a)
        apart = max(abs(x - y) for x, y in zip(made, expected, strict=True))
        assert apart < mp.mpf("1e-25") * max(map(abs, expected))


def forces_along(chain: Scene, known: dict[str, Any], a: list[Any]) -> list[Any]:
    """-q_k . sum_{a>=k} m_a (r_a'' - g e_d) by positions at three times."""
    positions, h = lower_function(derive(chain), "positions", "loops"), mp.mpf("1e-15")
    rate, second = derivatives(chain, known, a)
    at = [
        evaluate_exactly(positions, known | {"q": [q + t * w + t * t / 2 * b for q, w, b in zip(known["q"], rate, second, strict=True)]}, 60)
        for t in (-h, mp.zero, h)
    ]  # fmt: skip
    size = 2 if chain.is_planar else 3
    bent = [(x - 2 * y + z) / h**2 for x, y, z in zip(*(place["out"] for place in at), strict=True)]
    mass = known["mass"] if chain.mass == "runtime" else [mp.mpf(m) for m in chain.mass]
    gravity = known["gravity"][0] if chain.gravity == "runtime" else mp.mpf(chain.gravity)
    total, tensions = [mp.zero] * size, []
    for k, link in reversed(list(enumerate(links(chain, known["q"])))):
        for i in range(size):
            total[i] += mass[k] * (bent[size * k + i] - (gravity if i == size - 1 else 0))
        tensions.append(-mp.fdot(link, total))
    return tensions[::-1]


def derivatives(chain: Scene, known: dict[str, Any], a: list[Any]) -> tuple[list[Any], list[Any]]:
    """q' and q'' of angles, or of unit vectors."""
    if chain.is_planar:
        return known["v"], a
    first = 2 * chain.has_cart
    rate, second = known["v"][:first], a[:first]
    for k in range(first, chain.nq, 3):
        link, omega, alpha = (vector[k : k + 3] for vector in (known["q"], known["v"], a))
        turning = crossed(omega, link)
        rate, second = rate + turning, second + [x + y for x, y in zip(crossed(alpha, link), crossed(omega, turning), strict=True)]
    return rate, second


def crossed(a: list[Any], b: list[Any]) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def links(chain: Scene, q: list[Any]) -> list[list[Any]]:
    """The links' directions, the last component down."""
    first = chain.nq - (1 if chain.is_planar else 3) * chain.links
    if not chain.is_planar:
        return [q[k : k + 3] for k in range(first, chain.nq, 3)]
    own, found = q[first:], []
    for k, angle in enumerate(own):
        before = {"absolute": 0, "relative": found[-1] if found else 0, "adjacent": own[k - 1] if k else 0}[str(chain.angles)]
        found.append(before + angle)
    return [[mp.sin(angle), mp.cos(angle)] for angle in found]


@pytest.mark.long
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("com", [None, 0.99, 0.7])
@pytest.mark.parametrize("joints", [{}, {"damping": 1e-3, "stiffness": 1e-2}])
def test_every_digit_is_kept_however_unlike_the_links_are(
    space: str, base: str, com: float | None, joints: dict[str, Any]
) -> None:
    """Summed up from accelerations a light link between heavy ones loses four digits here; in space vectors off the sphere lose one."""
    keys = WIDE | joints | ({"cart_mass": 1e-2} if base == "cart" else {})
    keys |= {} if com is None else {"com": [com * length for length in WIDE["length"]]}
    keys |= {"actuated": "all"} if space == "planar" else {}
    chain = Scene("wide", 5, space, base, **keys)
    program = lower_function(derive(chain), "tensions", "loops")
    for seed in range(3):
        arguments = random_arguments(chain, program, seed)
        inputs = {name: value.ravel().tolist() for name, value in arguments.items()}
        expected = reference(chain, "tensions", inputs, digits=30)["tension"]
        found = evaluate(program, arguments)["out"].tolist()
        assert relative_error(found, expected) < (1e-14 if chain.is_planar else 1e-13)


@pytest.mark.long
@pytest.mark.parametrize("mass", [[1e-4, 1.0, 0.5], [1e4, 1.0, 1e-2]])
@pytest.mark.parametrize(("base", "angles"), [("fixed", "relative"), ("cart", "absolute"), ("cart", "adjacent"), ("fixed", None), ("cart", None)])
def test_chains_of_unlike_links_are_proven_too(mass: list[float], base: str, angles: str | None) -> None:
    """The sweep that takes no difference of forces, its couples and its cart."""
    keys: dict[str, Any] = {"angles": angles, "actuated": "all"} if angles else {"space": "spatial"}
    chain = Scene(
        "unlike", 3, base=base, mass=mass, length=[0.5, 0.4, 0.3], com=[0.4, 0.1, 0.3], stiffness=0.3, damping=0.1,
        cart_mass=0.7 if base == "cart" else None, want=["tensions"], **keys,
    )  # fmt: skip
    assert not lower_function(derive(chain), "tensions", "loops").callees
    assert "tensions" in prove(chain).exact


@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("com", [None, 0.03])
def test_operations_grow_with_the_links_alone(space: str, com: float | None) -> None:
    def counted(links: int) -> int:
        keys: dict[str, Any] = {"mass": 0.1, "length": 0.1, "com": com, "space": space}
        return total_operations(lower_function(derive(Scene("chain", links, **keys)), "tensions", "unrolled"))

    sizes = [counted(links) for links in (8, 10, 12)]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0]


def test_tensions_of_points_call_nothing_and_make_no_acceleration() -> None:
    point = lower_function(derive(Scene("point", 4, space="spatial", mass=0.1, length=0.1)), "tensions", "loops")
    assert not point.callees and count_operations(point).get("sincos", 0) == 0
    rod = lower_function(derive(Scene("rod", 4, mass=0.1, length=0.1, com=0.05)), "tensions", "loops")
    assert set(rod.callees) == {"forward_dynamics"}


@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_the_first_link_pulls_the_cart(space: str) -> None:
    """m_0 x'' = u + T_1 C^T q_1 without couples, in emitted C with runtime masses."""
    chain = Scene(
        f"pulled_{space}", 3, space, "cart", mass="runtime", length=0.4, cart_mass=0.8, want=("forward_dynamics", "tensions")
    )
    system, arguments = build(chain), drawn(chain, 6)
    q, v, u, p = (arguments[name] for name in ("q", "v", "u", "mass"))
    tension = system.tensions(q, v, u, p={"mass": p})
    x = system.forward_dynamics(q, v, u, p={"mass": p})[: chain.nu]
    across = np.array([np.sin(q[1])]) if chain.is_planar else q[2:4]
    assert tension.shape == (3,)
    assert np.max(np.abs(0.8 * x - u - tension[0] * across)) < 1e-13 * np.max(np.abs(tension))
