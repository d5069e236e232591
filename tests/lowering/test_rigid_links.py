"""Links with moments of inertia: against a dense chain of dumbbells, over decades, folded to points and at run time."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate, total_operations
from phichain.lowering import lower_function
from phichain.lowering.chain.body import moments, point_masses
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.reference.nudge import Nudge
from phichain.scene import Scene
from tests.lowering.chains import random_arguments
from tests.reference_cases import relative_error

Body = dict[str, list[float]]
#: m, l, com beyond the link's end, at its joint, and a link without inertia among others.
UNEVEN: Body = {
    "mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8], "com": [0.3, 0.9, 0.0], "inertia": [0.05, 0.0, 0.02],
}  # fmt: skip


def forward(chain: Scene, given: dict[str, Any]) -> np.ndarray:
    program = lower_function(derive(chain), "forward_dynamics", "loops")
    return evaluate(program, {array.name: given[array.name] for array in (*program.params, *program.inputs)})["a"]


def dumbbells(chain: Scene, q: list[float], v: list[float]) -> list[Any]:
    """Accelerations in absolute angles of two halves of every mass, sqrt(J/m) before and behind its place, by the dense matrix."""
    with mp.workdps(50):
        mass, length, com, spin = (
            [mpf(x) for x in values] for values in (chain.mass, chain.length, chain.com or chain.length, chain.inertia)
        )
        n, carts = chain.links, int(chain.has_cart)
        levers = []
        for k in range(n):
            for side in (-1, 1):
                arm = com[k] + side * mp.sqrt(spin[k] / mass[k])
                levers.append((mass[k] / 2, [*length[:k], arm, *[mpf(0)] * (n - k - 1)]))
        phi, rate = [mpf(x) for x in q[carts:]], [mpf(x) for x in v[carts:]]
        matrix, right = mp.zeros(n + carts), mp.zeros(n + carts, 1)
        if carts:
            matrix[0, 0] = mpf(chain.cart_mass)
        for m, arms in levers:
            rows = [(mpf(1), mpf(0))] * carts + [(a * mp.cos(p), -a * mp.sin(p)) for a, p in zip(arms, phi, strict=True)]
            still = [sum(-a * w * w * f(p) for a, w, p in zip(arms, rate, phi, strict=True)) for f in (mp.sin, mp.cos)]
            still[1] -= mpf(chain.gravity)
            for i, one in enumerate(rows):
                right[i] -= m * (one[0] * still[0] + one[1] * still[1])
                for j, other in enumerate(rows):
                    matrix[i, j] += m * (one[0] * other[0] + one[1] * other[1])
        return list(mp.lu_solve(matrix, right))


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_reference_and_program_are_the_dense_dumbbells(base: str) -> None:
    cart: dict[str, Any] = {"cart_mass": 1.3, "actuated": "none"} if base == "cart" else {}
    chain = Scene("x", 3, base=base, angles="absolute", **UNEVEN, **cart)
    q, v = [0.4, -1.1, 2.0], [-0.6, 1.4, 0.8]
    if cart:
        q, v = [0.2, *q], [0.1, *v]
    true = dumbbells(chain, q, v)
    assert relative_error(reference(chain, "forward_dynamics", {"q": q, "v": v})["a"], true) < 1e-40
    assert relative_error(forward(chain, {"q": np.array(q), "v": np.array(v)}).tolist(), true) < 1e-14


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("com", [UNEVEN["com"], [0.3, 0.9, 1.1]])
def test_spatial_chain_in_a_plane_is_the_planar_one(base: str, com: list[float]) -> None:
    keys: dict[str, Any] = UNEVEN | {"com": com, "base": base} | ({"cart_mass": 1.3, "actuated": "none"} if base == "cart" else {})
    phi, rate = np.array([0.4, -1.1, 2.0]), np.array([-0.6, 1.4, 0.8])
    flat, spatial = Scene("x", 3, angles="absolute", **keys), Scene("x", 3, space="spatial", **keys)
    links = np.column_stack([np.sin(phi), 0 * phi, np.cos(phi)])
    spins = np.column_stack([0 * phi, rate, 0 * phi])
    cart = np.array([0.2, 0.0]) if base == "cart" else np.array([])
    still = forward(flat, {"q": np.append(cart[:1], phi), "v": np.append(cart[1:], rate)})
    moving = forward(spatial, {"q": np.append(cart, links), "v": np.append(0 * cart, spins)})
    turning = moving[len(cart) :].reshape(-1, 3)
    assert np.allclose(turning[:, 1], still[len(cart) // 2 :], rtol=1e-13)
    assert np.max(np.abs(turning[:, [0, 2]])) < 1e-13 * np.max(np.abs(turning))
    assert np.allclose(moving[: len(cart) // 2], still[: len(cart) // 2], rtol=1e-13)


def test_acrobot_of_the_textbook() -> None:
    """Spong's: m = l = 1, com 1/2, inertia 1 about it, a torque at the second joint."""
    chain = Scene("acrobot", 2, mass=1.0, length=1.0, com=0.5, inertia=1.0, gravity=9.8, actuated=[2])
    found = forward(chain, {"q": np.array([0.3, -0.2]), "v": np.array([0.5, -1.0]), "u": np.array([1.0])})
    assert np.allclose(found, [-2.7110094150749185, 4.2023172428700033], rtol=1e-15)


