"""The sparsity of Jacobians, read off a Program that may have loops."""

from __future__ import annotations

import pytest

from phichain.ir.builder import Builder
from phichain.ir.inline import inline
from phichain.ir.passes import unroll
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform.pattern import jacobian_pattern
from phichain.transform.tangent import Block, jacobian, sparsity
from tests.emit.casadi_scenes import SCENES
from tests.offered import DERIVATIVES


def test_dependence_passes_through_loops_and_stops_at_structural_zeros() -> None:
    b = Builder("f", "")
    gain, x, out = b.param("gain", ()), b.input("x", (3,)), b.output("out", (3,))
    zeros = b.table("zeros", 3, lambda k: b.lift(1 if k == 1 else 0))
    with b.loop("k", 0, 3) as loop:
        total = loop.carry("total", 0)
        following = total + zeros[loop.index] * gain[0] + x[loop.index]
        out[loop.index] = total
        loop.follow(total, following)
    pattern = jacobian_pattern(b.finish())
    assert pattern["out", "x"] == ((1, 0), (2, 0), (2, 1))
    assert pattern["out", "gain"] == ((2, 0),)


@pytest.mark.long
@pytest.mark.parametrize("scene", SCENES[::3], ids=lambda scene: scene.name)
def test_it_is_that_of_the_straight_line_tangent(scene: Scene) -> None:
    """Terms that cancel are seen by straight-line code alone, so elsewhere the pattern may hold more."""
    equal = {"forward_dynamics", "gravity_torque", "positions", "project"}
    for name in scene.want:
        if name in DERIVATIVES or name.startswith("step"):
            continue
        program = inline(lower_function(derive(scene), name, "loops"))
        arguments = (*program.params, *program.inputs)
        blocks = [Block(o.name, a.name, f"{o.name} {a.name}") for o in program.outputs for a in arguments]
        exact = sparsity(jacobian(unroll(program), "tangent", "", blocks))
        sizes = {array.name: array.size for array in arguments}
        for (output, argument), cells in jacobian_pattern(program).items():
            flat = {row * sizes[argument] + column for row, column in cells}
            found = set(exact[f"{output} {argument}"])
            assert found <= flat, (name, output, argument)
            assert found == flat or name not in equal, (name, output, argument)
