"""The solves of variational steps meet the Lagrangian exactly, with rotors too; wrong signs in them are refused."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest

from phichain.errors import ProofError
from phichain.ir.nodes import For, Op, Program, Statement, walk
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.scene import Scene
from tests.lowering.chains import scene

SOLVES = "constrained_accelerations"
BRAKED: dict[str, Any] = {"base": "cart", "cart_mass": 1.0, "cart_friction": 0.2, "cart_friction_speed": 0.1, "cart_damping": 0.1}
BASES: tuple[dict[str, Any], ...] = ({"base": "moving"}, {"base": "cart", "drive": "acceleration"}, BRAKED)


def step(links: int, space: str, base: str, masses: str, joints: str) -> Scene:
    return scene(links, space, base, masses, joints, want=["step_variational"], code="loops")


@pytest.mark.parametrize(
    "chain",
    [
        step(1, "planar", "fixed", "tip", "geared"), step(3, "planar", "cart", "held", "geared"),
        step(3, "planar", "fixed", "runtime", "geared_runtime"), step(2, "planar", "cart", "rigid", "geared_damped"),
        step(3, "planar", "cart", "tip", "free"), step(3, "planar", "fixed", "mid", "damped"),
        step(3, "spatial", "cart", "mid", "damped"), step(2, "spatial", "fixed", "tip", "free"),
        step(2, "spatial", "cart", "runtime_rigid", "free"),
    ],
    ids=lambda chain: f"{chain.space}-{chain.base}-{chain.links}",
)  # fmt: skip
def test_the_solves_are_proven(chain: Scene) -> None:
    assert SOLVES in prove(chain).exact


@pytest.mark.parametrize("keys", BASES, ids=["moving", "driven", "braked"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_over_every_base(space: str, keys: dict[str, Any]) -> None:
    rotors = {"armature": 0.2} if space == "planar" else {}
    chain = Scene("based", 2, space=space, mass=1.0, length=0.5, com=0.3, want=["step_variational"], code="loops", **keys, **rotors)
    assert SOLVES in prove(chain).exact


def turned(program: Program, chosen: Op) -> Program:
    """The Program with one subtraction turned into an addition, or the other way round."""

    def of(statement: Statement) -> Statement:
        if statement is chosen:
            return replace(chosen, kind="add" if chosen.kind == "sub" else "sub")
        return replace(statement, body=tuple(map(of, statement.body))) if isinstance(statement, For) else statement

    return replace(program, body=tuple(map(of, program.body)))


def test_wrong_signs_of_the_geared_sweep_are_refused() -> None:
    """Every ninth of them; all 140 were tried. Rotors and inertia everywhere, so that no term is zero."""
    chain = step(4, "planar", "cart", "runtime_rigid", "geared_runtime")
    model = derive(chain)
    lowered = lower(model)
    program = lowered.helpers[SOLVES]
    sums = [statement for statement in walk(program.body) if isinstance(statement, Op) and statement.kind in ("add", "sub")]
    assert len(sums) > 100
    for chosen in sums[::9]:
        helpers = MappingProxyType({**lowered.helpers, SOLVES: turned(program, chosen)})
        with pytest.raises(ProofError):
            prove(model, replace(lowered, helpers=helpers))
