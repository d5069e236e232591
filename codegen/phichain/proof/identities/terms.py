"""The terms of the equations of motion, energies, momenta and positions, each against its definition by the Lagrangian."""

from __future__ import annotations

from phichain.proof.case import Case, proves
from phichain.proof.modular.field import PRIME, Vector, dot


@proves("mass_matrix")
def mass_matrix(case: Case) -> None:
    """eta M alpha is the bilinear form of 2 T; the matrix of (16) has c_kk I_3 on its diagonal, also along the links."""
    point, judge, nv = case.point, case.judge, case.scene.nv
    matrix, alpha = case.run()["out"], point.free("alpha")
    column = [dot(matrix[i * nv : (i + 1) * nv], alpha) for i in range(nv)]

    def residual(turn: Vector) -> int:
        form = judge.kinetic_form(point, judge.turned(point, turn), judge.turned(point, alpha))
        return dot(column, turn) - form - _along_links(case, turn, alpha)

    case.zero("a row of out, out", residual, point.free("turn"))


def _along_links(case: Case, one: Vector, other: Vector) -> int:
    """sum c_kk (q_k.one_k) (q_k.other_k): rotations about a link move nothing, and the matrix of (16) counts them."""
    if case.scene.is_planar:
        return 0
    total = 0
    for k, (moment, link) in enumerate(zip(case.chain.moments, case.point.links, strict=True)):
        at = slice(case.point.carts + 3 * k, case.point.carts + 3 * k + 3)
        total += moment * dot(link, one[at]) % PRIME * dot(link, other[at])
    return total


@proves("coriolis")
def coriolis(case: Case) -> None:
    """Inertial forces of a chain without accelerations."""
    point, judge, out = case.point, case.judge, case.run()["out"]
    motion = judge.motion(point)
    case.zero("out", lambda turn: judge.work(point, motion, turn).inertia - dot(out, turn), point.free("turn"))


@proves("gravity_torque")
def gravity_torque(case: Case) -> None:
    """The gradient of gravity's part of V."""
    point, judge, out = case.point, case.judge, case.run()["out"]
    motion = judge.motion(point)
    case.zero("out", lambda turn: judge.work(point, motion, turn).weight - dot(out, turn), point.free("turn"))


@proves("energy")
def energy(case: Case) -> None:
    """T and V themselves."""
    true, found = case.judge.energies(case.point), case.run()
    case.same("kinetic", found["kinetic"], true["kinetic"])
    case.same("potential", found["potential"], true["potential"])


@proves("momentum")
def momentum(case: Case) -> None:
    """The gradient of T by the rates."""
    point, judge, out = case.point, case.judge, case.run()["out"]
    motion = judge.motion(point)
    case.zero(
        "out", lambda turn: judge.momentum(point, motion, judge.turned(point, turn)) - dot(out, turn), point.free("turn")
    )


@proves("positions")
def positions(case: Case) -> None:
    """The positions that T and V are made of."""
    case.same("out", case.run()["out"], case.judge.energies(case.point)["positions"])


@proves("project")
def project(case: Case) -> None:
    """q_k / |q_k| and the part of omega_k across it, for vectors whose lengths are known in the field."""
    point, carts = case.point, case.point.carts
    _, q = point.long_links
    v = point.free("v")
    found = case.run(point.given(q=q, v=v))
    unit = [*q[:carts], *(entry for link in point.links for entry in link)]
    across = v[:carts]
    for k, link in enumerate(point.links):
        turn = v[carts + 3 * k : carts + 3 * k + 3]
        across += [(a - dot(link, turn) * b) % PRIME for a, b in zip(turn, link, strict=True)]
    case.same("q_out", found["q_out"], unit)
    case.same("v_out", found["v_out"], across)

