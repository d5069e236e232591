"""Planar Jacobians from one factorisation: their operations, their digits where masses spread, both shapes, both functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.errors import ProofError
from phichain.ir import evaluate, total_operations
from phichain.ir.builder import Builder
from phichain.ir.nodes import For, Local, Op, Program
from phichain.lowering import lower, lower_function
from phichain.lowering.planar import jacobian as planar_jacobian
from phichain.lowering.planar.disturbances import Disturbance
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian
from tests.lowering.hard_chains import SPREADS
from tests.reference_cases import relative_error

WANT = ("state_jacobian", "dynamics_and_jacobian")


def chain(links: int, **more: Any) -> Scene:
    """No two links alike, torques at every joint."""
    some = np.random.default_rng(links)
    mass, length = np.exp(some.uniform(-1, 1, links)), some.uniform(0.3, 1.4, links)
    keys: dict[str, Any] = {"mass": mass.tolist(), "length": length.tolist(), "com": (0.6 * length).tolist(), "actuated": "all"}
    return Scene("some", links, **(keys | {"want": WANT} | more))


def arguments(scene: Scene, seed: int = 1) -> dict[str, Any]:
    some = np.random.default_rng(seed)
    drawn = {"q": some.uniform(-3, 3, scene.nv), "v": some.standard_normal(scene.nv), "u": some.standard_normal(scene.nu)}
    return {name: values for name, values in drawn.items() if values.size}


def differentiated(scene: Scene) -> Program:
    """The forward dynamics in loops, differentiated by the transform."""
    blocks = [Block("a", name, f"dad{name}") for name in ("q", "v", "u")[: 2 + (scene.nu > 0)]]
    return jacobian(lower_function(derive(scene), "forward_dynamics", "loops"), "state_jacobian", "", blocks)


@pytest.mark.parametrize("links", [8, 16, 32])
def test_an_entry_of_all_three_takes_24_operations(links: int) -> None:
    """And a link 230 more; the differentiated sweeps took 200 an entry."""
    found = lower_function(derive(chain(links)), "state_jacobian", "loops")
    assert total_operations(found) <= 24 * links**2 + 230 * links


def waits(loop: For) -> int:
    """The most operations that a carried value of a loop goes through in one turn."""
    depth: dict[str, int] = {carry.name: 0 for carry in loop.carries}
    for op in (statement for statement in loop.body if isinstance(statement, Op)):
        reached = [depth[arg.name] for arg in op.args if isinstance(arg, Local) and arg.name in depth]
        if reached:
            depth[op.result] = 1 + max(reached)
    return max(depth.get(carry.following.name, 0) for carry in loop.carries if isinstance(carry.following, Local))


@pytest.mark.parametrize("more", [{}, {"base": "cart", "cart_mass": 1.2, "actuated": "cart"}, {"angles": "absolute"}])
def test_accelerations_wait_for_three_operations_a_joint(more: dict[str, Any]) -> None:
    """Outwards by the columns' own matrices; the sweep's elimination and turn take six. In relative angles rates share that loop."""
    found = lower_function(derive(chain(16, **more)), "state_jacobian", "loops")
    outwards = [s for s in found.body if isinstance(s, For) and any("before_x" in carry.name for carry in s.carries)]
    assert [waits(loop) for loop in outwards] == [3]
    assert len(outwards[0].carries) == (2 if more.get("angles") == "absolute" else 4)


@pytest.mark.parametrize(
    ("more", "most"),
    [
        ({"base": "cart", "cart_mass": 1.2, "actuated": "cart"}, 32000), ({"angles": "absolute", "actuated": "none"}, 24700), ({"angles": "adjacent"}, 29700),
        ({"stiffness": "runtime", "damping": "runtime"}, 32700), ({"mass": "runtime", "length": "runtime", "com": "runtime"}, 32700),
        ({"com": None}, 22700),
    ],
)  # fmt: skip
def test_every_kind_of_chain_has_the_gain(more: dict[str, Any], most: int) -> None:
    found = lower_function(derive(chain(32, **more)), "state_jacobian", "loops")
    assert total_operations(found) <= most


@pytest.mark.parametrize(("links", "code"), [(2, "unrolled"), (5, "unrolled"), (8, "loops"), (32, "loops")])
def test_auto_takes_the_form_of_fewer_operations(links: int, code: str) -> None:
    scene = chain(links)
    found = lower(derive(scene)).wanted["state_jacobian"]
    assert found.is_straight_line == (code == "unrolled")
    assert total_operations(found) < total_operations(differentiated(scene))


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("place", [0.5, 1 - 1e-8, None])
@pytest.mark.parametrize("spread", ["heavy tip", "heavy in turn", "heavier outwards"])
def test_masses_that_spread_cost_no_digit(spread: str, place: float | None, base: str) -> None:
    """As accurate as the differentiated sweeps, eight and sixteen decades apart."""
    mass, length = (values.tolist() for values in SPREADS[spread](6))
    more = {} if base == "fixed" else {"base": "cart", "cart_mass": 1.0, "actuated": "cart"}
    com = None if place is None else [place * entry for entry in length]
    scene = chain(6, mass=mass, length=length, com=com, **more)
    programs = lower_function(derive(scene), "state_jacobian", "loops"), differentiated(scene)
    given = arguments(scene)
    exact = reference(scene, "state_jacobian", given)
    ours, before = ([relative_error(np.asarray(out[name]).ravel().tolist(), np.ravel(exact[name]).tolist())
                     for name in out] for out in (evaluate(program, given) for program in programs))  # fmt: skip
    for new, old in zip(ours, before, strict=True):
        assert new <= max(8 * old, 2e-14)


def test_masses_at_the_ends_on_a_cart_keep_the_tension_form_where_they_spread() -> None:
    more = {"base": "cart", "cart_mass": 1.0, "com": None, "actuated": "cart"}
    even, uneven = (chain(6, mass=mass, **more) for mass in ([1.0] * 6, np.logspace(-8, 8, 6).tolist()))
    counts = [total_operations(lower_function(derive(scene), "state_jacobian", "loops")) for scene in (even, uneven)]
    assert counts[0] < counts[1] == total_operations(differentiated(uneven))


@pytest.mark.long
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_two_rows_of_memory_serve_long_chains(angles: str, base: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs, dampers and lists of joints among them; N even and odd."""
    for links in (5, 6):
        more: dict[str, Any] = {"actuated": [1, 3]} if angles == "relative" else {"actuated": "all"}
        more |= {"base": "cart", "cart_mass": 1.3} if base == "cart" else {}
        scene = chain(links, angles=angles, stiffness=[1.5] * links, damping=[0.3] * links, **more)
        given = arguments(scene)
        kept = evaluate(lower_function(derive(scene), "state_jacobian", "loops"), given)
        monkeypatch.setattr(planar_jacobian, "LONGEST_KEPT", 3)
        program = lower_function(derive(scene), "state_jacobian", "loops")
        monkeypatch.undo()
        assert any(array.name.startswith("couple_state_odd") for array in program.work)
        for name, values in evaluate(program, given).items():
            assert np.array_equal(values, kept[name])
        exact = reference(scene, "state_jacobian", given)
        for name, values in kept.items():
            assert relative_error(values.ravel().tolist(), np.ravel(exact[name]).tolist()) < 3e-15


