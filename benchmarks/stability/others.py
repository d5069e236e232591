"""The peers on a case, as their users would run them: heyoka, MuJoCo, Pinocchio, CasADi with a dense solve."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks.chains import GRAVITY, Chain
from benchmarks.harness import BenchmarkError
from benchmarks.peers import present
from benchmarks.stability.cases.case import Case
from benchmarks.stability.ours import same_side
from benchmarks.stability.references import Reference, gap, relative_gap
from benchmarks.stability.verdict import Answer
from phichain.scene import Scene

MUJOCO_STEP = 1e-4
ABSENT = "absent"
Peer = Callable[[Case, Reference], Answer]


def _heyoka(tolerance: float) -> Peer:
    def run(case: Case, known: Reference) -> Answer:
        import heyoka as hy

        from benchmarks.peers.heyoka.taylor import equations, form_of

        scene = case.plain()
        form = form_of(scene)
        if case.kind == "period":
            return _heyoka_period(case, known, scene)
        start, stop = absolute(scene, form)
        flow = hy.taylor_adaptive(
            equations(scene, form),
            start(np.array([*case.q, *case.v])),
            tol=tolerance,
            compact_mode=scene.links > 1,
        )
        rows, steps = [], 0
        for t in case.times:
            outcome = flow.propagate_until(t)
            steps += int(outcome[3])
            if outcome[0] != hy.taylor_outcome.time_limit:
                return Answer("unfinished", said=str(outcome[0]))
            rows.append(stop(np.array(flow.state)).tolist())
        errors = tuple(gap([a], [b], known.fastest) for a, b in zip(known.rows, rows, strict=True))
        return Answer("ok", "", errors, max(tolerance, 2.0**-52), 0.0, same_side(case, known, rows), steps)

    return run


def _heyoka_period(case: Case, known: Reference, scene: Scene) -> Answer:
    import heyoka as hy

    from benchmarks.peers.heyoka.taylor import equations

    system = equations(scene)
    stop = hy.t_event(system[0][0])
    flow = hy.taylor_adaptive(system, [*case.q, *case.v], t_events=[stop])
    outcome = flow.propagate_until(10 * math.pi / float(known.rows[0][0]))
    omega = math.pi / (2 * flow.time)
    return Answer("ok", "", (relative_gap(known.rows[0], [omega]),), 2.0**-52, steps=int(outcome[3]))


Turn = Callable[[np.ndarray], np.ndarray]


def absolute(scene: Scene, form: str) -> tuple[Turn, Turn]:
    """Into the form's angles and back."""
    if form != "closed form":
        return (lambda x: x), (lambda x: x)
    n, c = scene.links, int(scene.has_cart)

    def halves(change: Turn) -> Turn:
        return lambda x: np.concatenate(
            [part for half in np.split(x, 2) for part in (half[:c], change(half[c : c + n]))]
        )

    return halves(np.cumsum), halves(lambda angles: np.diff(angles, prepend=0.0))


def _mujoco(case: Case, known: Reference) -> Answer:
    import mujoco

    if case.kind == "period":
        raise BenchmarkError("it has no events")
    model = mujoco_model(case.plain(), "RK4")
    if case.kind == "dynamics":
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = case.q, case.v
        mujoco.mj_forward(model, data)
        return Answer("ok", errors=(relative_gap(known.rows[0], data.qacc.tolist()),))

    def at(step: float) -> list[list[float]]:
        data, rows = mujoco.MjData(model), []
        data.qpos[:], data.qvel[:] = case.q, case.v
        done = 0.0
        for t in case.times:
            count = max(1, round((t - done) / step))
            model.opt.timestep = (t - done) / count
            mujoco.mj_step(model, data, count)
            rows.append([*data.qpos, *data.qvel])
            done = t
        return rows

    rows, coarse = at(MUJOCO_STEP), at(2 * MUJOCO_STEP)
    errors = tuple(gap([a], [b], known.fastest) for a, b in zip(known.rows, rows, strict=True))
    steps = round(case.times[-1] / MUJOCO_STEP)
    return Answer(
        "ok", "", errors, 0.0, gap(rows, coarse, known.fastest), same_side(case, known, rows), steps
    )


def mujoco_model(scene: Scene, integrator: str) -> Any:
    """MuJoCo's model of a planar chain on a fixed base.

    Raises:
        BenchmarkError: another kind of chain.
    """
    import mujoco

    return mujoco.MjModel.from_xml_string(_xml(scene, integrator))