@pytest.mark.parametrize("links", range(1, 11))
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_uniform_rods_are_their_points(space: str, links: int) -> None:
    """a = mu_k - l M and b = c_kk - l^2 M, M the points beyond: r' = b/a, m' = a^2/b. The tip's lies at 2/3, the others further out."""
    rods = Scene("x", links, space=space, mass=0.3, length=0.4, com=0.2, inertia=0.3 * 0.4**2 / 12)
    model, beyond, mass, com = derive(rods), Fraction(0), [], []
    for mu, c in zip(reversed(model.mu), reversed(model.c_diagonal), strict=True):
        length = Fraction(0.4)
        a, b = mu - length * beyond, c - length**2 * beyond
        mass.append(float(a * a / b))
        com.append(float(b / a))
        beyond += a * a / b
    assert com[0] / 0.4 == pytest.approx(2 / 3)
    assert com[0] <= min(com) and max(com) < 0.4 * (3 + 3**0.5) / 6 + 1e-12
    points = Scene("x", links, space=space, mass=mass[::-1], length=0.4, com=com[::-1])
    given = random_arguments(rods, lower_function(model, "forward_dynamics", "loops"), seed=links)
    truth = reference(points, "forward_dynamics", {name: value.tolist() for name, value in given.items()}, digits=30)["a"]
    assert relative_error(forward(rods, given).tolist(), truth) < 1e-14


def test_rods_cost_what_points_cost() -> None:
    """Folding leaves nothing of the inertia in the code: every operation is one of the point masses'."""
    rods = Scene("x", 6, base="cart", cart_mass=1.0, mass=0.3, length=0.4, com=0.2, inertia=0.004)
    points = point_masses(rods)
    assert points.inertia is None
    uneven = Scene("x", 6, base="cart", cart_mass=1.1, mass=[float(x) for x in points.mass], length=0.4, com=[float(x) for x in points.com])
    for name in ("forward_dynamics", "state_jacobian"):
        counts = [total_operations(lower_function(derive(chain), name, "unrolled")) for chain in (rods, uneven)]
        assert counts[0] == counts[1]


def test_paper_a_with_inertia_takes_a_fifth_more_at_most() -> None:
    plain: dict[str, Any] = {"mass": 0.25, "length": 0.25, "com": 0.125, "actuated": "all"}
    counts = [
        total_operations(lower_function(derive(Scene("a", 4, **plain, **more)), "forward_dynamics", "unrolled"))
        for more in ({}, {"inertia": 0.25**3 / 12})
    ]
    assert counts[0] < counts[1] <= 1.2 * counts[0]