def test_memory_of_a_long_chain_grows_as_its_links() -> None:
    sizes = [sum(a.size for a in lower_function(derive(chain(n)), "state_jacobian", "loops").work) for n in (49, 98)]
    assert sizes[1] <= 2 * sizes[0]


@pytest.mark.parametrize("more", [{}, {"base": "cart", "cart_mass": 1.2, "angles": "absolute", "damping": [0.2] * 9}])
def test_dynamics_and_jacobian_are_both(more: dict[str, Any]) -> None:
    scene = chain(9, **more)
    given, programs = arguments(scene), {name: lower_function(derive(scene), name, "loops") for name in (*WANT, "forward_dynamics")}
    found, slopes, a = (evaluate(programs[name], given) for name in ("dynamics_and_jacobian", "state_jacobian", "forward_dynamics"))
    assert np.allclose(found["a"], a["a"], rtol=1e-12, atol=1e-12 * np.max(np.abs(a["a"])))
    assert all(np.array_equal(found[name], slopes[name]) for name in slopes)
    both = total_operations(programs["state_jacobian"]) + total_operations(programs["forward_dynamics"])
    assert total_operations(programs["dynamics_and_jacobian"]) < both - 9 * 30


@pytest.mark.parametrize("links", [4, 9])
def test_a_wrong_sign_anywhere_is_refused(links: int) -> None:
    """Every addition turned into a subtraction in turn, in loops and rows alike (some of many)."""
    scene = chain(links, code="loops", want=["state_jacobian"])
    model = derive(scene)
    lowered = lower(model)
    prove(model, lowered)
    program = lowered.wanted["state_jacobian"]
    places = [i for i, op in enumerate(_ops(program.body)) if op.kind == "add"]
    for place in places[:: max(1, len(places) // 12)]:
        wrong = replace(program, body=_flipped(program.body, [place]))
        with pytest.raises(ProofError):
            prove(model, replace(lowered, wanted={"state_jacobian": wrong}))


def _ops(body: Any) -> list[Op]:
    found: list[Op] = []
    for statement in body:
        found += [statement] if isinstance(statement, Op) else _ops(statement.body) if isinstance(statement, For) else []
    return found


def _flipped(body: Any, left: list[int]) -> Any:
    out = []
    for statement in body:
        if isinstance(statement, For):
            statement = replace(statement, body=_flipped(statement.body, left))
        elif isinstance(statement, Op):
            if left[0] == 0:
                statement = replace(statement, kind="sub")
            left[0] -= 1
        out.append(statement)
    return tuple(out)


def test_what_was_nothing_and_is_written_again_is_no_longer_nothing() -> None:
    builder = Builder("f", "")
    found = Disturbance(builder, "push", 2, ["zeta"])
    found.put(0, zeta=builder.lift(0))
    assert found.get("zeta", 0).is_zero
    found.put(0, zeta=builder.lift(2))
    assert not found.get("zeta", 0).is_zero
