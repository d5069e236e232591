"""The search for a motion that can be led: several starts, the law along each compiled and tried, the one that survives kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any, Final

import numpy as np

from phichain.control.rig.observer import Sensors
from phichain.control.swing_up import Plan, Start, planned, starts
from phichain.control.swing_up.transcription import MOST, SOLVERS, Problem
from phichain.errors import ArrayError, ControlError, UnsupportedError
from phichain.laws import TrajectoryLaw
from phichain.records import Held, thawed
from phichain.scene import Scene, scene_from_dict
from phichain.system import System
from phichain.trials.monte_carlo import Trials, sizes_of
from phichain.trials.search import Rig, Search, Tried, rig, trials_of, tried

STARTS: Final = 12
ENOUGH: Final = 0.95
HALVINGS: Final = 3
"""How often starts are drawn from half as far where too few runs hold."""
_WANT: Final = ("forward_dynamics", "linearization")


@dataclass(frozen=True, eq=False)
class SwingUp(Held):
    """A motion, the law that leads the chain along it, and what became of it in trials.

    Attributes:
        plan: The motion.
        law: The law.
        trials: Runs that took no part in choosing it.
        tried: Every start that was followed, in the order in which they ended.
        within: Largest error of the angles at the start, rad, with which enough runs do hold, where those of the trials did not and a start that
            is closer is all that was missing; None otherwise.
    """

    plan: Plan
    law: TrajectoryLaw
    trials: Trials
    tried: tuple[Tried, ...]
    within: float | None = None

    def __str__(self) -> str:
        bound = "" if self.within is None else f"\nthe spread of the starts is the bound: enough runs hold that start within {self.within:g} rad"
        return f"{self.plan}\n{self.law}\n{self.trials}{bound}"


def swing_up(
    system: System,
    *,
    limit: Any,
    rail: float | None = None,
    start: Sequence[int] | None = None,
    target: Sequence[int] | None = None,
    places: tuple[float, float] = (0.0, 0.0),
    errors: Mapping[str, float] | None = None,
    spread: float = 0.05,
    sample: float = 1e-3,
    seconds: float | None = None,
    runs: int = 200,
    real: str = "float",
    enough: float = ENOUGH,
    count: int = STARTS,
    jobs: int = 1,
    solver: str = "fatrop",
    most: int = MOST,
    stride: int = 5,
    anyway: bool = False,
    sensors: Sensors | None = None,
    report: Callable[[Tried], None] | None = None,
) -> SwingUp:
    """Move a planar chain from one vertical equilibrium to another, and make a law of it that survives.

    Args:
        system: A planar chain with inputs that was built from a scene; its `params` are the values of runtime parameters.
        limit: Largest size of every input, one number or (nu,).
        rail: Largest distance of the cart from 0, m.
        start: Where it begins; every link hanging unless given.
        target: Where it ends; every link upright unless given.
        places: Where the cart stands at the start and at the end, m.
        errors: Largest relative errors of parameters by name, such as {"mass": 0.1}; these are what the law is made and tried for.
        spread: Largest error of the angles at the start, rad.
        sample: Time between two calls of the law, s.
        seconds: Duration of the motion; several are tried unless given.
        runs: Trials, half as many to choose by.
        real: Type of the law's C, "float" or "double".
        enough: The search ends with the first law that holds in such a share of its runs. Where none does, the trials are repeated from closer
            starts, for what is missing may be that alone (`SwingUp.within`).
        count: Starts at most.
        jobs: Processes; with more than one the caller's script must not start anew when it is imported (`if __name__ == "__main__"`).
        solver: "fatrop" or "ipopt".
        most: Iterations that a start is worth.
        stride: Samples from one knot of the table to the next.
        anyway: Take a plan whose solver stopped early; the law's note says so.
        sensors: How positions are measured, steps and noise: the law then reads them alone through an observer along the motion, and
            the trials measure in these steps. The whole state, exact, unless given.
        report: Called with every start that has ended.

    Raises:
        UnsupportedError: A spatial chain, one that was made by hand, or casadi is missing.
        SceneError: A name of `errors` is no parameter.
        ControlError: The task is none, its limits leave no motion (which one), or no plan can be led.
    """
    if solver not in SOLVERS:
        raise ArrayError("solver", solver, "is no solver of ours", f"choose one of {', '.join(SOLVERS)}")
    search = _search(
        system, {"limit": limit, "rail": rail, "start": start, "target": target, "places": tuple(places), "sample": sample},
        errors or {}, spread,
        max(1, runs // 2), real, stride, solver, most, sensors,
    )  # fmt: skip
    made = rig(search)
    ended: list[Tried] = []
    for one in _followed(search, starts(made.task, count, seconds), jobs):
        ended.append(one)
        if report is not None:
            report(one)
        if _is_sound(one) and one.share >= enough:
            break
    best = _best(ended, anyway)
    if best is None or best.plan is None or best.law is None:
        raise _explained(search, made, ended)
    trials: Trials = trials_of(search, best.law, runs, seed=1)
    within = None if trials.share >= enough else _within(search, best.law, runs, enough)
    law = _named(best.law, system, best.plan, trials, errors or {}, spread, within)
    whose: dict[str, Any] = {"digest": system.digest, "p": system.values()}
    return SwingUp(replace(best.plan, **whose), law, replace(trials, name=system.name, **whose), tuple(ended), within)


def _within(search: Search, law: TrajectoryLaw, runs: int, enough: float) -> float | None:
    """The first half, quarter, .. of the spread of the starts with which enough runs hold; None where none of them does."""
    halves = (search.spread / 2**k for k in range(1, HALVINGS + 1) if search.spread)
    return next((spread for spread in halves if trials_of(search, law, runs, seed=1, spread=spread).share >= enough), None)


def _search(
    system: System, task: dict[str, Any], errors: Mapping[str, float], spread: float, runs: int, real: str, stride: int, solver: str, most: int,
    sensors: Sensors | None = None,
) -> Search:  # fmt: skip
    """The search of a system: its scene with the parameters that have errors left to run time."""
    if not system.digest:
        raise UnsupportedError("system", system.name, "was not built from a scene", "build it from one: its functions are compiled anew")
    scene = scene_from_dict(thawed(system.scene))
    values = {name: system.number(name) for name in scene.runtime}
    open_: dict[str, Any] = {}
    for name in errors:
        given = getattr(scene, name, None) if name in Scene.__dataclass_fields__ else None
        if isinstance(given, float | int | tuple) and not isinstance(given, bool):
            values[name], open_[name] = given, "runtime"
        elif given != "runtime":
            sizes_of(replace(scene, real="double", want=_WANT), {name: 0.0})
    scene = replace(scene, real="double", want=_WANT, variational=False, **open_)
    sizes = sizes_of(scene, errors)
    ordered = {name: np.asarray(values[name], dtype=float).tolist() for name in scene.runtime}
    if not 0 <= spread < np.pi:
        raise ControlError("spread", spread, "is no error of an angle", "give radians, such as 0.05")
    return Search(scene.to_dict(), ordered, task, tuple(sizes), spread, runs, real, stride, solver, most, sensors)


def _followed(search: Search, every: Sequence[Start], jobs: int) -> Iterator[Tried]:
    """The starts as they end; whoever stops asking stops what still runs."""
    if jobs < 2 or len(every) < 2:
        yield from (tried(search, start) for start in every)
        return
    with get_context("spawn").Pool(min(jobs, len(every)), _quietly) as pool:
        yield from pool.imap_unordered(_Follow(search), every)


def _quietly() -> None:
    """Leave Ctrl-C to the process that started this one: it ends its pool."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)


