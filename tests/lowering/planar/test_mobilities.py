"""The spatial sweep by mobilities: where it is taken, that its bound holds, and what it costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir import count_operations, evaluate, total_operations
from phichain.lowering import lower_function
from phichain.lowering.spatial import mobilities
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.hard_chains import Hard
from tests.reference_cases import relative_error

BETAS = (1.0, 0.9, 0.7, 0.5, 0.4, 0.3, 0.2, 0.1)


def chain(links: int, ratio: float, **more: Any) -> Scene:
    keys: dict[str, Any] = {"mass": 0.1, "length": 0.1, "com": 0.1 * ratio, "space": "spatial"}
    return Scene("pushed", links, **(keys | more))


def operations(scene: Scene, code: str = "loops") -> int:
    return total_operations(lower_function(derive(scene), "forward_dynamics", code))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("scene", "suits"),
    [
        (chain(5, 0.5), True), (chain(64, 0.5), True), (chain(5, 0.5, base="cart", cart_mass=0.5), True),
        (chain(5, 0.45), True), (chain(10, 0.9, mass=[0.1] * 9 + [1e6]), False), (chain(3, 0.5, mass=[1.0, 1.0, 1e4]), True),
        (chain(3, 0.5, mass=[1.0, 1e4, 1.0]), False), (chain(3, 0.5, mass=[1e7, 1.0, 1.0]), False),
        (chain(5, 0.2), False), (chain(2, 0.01), False), (chain(5, 0.5, base="cart", cart_mass=1e-4), False),
        (chain(5, 0.5, mass="runtime"), False), (chain(5, 0.5, com="runtime"), False),
        (chain(5, 0.5, base="cart", cart_mass="runtime"), False), (chain(5, 0.5, stiffness="runtime"), True),
        (chain(5, 1.0, com=None), False),
    ],
)  # fmt: skip
def test_where_it_is_taken(scene: Scene, suits: bool) -> None:
    assert mobilities.suits(scene) == suits


def test_the_bound_counts_what_lies_beyond() -> None:
    """By hand: the tip passes no G on, each other link (1 - beta)^2 m of its own and ((1 - beta) / beta)^2 of what it met."""
    assert mobilities.amplification([(1.0, 0.5)] * 2, None) == 0.0
    assert mobilities.amplification([(1.0, 0.5)] * 5, None) == 3.0
    assert mobilities.amplification([(1.0, 0.25)] * 4, None) == pytest.approx((0.75**2 * (1 + 9)) / 0.25**2)
    assert mobilities.amplification([(1.0, 0.5)] * 2, 0.01) == 25.0


def random_chain(rng: np.random.Generator, sprung: bool) -> Scene:
    links = int(rng.integers(1, 8))
    mass = 10 ** rng.uniform(-1, 1, links) if rng.random() < 0.5 else np.where(np.arange(links) == links - 1, 1e4, 1.0)
    length = 10 ** rng.uniform(-2, 2, links)
    ratio = rng.choice(BETAS, links)
    com = [x if beta == 1 else x * beta for x, beta in zip(length.tolist(), ratio.tolist(), strict=True)]
    more: dict[str, Any] = {"base": "cart", "cart_mass": float(10 ** rng.uniform(-1, 1))} if rng.random() < 0.5 else {}
    more |= {"stiffness": float(10 ** rng.uniform(-2, 4)), "damping": 0.3} if sprung else {}
    return Scene("pushed", links, space="spatial", mass=mass.tolist(), length=length.tolist(), com=com, **more)


def state(scene: Scene, rng: np.random.Generator) -> dict[str, Any]:
    """Scattered, straight, folded or fast."""
    shape = rng.integers(4)
    q, v = rng.normal(size=(2, scene.links, 3))
    if shape == 1:
        q = np.array([0.3, 0.4, 0.866]) + 1e-4 * q
    if shape == 2:
        q = np.outer((-1.0) ** np.arange(scene.links), [0.3, 0.4, 0.866])
    q /= np.linalg.norm(q, axis=1)[:, None]
    v = (1e4 if shape == 3 else 2) * (v - q * np.sum(q * v, axis=1)[:, None])
    still = [0.0] * (2 * scene.has_cart)
    inputs = {"q": [*still, *q.ravel().tolist()], "v": [*still, *v.ravel().tolist()]}
    return inputs | ({"u": rng.normal(size=scene.nu).tolist()} if scene.nu else {})


@pytest.mark.long
@pytest.mark.parametrize("sprung", [False, True], ids=["free", "sprung"])
def test_within_the_bound_the_digits_are_kept(sprung: bool) -> None:
    """Forty random chains with one form for all their links, against the dense mechanics in 30 digits."""
    rng, found = np.random.default_rng(11), 0
    while found < 40:
        scene = random_chain(rng, sprung)
        if not mobilities.suits(scene):
            continue
        found += 1
        hard = Hard(scene, state(scene, rng))
        program = lower_function(derive(scene), "forward_dynamics", "loops")
        given = {array.name: hard.inputs[array.name] for array in program.inputs}
        error = relative_error(evaluate(program, given)["a"].tolist(), hard.truth())
        assert error < 2e-14 or error < 10 * hard.attainable(), (error, scene)


@pytest.mark.parametrize(("links", "most"), [(1, 36), (2, 190), (5, 850), (10, 1950), (32, 6800)])
def test_a_link_takes_220_operations(links: int, most: int) -> None:
    """An expert's articulated recursion in symbols takes 259 a link after common subexpressions are shared."""
    on_cart = chain(links, 0.5, base="cart", cart_mass=0.5)
    assert operations(chain(links, 0.5)) <= most
    assert operations(on_cart, "unrolled") <= most + 12


def test_divisions_do_not_wait_for_one_another() -> None:
    """Three a link, of numbers that are ready together: det T, E and D."""
    counts = count_operations(lower_function(derive(chain(16, 0.5)), "forward_dynamics", "loops"))
    assert counts["div"] <= 3 * 15


def test_unequal_links_cost_little_more() -> None:
    rng = np.random.default_rng(3)
    mass, length = rng.uniform(0.8, 1.2, (2, 16))
    unequal = chain(16, 0.5, mass=mass.tolist(), length=length.tolist(), com=(0.6 * length).tolist())
    assert operations(unequal) <= 250 * 16
