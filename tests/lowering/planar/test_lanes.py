"""Long planar chains, whose two sides are two lanes of one loop: no digit less than by scalars, and proven like everything else."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.emit.c.function import c_function
from phichain.emit.c.handed_on import handed_on
from phichain.emit.c.names import CNames
from phichain.errors import ProofError
from phichain.ir import evaluate
from phichain.ir.nodes import For, Op, Program, Statement, walk
from phichain.lowering import lower, lower_function
from phichain.lowering.dynamics import OF_MANY, OF_PREPARED, form_of_many, form_of_prepared
from phichain.lowering.planar.both_ends import lanes
from phichain.lowering.preparation import preparation
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference
from phichain.scene import Scene
from tests.lowering.planar.test_both_ends import KINDS, chain, depth, forward, from_tip, state
from tests.reference_cases import relative_error

#: Of an even and an odd number of links: the last of an odd number is eliminated ahead of the rows.
LINKS = (16, 17)


def unlike(links: int, **more: Any) -> Scene:
    """Masses at places of their own on links of all lengths: l/r between 1.1 and 5."""
    rng = np.random.default_rng(links)
    length = rng.uniform(0.3, 1.4, links).round(3)
    return chain(links, **{"length": length.tolist(), "com": (length * rng.uniform(0.2, 0.9, links)).round(3).tolist()} | more)


def runtime(scene: Scene, rng: np.random.Generator) -> dict[str, Any]:
    """Runtime parameters of a scene: masses before the links' ends."""
    given = {"mass": (0.5, 2.0), "length": (1.0, 2.0), "com": (0.3, 0.9)}
    return {name: rng.uniform(*given[name], scene.links).tolist() if name in given else 9.0 for name in scene.runtime}


def lanes_of(program: Program) -> list[For]:
    return [s for s in walk(program.body) if isinstance(s, For) and s.is_lanes]


@pytest.mark.parametrize("links", LINKS)
@pytest.mark.parametrize("kind", KINDS)
def test_half_the_depth_of_the_sweep_from_the_tip(kind: str, links: int) -> None:
    """Both sides' operations are counted one by one, though a host does two at once."""
    scene, rng = chain(links, **KINDS[kind]), np.random.default_rng(links)
    assert lanes.suits_prepared(scene) and lanes.suits(scene) == (not scene.runtime)
    found, before = preparation(derive(scene)).whole if scene.runtime else forward(scene), from_tip(scene)
    inputs = state(scene, rng, "any") | runtime(scene, rng)
    assert len(lanes_of(found)) == 1
    assert depth(found) < 0.58 * depth(before)
    assert relative_error(evaluate(found, inputs)["a"].tolist(), evaluate(before, inputs)["a"].tolist()) < 2e-13


@pytest.mark.parametrize("links", LINKS)
def test_places_on_links_of_all_kinds(links: int) -> None:
    scene, rng = unlike(links, base="cart", cart_mass=1.5), np.random.default_rng(links)
    assert lanes.suits(scene)
    inputs = state(scene, rng, "any")
    truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
    assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 2e-14


@pytest.mark.parametrize("shape", ["any", "of all sizes", "right"])
@pytest.mark.parametrize("kind", ["plain", "torques", "cart, torques, springs, dampers"])
def test_masses_over_eight_decades_keep_all_digits(kind: str, shape: str) -> None:
    """Within the bound of the shorter chains in `test_both_ends`."""
    rng = np.random.default_rng(17)
    scene = chain(17, **{**KINDS[kind], "mass": (10 ** rng.uniform(-4, 4, 17)).tolist(), "angles": "relative"})
    assert lanes.suits(scene)
    inputs = state(scene, rng, shape)
    truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
    assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 1e-13


@pytest.mark.parametrize("place", [1e-8, 1e-3, 1 - 1e-8])
def test_masses_anywhere_on_their_links(place: float) -> None:
    scene, rng = chain(16, length=1.0, com=place, mass=0.7, actuated="all"), np.random.default_rng(16)
    assert lanes.suits(scene)
    inputs = state(scene, rng, "any")
    truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
    assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 2e-14