@dataclass(frozen=True)
class _Follow:
    search: Search

    def __call__(self, start: Start) -> Tried:
        return tried(self.search, start)


def _is_sound(one: Tried) -> bool:
    return one.plan is not None and one.law is not None and one.plan.converged


def _best(ended: Iterable[Tried], anyway: bool) -> Tried | None:
    """The law that held in most runs, and along the cheapest plan where several did."""
    sound = [one for one in ended if _is_sound(one)]
    if not sound and anyway:
        sound = [one for one in ended if one.law is not None]
    return max(sound, key=lambda one: (one.share, -one.plan.cost if one.plan else 0.0), default=None)


def _explained(search: Search, made: Rig, ended: Sequence[Tried]) -> ControlError:
    """Which bound is in the way, if one is."""
    task = made.task
    wider = {"rail": replace(task, rail=float("inf"), routes=()), "limit": replace(task, limit=10 * task.limit, routes=())}
    for name, relaxed in wider.items():
        if name == "rail" and not np.isfinite(task.rail):
            continue
        problem = Problem(made.chain, relaxed, search.solver, search.most)
        for one in ended[:2]:
            plan, _left = planned(made.chain, relaxed, problem, replace(one.start, route=0), search.stride)
            if plan is not None and plan.converged:
                return _bound(name, made, plan)
    least = min(one.left.infeasibility for one in ended)
    return ControlError(
        "seconds", ended[0].start.seconds, f"none of {len(ended)} starts converged: the least infeasibility is {least:.2g}",
        "follow more starts or give another duration; to see what was found so far, ask for it anyway", infeasibility=least,
    )  # fmt: skip


def _bound(name: str, made: Rig, plan: Plan) -> ControlError:
    task = made.task
    if name == "rail":
        far = float(np.max(np.abs(plan.x[:, 0])))
        problem = f"is the bound that leaves no motion in {plan.duration:.3g} s: without it there is one that goes {far:.3g} m far"
        return ControlError("rail", task.rail, problem, "give a longer rail, or more time", bound=name, needed=far)
    size = float(np.max(np.abs(plan.u)))
    problem = f"is the bound that leaves no motion in {plan.duration:.3g} s: with more there is one that takes {size:.3g}"
    return ControlError("limit", task.limit.tolist(), problem, "give a stronger input, or more time", bound=name, needed=size)


def _named(
    law: TrajectoryLaw, system: System, plan: Plan, trials: Trials, errors: Mapping[str, float], spread: float, within: float | None
) -> TrajectoryLaw:
    """The law under the scene's own digest, with what a reader of its header must know."""
    sizes = ", ".join(f"{name} within {size:.3g} of its value" for name, size in errors.items())
    held = int(np.sum(trials.held))
    seen = " through the observer, from positions in the steps of their sensors" if law.observer else ""
    note = f"Of {len(trials.held)} runs with starts within {spread:g} rad{' and ' + sizes if sizes else ''}, {held} reach the target and hold it{seen}."
    if within is not None:
        note += f" Enough do where they start within {within:g} rad."
    if not plan.converged:
        note = f"NOT CONVERGED: the solver stopped after {plan.iterations} iterations, infeasibility {plan.infeasibility:.2g}. {note}"
    return replace(law, catch=replace(law.catch, name=system.name, digest=system.digest, p=system.values()), note=note)
