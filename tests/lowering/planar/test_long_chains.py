"""Long chains: what links differ by from their neighbours is read forwards, and no turn of such a loop waits for the one before."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate
from phichain.ir.nodes import For, Program, Store, walk
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.planar.test_both_ends import chain


def program(scene: Scene, name: str) -> Program:
    return lower_function(derive(scene), name, "loops")


@pytest.mark.parametrize("more", [{}, {"base": "cart", "cart_mass": 2.0}, {"mass": "runtime"}, {"com": None}], ids=["fixed", "cart", "runtime", "tip masses"])
@pytest.mark.parametrize("links", [15, 16, 33])
def test_inverse_dynamics_gives_the_torques_back(links: int, more: dict[str, Any]) -> None:
    """On both sides of the length from which neighbours are read; the inverse dynamics sums torques from the tip."""
    scene = chain(links, actuated="all", want=("forward_dynamics", "inverse_dynamics"), **more)
    rng = np.random.default_rng(links)
    given = {"q": rng.uniform(-2, 2, scene.nq), "v": rng.uniform(-1, 1, scene.nv), "u": rng.uniform(-1, 1, scene.nu)}
    known = {name: rng.uniform(0.5, 2.0, links) for name in scene.runtime}
    a = evaluate(program(scene, "forward_dynamics"), given | known)["a"]
    back = evaluate(program(scene, "inverse_dynamics"), {"q": given["q"], "v": given["v"], "a": a} | known)["u"]
    size = np.max(np.abs(evaluate(program(scene, "inverse_dynamics"), {"q": given["q"], "v": given["v"], "a": 0 * a} | known)["u"]))
    assert np.max(np.abs(back - given["u"])) <= 1e-12 * max(size, 1)


def test_differences_of_neighbours_carry_nothing() -> None:
    """A loop that hands nothing on is a host's to run on vectors, in the order in which inputs arrive."""
    found = program(chain(24, actuated="all"), "forward_dynamics")
    loops = [s for s in walk(found.body) if isinstance(s, For)]
    for name in ("a", "couple"):
        (loop,) = (loop for loop in loops if any(isinstance(s, Store) and s.cell.array == name for s in loop.body))
        assert not loop.carries and loop.step == 1