@pytest.mark.parametrize("more", [{"trig": "bundled"}, {"code": "unrolled"}, {"com": None}], ids=["target", "straight line", "tip masses"])
def test_where_no_vector_does_both_lanes_there_are_none(more: dict[str, Any]) -> None:
    scene = chain(16, **more)
    assert not lanes.suits(scene)
    assert not lanes_of(lower_function(derive(scene), "forward_dynamics", scene.code))
    assert not lanes.suits(chain(15))


def test_runtime_parameters_are_in_lanes_where_they_are_prepared() -> None:
    """Tables for both lanes cost more at every call than lanes gain."""
    free = {"mass": "runtime", "length": "runtime", "com": "runtime"}
    scene, short = chain(16, **free), chain(15, **free)
    assert form_of_prepared(scene) == OF_PREPARED and form_of_prepared(short) == form_of_prepared(chain(16, mass="runtime", com=None)) == "forward_dynamics"
    assert lanes_of(preparation(derive(scene)).rest) and not lanes_of(preparation(derive(short)).rest)
    assert not lanes_of(lower_function(derive(scene), "forward_dynamics"))


def test_many_states_at_once_fill_the_vectors_themselves() -> None:
    model = derive(chain(16))
    assert form_of_many(model.scene) == OF_MANY
    assert form_of_many(chain(15)) == "forward_dynamics"
    assert not lanes_of(lower_function(model, OF_MANY, "loops"))


def test_what_one_row_hands_to_the_next_is_one_row() -> None:
    """Read ahead of everything that is written, and written last; whatever the way back reads keeps all rows."""
    program = forward(chain(17, actuated="all"))
    one_row = handed_on(program)
    assert {name.removeprefix("left_") for name in one_row} == {
        "axial", "skew", "across", "inverse", "determinant", "force_x", "force_y", "minor_x", "minor_y",
    }  # fmt: skip
    lines = [line.strip() for line in c_function(program, CNames("a", "double", {("lane_sign", v): "s" for v in program.tables.values()} | {(n, v): n for n, v in program.tables.items()}), {}).lines]
    assert "a_real left_axial[2];" in lines and "a_real row_free[16];" in lines
    start = lines.index("A_LANES")
    turn = lines[start : lines.index("}", start)]
    read = max(i for i, line in enumerate(turn) if line.endswith("[lane];") and "left_" in line)
    written = [i for i, line in enumerate(turn) if line.startswith("left_")]
    assert len(written) == len(one_row) and read < min(i for i, line in enumerate(turn) if line.startswith("row_")) < min(written)


def test_an_array_of_which_another_row_is_read_keeps_all_rows() -> None:
    program = forward(chain(16))
    (row,) = (s for s in program.body if isinstance(s, For) and any(isinstance(inner, For) for inner in s.body))
    (lane,) = lanes_of(program)
    reading = next(s for s in lane.body if isinstance(s, Op) and any(getattr(arg, "array", "") == "left_force_x" for arg in s.args))
    cell = next(arg for arg in reading.args if getattr(arg, "array", "") == "left_force_x")
    farther = replace(reading, args=tuple(replace(arg, index=arg.index + -2) if arg == cell else arg for arg in reading.args))
    body = tuple(farther if s is reading else s for s in lane.body)
    changed = replace(program, body=tuple(replace(row, body=(replace(lane, body=body),)) if s is row else s for s in program.body))
    assert set(handed_on(program)) - set(handed_on(changed)) == {"left_force_x"}


def test_a_wrong_sign_in_a_lane_is_no_proof() -> None:
    """Every twelfth operation of the lanes made the other one: each is refused."""
    model = derive(unlike(16, actuated="all", length=1.0, com=0.4))
    lowered = lower(model)
    right = lowered.wanted["forward_dynamics"]
    (lane,) = lanes_of(right)
    others = {"add": "sub", "sub": "add", "mul": "add"}
    chosen = [s for s in lane.body if isinstance(s, Op) and s.kind in others][::12]
    assert len(chosen) >= 4
    for op in chosen:
        wrong = replace(right, body=_changed(right.body, op, replace(op, kind=others[op.kind])))
        with pytest.raises(ProofError, match="forward_dynamics"):
            prove(model, replace(lowered, wanted={**lowered.wanted, "forward_dynamics": wrong}))


def _changed(statements: tuple[Statement, ...], op: Op, other: Op) -> tuple[Statement, ...]:
    return tuple(
        replace(s, body=_changed(s.body, op, other)) if isinstance(s, For) else other if s is op else s for s in statements
    )