def test_left_over_mass_is_what_the_points_do_not_hold() -> None:
    chain = Scene("x", 3, **(UNEVEN | {"com": [0.3, 0.9, 1.1]}))
    found = moments(chain)
    points = [a * a / b for a, b in zip(found.first, found.second, strict=True)]
    assert found.left == sum(map(Fraction, chain.mass)) - sum(points)
    assert found.left > 0


def hard_body(links: int, kind: str, rng: np.random.Generator) -> Body:
    """Masses and lengths over four decades each; where the masses sit and what turns beside them, by kind."""
    mass, length = 10 ** rng.uniform(-2, 2, links), 10 ** rng.uniform(-2, 2, links)
    com, spin = {
        "rods": (length / 2, mass * length**2 / 12),
        "near": (length * 10 ** rng.uniform(-8, 0, links), mass * length**2 * 10 ** rng.uniform(-8, 1, links)),
        "held": (length * rng.choice([0.0, 0.5, 1.5], links), mass * length**2 * 10 ** rng.uniform(-4, 2, links)),
        "far": (length * 10 ** rng.uniform(-1, 1, links), mass * length**2 * 10 ** rng.uniform(-4, 2, links)),
    }[kind]
    return {"mass": mass.tolist(), "length": length.tolist(), "com": com.tolist(), "inertia": spin.tolist()}


@pytest.mark.long
@pytest.mark.parametrize("at_run_time", [False, True], ids=["numbers", "runtime"])
@pytest.mark.parametrize("kind", ["rods", "near", "held", "far"])
@pytest.mark.parametrize(("space", "base"), [("planar", "fixed"), ("planar", "cart"), ("spatial", "fixed"), ("spatial", "cart")])
def test_digits_over_decades(space: str, base: str, kind: str, at_run_time: bool) -> None:
    """1e-14, or ten times what half a unit in the last place of every number does to the exact accelerations."""
    for links in (2, 3, 5, 8):
        rng = np.random.default_rng(links)
        body, more = hard_body(links, kind, rng), {"space": space, "base": base}
        if base == "cart":
            more["cart_mass"] = float(10 ** rng.uniform(-2, 2))
        elif space == "planar":
            more["actuated"] = "all"
        chain = Scene("hard", links, **(dict.fromkeys(body, "runtime") if at_run_time else body), **more)
        given = random_arguments(chain, lower_function(derive(chain), "forward_dynamics", "loops"), seed=links)
        params = body if at_run_time else {}
        given |= {name: np.array(values) for name, values in params.items()}
        inputs = {name: value.tolist() for name, value in given.items() if name not in params}
        true, moved = (reference(chain, "forward_dynamics", inputs, params=params, nudge=nudge)["a"] for nudge in (None, Nudge("1")))
        with mp.workdps(50):
            amplified = float(max(abs(a - b) for a, b in zip(true, moved, strict=True)) / max(map(abs, true)) * mpf(2) ** (80 - 53))
        assert relative_error(forward(chain, given).tolist(), true) < max(1e-14, 10 * amplified), links


def test_flows_of_rigid_links_ask_nothing_of_their_centres_of_mass() -> None:
    keys: dict[str, Any] = {"space": "spatial", "mass": 1.0, "length": 1.0, "inertia": 0.1}
    for com in ([0.0, 0.5], [0.5, 0.0], "runtime", 0.5):
        for flow in ("propagate", "propagate_stiff"):
            assert flow in Scene("x", 2, com=com, want=[flow], **keys).want
    Scene("x", 2, com=0.5, want=["propagate"], **(keys | {"inertia": "runtime"}))
    Scene("x", 2, com=[0.5, 0.0], want=["propagate"], **(keys | {"space": "planar"}))
