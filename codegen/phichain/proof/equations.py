"""The equations that a Model shows, against its own Lagrangian: M, N, G and the joints' terms of (15) or (16), and both their sides.

No Program is made of them, but people read them. They are written out in N^2 terms, so longer chains than `WRITTEN_OUT` are left to
the tests of `mechanics`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import sympy

from phichain.errors import ProofError
from phichain.ir.nodes import Array
from phichain.mechanics import Model
from phichain.proof.lagrange import Judge, runtime_cells
from phichain.proof.modular.compiled import Compiled, compiled
from phichain.proof.modular.field import PRIME, Vector, dot
from phichain.proof.modular.points import Point
from phichain.proof.modular.symbolic import as_program, cells
from phichain.proof.positions import Chain

WRITTEN_OUT: Final = {"planar": 6, "spatial": 4}
"""The longest chains whose shown equations are held: writing those of longer ones costs more than all other proofs."""

_REMEDY: Final = "nothing was written: derive the model from its scene anew"


def check_equations(model: Model, judge: Judge, chains: Sequence[Chain], params: Sequence[Array]) -> None:
    """Hold what a Model shows at every point: virtual work of each term along random rates.

    Args:
        model: whose equations.
        judge: its Lagrangian.
        chains: the points.
        params: fields of the scene's runtime parameters.

    Raises:
        ProofError: a term is not the Lagrangian's.
    """
    if model.scene.links > WRITTEN_OUT[model.scene.space]:
        return
    shown = _compiled(model, params)
    for chain in chains:
        point, a = chain.point, chain.point.tangent("shown a")
        made = {name: parts[0] for name, parts in shown(point.given(a=a), point).items()}
        turn, other = point.tangent("shown turn"), point.tangent("shown other")
        made["mass_matrix"] = [dot(made["mass_matrix"][i : i + len(turn)], other) for i in range(0, len(turn) ** 2, len(turn))]
        for name, true in _true(judge, point, a, turn, other).items():
            if (dot(made[name], turn) - true) % PRIME:
                raise _wrong(model, name, f"is not what the Lagrangian says, at random point {point.number}", point.number)


def _true(judge: Judge, point: Point, a: Vector, turn: Vector, other: Vector) -> dict[str, int]:
    """What each term's work along `turn` must be, the mass matrix times `other`."""
    still = judge.work(point, judge.motion(point), turn)
    return {
        "mass_matrix": judge.kinetic_form(point, judge.turned(point, turn), judge.turned(point, other)),
        "coriolis": still.inertia,
        "gravity_torque": still.weight,
        "joint_torque": still.potential - still.weight + still.dampers,
        "equations": judge.balance(point, judge.motion(point, a=a), turn),
    }


def _compiled(model: Model, params: Sequence[Array]) -> Compiled:
    scene, symbols, exact = model.scene, model.symbols, model.exact
    sizes = {"q": (symbols.q, scene.nq), "v": (symbols.v, scene.nv), "a": (symbols.a, scene.nv), "u": (symbols.u, scene.nu)}
    inputs = [Array(name, (size,)) for name, (_, size) in sizes.items() if size]
    known = runtime_cells(scene)
    for array in inputs:
        known |= cells(array, sizes[array.name][0])
    rows: dict[str, tuple[Callable[[], Sequence[sympy.Expr]], int]] = {
        "mass_matrix": (lambda: list(exact.mass_matrix), scene.nv**2),
        "coriolis": (lambda: list(exact.coriolis), scene.nv),
        "gravity_torque": (lambda: list(exact.gravity_torque), scene.nv),
        "joint_torque": (lambda: list(exact.joint_torque), scene.nv),
        "equations": (lambda: [equation.lhs - equation.rhs for equation in exact.equations], scene.nv),
    }
    outputs = {}
    for name, (entries, count) in rows.items():
        try:
            outputs[name] = list(map(sympy.sympify, entries()))
        except (TypeError, ValueError, AttributeError, IndexError) as failure:
            raise _wrong(model, name, f"cannot be written, {failure}", 0) from failure
        if len(outputs[name]) != count:
            raise _wrong(model, name, f"has {len(outputs[name])} entries, not {count}", 0)
    return compiled(as_program("equations", [*inputs, *params], known, (), outputs))


def _wrong(model: Model, what: str, problem: str, number: int) -> ProofError:
    return ProofError(
        f"{model.scene.name}: {what} as shown", "another value", problem, _REMEDY,
        function="", output=what, point=number, digest=model.scene.digest,
    )  # fmt: skip