def _xml(scene: Scene, integrator: str) -> str:
    """Nested bodies hinged about x, gravity along -z, springs and dampers of the joints."""
    if not scene.is_planar or scene.has_cart:
        raise BenchmarkError(
            "on the sphere and on a cart none of its joints is free of poles or fictitious inertia"
        )
    rest = (0.0,) * scene.links
    opening, closing = [], []
    joints = zip(
        scene.mass, scene.com or scene.length, (0.0, *scene.length), scene.stiffness or rest, scene.damping or rest,
        strict=False,
    )  # fmt: skip
    for mass, com, drop, spring, damper in joints:
        inertia = max(1e-12 * mass * com**2, 2e-15)
        opening.append(
            f'<body pos="0 0 {-drop!r}"><joint type="hinge" axis="1 0 0" stiffness="{spring!r}" damping="{damper!r}"/>'
            f'<inertial mass="{mass!r}" pos="0 0 {-com!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
        )
        closing.append("</body>")
    option = f'<option gravity="0 0 {-scene.gravity!r}" integrator="{integrator}"><flag contact="disable"/></option>'
    return f"<mujoco>{option}<worldbody>{''.join(opening)}{''.join(closing)}</worldbody></mujoco>"


def _pinocchio(case: Case, known: Reference) -> Answer:
    import pinocchio as pin

    scene = case.plain()
    if not scene.is_planar or scene.has_cart:
        raise BenchmarkError("compared on planar chains on a fixed base")
    model, joint = pin.Model(), 0
    model.gravity.linear = np.array([0.0, 0.0, -scene.gravity])
    for k in range(scene.links):
        place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -scene.length[k - 1] if k else 0.0]))
        joint = model.addJoint(joint, pin.JointModelRX(), place, f"joint{k}")
        arm = np.array([0.0, 0.0, -(scene.com or scene.length)[k]])
        model.appendBodyToJoint(joint, pin.Inertia(scene.mass[k], arm, np.zeros((3, 3))), pin.SE3.Identity())
    springs, dampers = (np.array(x or (0.0,) * scene.links) for x in (scene.stiffness, scene.damping))
    q, v = np.array(case.q), np.array(case.v)
    found = pin.aba(model, model.createData(), q, v, -springs * q - dampers * v)
    return Answer("ok", errors=(relative_gap(known.rows[0], found.tolist()),))


def _casadi_recursion(case: Case, known: Reference) -> Answer:
    """The expert's recursion, in the virtual machine: its rounding is that of the emitted C."""
    import casadi as ca

    from benchmarks.peers import recursions

    scene = case.plain()
    if scene.gravity != GRAVITY or scene.stiffness or scene.damping:
        raise BenchmarkError("the peers' formulations have g = 9.81 and free joints")
    com = scene.com or scene.length
    if scene.is_planar and not scene.has_cart:
        chain = Chain("planar", scene.mass, scene.length, com, None, False)  # type: ignore[arg-type]
    elif scene.has_cart and not scene.is_planar and com == scene.length:
        forced = scene.nu > 0
        chain = Chain("spatial", scene.mass, scene.length, com, scene.cart_mass, forced)  # type: ignore[arg-type]
    else:
        raise BenchmarkError("no expert's form at hand for this chain")
    q, v, u = (
        ca.vertsplit(ca.SX.sym(n, k)) if k else []
        for n, k in (("q", scene.nq), ("v", scene.nv), ("u", scene.nu))
    )
    if chain.space == "planar":
        found = recursions.planar_link_frame(chain, q, v, u, ca.sin, ca.cos)
    else:
        found = recursions.spatial_articulated(chain, q, v, u)
    function = ca.Function("f", [ca.vertcat(*q, *v, *u)], [ca.vertcat(*found)])
    values = np.asarray(function([*case.q, *case.v, *case.u])).ravel()
    return Answer("ok", errors=(relative_gap(known.rows[0], values.tolist()),))


MOTION: dict[str, Peer] = {
    "heyoka": _heyoka(0.0),
    "heyoka, 1e-9": _heyoka(1e-9),
    "MuJoCo RK4, 0.1 ms": _mujoco,
}
DYNAMICS: dict[str, Peer] = {
    "Pinocchio aba": _pinocchio,
    "MuJoCo": _mujoco,
    "CasADi, expert's recursion": _casadi_recursion,
}


NEEDS: dict[str, str] = {
    "heyoka": "heyoka", "heyoka, 1e-9": "heyoka", "MuJoCo RK4, 0.1 ms": "mujoco", "Pinocchio aba": "pinocchio",
    "MuJoCo": "mujoco", "CasADi, expert's recursion": "casadi",
}  # fmt: skip
"""Peer -> the module it needs."""


def installed(peers: Mapping[str, Peer]) -> tuple[dict[str, Peer], list[str]]:
    """The peers that are here, and words about each that is not."""
    found, absent = {}, []
    for name, peer in peers.items():
        try:
            present.module(NEEDS[name])
            found[name] = peer
        except present.PeerAbsent as reason:
            absent.append(f"{name}: skipped: {reason}")
    return found, absent


def answer(peer: Peer, case: Case, known: Reference) -> Answer:
    """What a peer says; ABSENT on a chain it is not compared on."""
    try:
        return peer(case, known)
    except BenchmarkError as refusal:
        return Answer(ABSENT, said=str(refusal))
    except (ValueError, RuntimeError, np.linalg.LinAlgError) as failure:
        return Answer(
            "refused", said=str(failure).splitlines()[0] if str(failure) else type(failure).__name__
        )
