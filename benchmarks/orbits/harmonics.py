"""Harmonic balance of one link, error against time: a free link's family beside NumPy, a driven one's response beside NumPy and pyHarm."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from scipy.special import ellipkm1

from benchmarks import plan
from benchmarks.contest import Maker, Runner, Work, contest, detail
from benchmarks.peers import present
from benchmarks.peers.harmonics_numpy import Link, driven, followed, free
from benchmarks.table import Table

HEADING = "Harmonic balance"
AMPLITUDE = 2.5
ENDS = (3.0, 5.0)
FREE = Link(0.25, 9.81 * 0.5)
DRIVEN = Link(0.25, 9.81 * 0.5, 0.02, 0.1)


@lru_cache
def system(damping: float | None) -> Any:
    """One link, m = 1, l = 1, com = 1/2."""
    from phichain import Scene, build

    want = ("inverse_and_jacobian", "forward_dynamics", "energy", "propagate")
    more: dict[str, Any] = {} if damping is None else {"damping": damping, "forced": 1, "variational": True}
    return build(Scene("one_link", 1, mass=1.0, length=1.0, com=0.5, actuated="none", want=want, **more))


def family_error(amplitude: np.ndarray, omega: np.ndarray) -> float:
    """Largest relative error of omega against the elliptic integral."""
    exact = np.pi * np.sqrt(FREE.weight / FREE.inertia) / 2 / ellipkm1(np.cos(amplitude / 2) ** 2)
    return float(np.max(np.abs(omega / exact - 1)))


def response_error(points: np.ndarray) -> float:
    """Largest error of the first harmonic (omega, cosine, sine) against motions shot at the same frequencies, relative to its largest."""
    from phichain.orbits.forced.flow import EmittedFlow
    from phichain.orbits.forced.forcing import forcing_of
    from phichain.orbits.harmonics.basis import basis

    own = system(DRIVEN.damping)
    flow, table = EmittedFlow(own, forcing_of(own, 1, DRIVEN.drive)), basis("odd", 63)
    worst = 0.0
    for omega, cosine, sine in points:
        x = np.array([cosine, sine * omega])
        for _ in range(12):
            moved = flow(x, np.pi / omega, DRIVEN.drive, omega)
            assert moved is not None
            end, columns, _ = moved
            x = x - np.linalg.solve(columns + np.eye(2), end + x)
        theta = np.append(x[0], flow.sampled(x, table.phase[1:] / omega, DRIVEN.drive, omega)[:, 0])
        worst = max(worst, float(np.max(np.abs((table.project @ theta)[:2] - (cosine, sine)))))
    return worst / float(np.max(np.hypot(points[:, 1], points[:, 2])))


def family(run: plan.Plan) -> Work:
    """A free link's brake orbits from 0.01 to 2.5 rad."""
    from phichain.orbits import trace
    from phichain.orbits.harmonics.elimination import Harmonics

    def ours(tail: float) -> Runner:
        call = partial(
            trace, system(None), method="harmonics", until=("theta_1", AMPLITUDE), harmonics=Harmonics(tail=tail, most=39, least=3)
        )
        found: Any = call()
        return Runner(f"phichain, tail {tail:g}: {len(found)} points, events", call, family_error(*found.points.T), "ours")

    def numpy(highest: int) -> Runner:
        size = (highest + 1) // 2
        start = np.concatenate([[0.01], np.zeros(size - 1), [np.sqrt(FREE.weight / FREE.inertia)]])
        scale = np.append(np.ones(size), 4.0)
        call = lambda: followed(free(FREE, highest), start, scale, lambda z: float(np.sum(z[:-1])) > AMPLITUDE)
        found = call()
        return Runner(f"NumPy, H = {highest}: {len(found)} points", call, family_error(np.sum(found[:, :-1], axis=1), found[:, -1]))

    makers: list[tuple[str, Maker]] = [(f"phichain {tail:g}", partial(ours, tail)) for tail in run.few((1e-12, 1e-8, 1e-4))]
    makers += [(f"NumPy {highest}", partial(numpy, highest)) for highest in run.few((39, 23, 15, 7))]
    return contest("family of one free link to 2.5 rad", makers, run.rounds, run.budget)


def response(run: plan.Plan) -> Work:
    """A driven link through both folds."""
    from phichain.orbits import respond
    from phichain.orbits.harmonics.elimination import Harmonics

    def ours(tail: float) -> Runner:
        own = system(DRIVEN.damping)
        call = partial(respond, own, 1, DRIVEN.drive, ENDS, harmonics=Harmonics(tail=tail, most=39, least=3))
        found = call()
        points = np.column_stack([found.omega, found.first[:, 0].real, -found.first[:, 0].imag])
        return Runner(f"phichain, tail {tail:g}: {len(found)} points, multipliers, events", call, response_error(points), "ours")

    def numpy(highest: int) -> Runner:
        size = highest + 1
        start, scale = np.append(np.zeros(size), ENDS[0]), np.append(np.ones(size), 4.0)
        call = lambda: followed(driven(DRIVEN, highest), start, scale, lambda z: float(z[-1]) > ENDS[1])
        found = call()
        points = found[:, [-1, 0, size // 2]]
        return Runner(f"NumPy, odd harmonics, H = {highest}: {len(found)} points", call, response_error(points))

    def pyharm(highest: int) -> Runner:
        peer = present.module("benchmarks.peers.pyharm_response")
        call: Callable[[], Any] = partial(peer.response, DRIVEN, highest, ENDS)
        found = call()
        return Runner(f"pyHarm, H = {highest}: {len(found)} points", call, response_error(found))

    makers: list[tuple[str, Maker]] = [(f"phichain {tail:g}", partial(ours, tail)) for tail in run.few((1e-12, 1e-8, 1e-4))]
    makers += [(f"NumPy {highest}", partial(numpy, highest)) for highest in run.few((39, 15, 7))]
    makers += [(f"pyHarm {highest}", partial(pyharm, highest)) for highest in run.few((39, 15, 7))]
    return contest("response of one driven link through both folds", makers, run.rounds, run.budget)


def tables(run: plan.Plan) -> list[Table]:
    """Both pieces of work."""
    notes = (
        ("Errors: of omega against the elliptic integral, largest over the family's points; of the first harmonic against motions shot at the"
        " same frequencies, largest over the response's points, relative to the largest amplitude."),
        ("Ours locate folds, branch points and energy extrema, measure gaps, choose the number of harmonics at every point, and compute Floquet"
        " multipliers of the response; NumPy's form computes points alone, pyHarm's points and folds by a change of sign."),
    )
    return [detail("Everybody", [family(run), response(run)], notes)]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    return plan.command("harmonics", "benchmarks.orbits.harmonics", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
