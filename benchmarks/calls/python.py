"""From Python: a bound call, simulate over its own steps and on 101 times, beside the C underneath and the peers' own calls."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from benchmarks import plan
from benchmarks.chains import chain_of, planar_chain, random_states, scene_table
from benchmarks.contest import Maker, Runner, Work, contest, detail, summary
from benchmarks.flows.cases import Motion, error, motion
from benchmarks.peers import present, recursions
from benchmarks.reference import accelerations, relative_error
from benchmarks.table import Table

HEADING = "Calls from Python"
LINKS = (2, 1, 8)
TOLERANCE = 1e-12
STEPS_REACH = {1: "1.5", 2: "1.5", 8: "1.1"}


def bound(links: int, run: plan.Plan) -> Work:
    """Accelerations of one state, arrays in and out."""
    chain = chain_of("planar", links, False)
    state = random_states(chain, 1)[0]
    q, v = state[:links].copy(), state[links:].copy()
    exact = accelerations(chain, state)

    def runner(who: str, call: Callable[[], object], kind: str = "peer") -> Runner:
        found = np.asarray(call(), dtype=float).ravel()
        return Runner(who, call, relative_error(found[None], exact[None]), kind)

    def ours() -> Runner:
        from phichain import build
        from phichain.scene import scene_from_dict

        function = build(scene_from_dict(scene_table(chain))).function("forward_dynamics")
        return runner("phichain", lambda: function(q, v), "ours")

    def heyoka() -> Runner:
        function = present.module("benchmarks.peers.heyoka.cfunc").compiled(chain, recursions.forms(chain)[0])
        out = np.empty(links)
        return runner("heyoka cfunc", lambda: function(state, outputs=out))

    def casadi() -> Runner:
        function = present.module("benchmarks.peers.casadi_recursion").expert_function(chain)
        return runner("CasADi Function (virtual machine)", lambda: function(state, []))

    def mujoco() -> Runner:
        peer = present.module("mujoco")
        module = present.module("benchmarks.peers.mujoco_forward")
        model = peer.MjModel.from_xml_string(module.xml(chain))
        data = peer.MjData(model)

        def call() -> object:
            data.qpos[:], data.qvel[:] = q, v
            peer.mj_forward(model, data)
            return data.qacc.copy()

        return runner("MuJoCo mj_forward", call)

    makers: list[tuple[str, Maker]] = [
        ("phichain", ours), ("heyoka cfunc", heyoka), ("CasADi Function", casadi), ("MuJoCo", mujoco),
    ]  # fmt: skip
    return contest(f"forward_dynamics, P, N = {links}: one call", makers, run.rounds, run.budget, "us")


def trajectory(links: int, on_times: bool, run: plan.Plan) -> Work:
    """`simulate` against the flow's C underneath (one propagate over the span, the yardstick) and heyoka's propagate_grid."""
    whole = motion(f"planar N = {links}")
    m = Motion(whole.name, planar_chain(links, forced=False), 10.0 if links < 8 else 2.0, whole.forms)
    (q,), (v,) = m.starts(1)
    times = np.linspace(0.0, m.span, 101)

    def ours() -> list[Runner]:
        from phichain import build
        from phichain.motion import simulate

        system = build(m.scene(("propagate", "forward_dynamics", "energy", "state_jacobian")))
        flow = system.function("propagate")
        span = times if on_times else (0.0, m.span)
        run_it = lambda: simulate(system, (q, v), span, method="taylor", tol=TOLERANCE)
        plain = partial(flow, q, v, 0.0, m.span, TOLERANCE, times=times if on_times else ())
        off = float(np.max(np.abs(run_it().x[-1][:links] - plain().q)))
        return [
            Runner("phichain simulate", run_it, off, "ours"), Runner("phichain's C flow, one call", plain, 0.0),
            Runner("phichain simulate, its status read", lambda: run_it().status, off, "hybrid"),
            Runner("phichain simulate, every field read", lambda: run_it().settle(), off, "hybrid"),
        ]  # fmt: skip

    def heyoka() -> Runner:
        peer = present.module("benchmarks.peers.heyoka.flows")
        flow, start = peer.integrator(m.chain, m.forms[0], q, v, TOLERANCE)

        def call() -> object:
            flow.time = 0.0
            flow.state[:] = start
            return flow.propagate_grid(times)[5]

        return Runner("heyoka propagate_grid, 101 times", call, kind="hybrid")

    makers: list[tuple[str, Maker]] = [("phichain", ours), ("heyoka", heyoka)] if on_times else [("phichain", ours)]
    what = "101 times" if on_times else "its own steps"
    reach = ("1.2" if links == 8 else "") if on_times else STEPS_REACH[links]
    return contest(f"simulate on {what}, P, N = {links}, {m.span:g} s", makers, run.rounds, run.budget, "us", reach)


def one_link(run: plan.Plan) -> Work:
    """A short flow of one link from Python: the whole call counts."""
    m = motion("planar N = 1")
    (q, *_), (v, *_) = m.starts()

    def ours() -> list[Runner]:
        from phichain import build

        flow = build(m.scene(("propagate",))).function("propagate")
        call, bound, start = lambda: flow(q, v, 0.0, 1.0, 1e-15), flow.bind(1e-15), np.concatenate([q, v])
        off = error(m.name, flow(q, v, 0.0, m.span, 1e-15).q)

        def again() -> float:
            bound.state[:] = start
            return bound(0.0, 1.0)

        return [Runner("phichain, bound", again, off, "ours"), Runner("phichain", call, off, "hybrid")]

    def heyoka() -> Runner:
        flow = present.module("benchmarks.peers.heyoka.flows").one(m.chain, "link frame", False, q, v, 1e-15)
        return Runner("heyoka", partial(flow, 1.0), error(m.name, flow(m.span)))

    makers: list[tuple[str, Maker]] = [("phichain", ours), ("heyoka", heyoka)]
    return contest("N = 1: 1 s at 1e-15 (error: after 100 s)", makers, run.rounds, run.budget, "us", "0.8")


def tables(run: plan.Plan) -> list[Table]:
    """Calls, trajectories, every row."""
    calls = [*(bound(n, run) for n in run.few(LINKS)), one_link(run)]
    paths = [trajectory(n, on_times, run) for on_times in (False, True) for n in run.few(LINKS)]
    notes = ("Bound once, called with arrays that are there; a call of ours is to stay below 5 us.",)
    flow = (
        "The yardstick is phichain's own flow over the same span in one call (with the same output times): a ratio of 1 is free.",
        "What `simulate` computes when it is read (verdict, energies, accelerations) stands in rows of its own.",
    )
    return [
        summary("One call", calls, notes),
        summary("simulate over the flow underneath", paths, flow),
        detail("Everybody", [*calls, *paths]),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("python_calls", "benchmarks.calls.python", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
