"""Starts of the search, and the plan that one of them leads to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from phichain.control.swing_up.chain import Chain
from phichain.control.swing_up.gains import Design, catch_gains, linear_path, regulated
from phichain.control.swing_up.plan import Plan
from phichain.control.swing_up.task import Task
from phichain.control.swing_up.transcription import Problem, Solution
from phichain.system import Vector
from phichain.system.drawn import looks

TIMES: Final = (10.5, 9.0, 12.0, 13.5, 7.5, 15.0)
"""Durations that are tried, in swing times."""

CALM: Final = (3e-3, 0.0, 1e-2)
"""Weights of the rates that are tried."""

SHARE: Final = 0.85
"""Share of rail and limits that a plan may use: the rest is for what is not as planned."""

TURN: Final = 0.4
"""Largest angle that a joint turns in an interval where a plan without such a bound cannot be led, rad: one Runge-Kutta step knows no more.

Where an input is strong a plan may whirl its light links about, for that costs nothing and the equations of the nodes hold whatever their
step makes of it. Of the bundled `planar3_cart` links turned by up to 1.6 rad in an interval, and steps were wrong by 8 to 120.
"""

WIDE: Final = 0.5
"""Distance between the nodes and the chain that is led along them, rad, above which the intervals are too long."""

LONG: Final = 6
"""Links from which on joints are bounded first: of six on the chain of docs/swingup.md none of three starts converged without, two of two with it."""

FINEST: Final = 480
"""Intervals at most. An optimum that the chain cannot be led along is solved anew on twice as many, from what it was: six links are out
of 120 steps of 30 ms and within 0.15 rad of 240."""

Followed = tuple[Vector, Vector, float]
"""(x, u, defect) sample by sample."""

AGAIN: Final = ((1.0, 0.0), (1.43, 1e-2), (0.86, 0.0))
"""Share of a start's duration and weight of the rates with which each motion of a route is tried, until one is found: of the bundled
`planar3_cart` link 2 of links 2 and 3 stays up alone in 15 swing times and not in 10.5, in which 1 and 3 come down."""

_WAVES: Final = 5
_LARGEST: Final = 1e3
_GUIDE: Final = Design(0.7)


@dataclass(frozen=True)
class Start:
    """Where one search begins.

    Attributes:
        seconds: Duration of the motion.
        calm: Weight of the rates.
        seed: 0 for a straight line from start to target, else waves about it drawn with this seed.
        route: 0 for the way in one motion, else by which of the task's routes, each motion of that duration.
    """

    seconds: float
    calm: float
    seed: int
    route: int = 0


@dataclass(frozen=True)
class Left:
    """What the solver said of a start.

    Attributes:
        converged: Whether it says that it solved the problem.
        iterations: How many it took.
        cost: The objective.
        infeasibility: Largest violation of an equation.
    """

    converged: bool
    iterations: int
    cost: float
    infeasibility: float

    def __str__(self) -> str:
        early = "" if self.converged else " (stopped early)"
        return f"cost {self.cost:.4g}, infeasibility {self.infeasibility:.1e}, {self.iterations} iterations{early}"


def starts(task: Task, count: int, seconds: float | None = None) -> tuple[Start, ...]:
    """The first so many starts: durations in turn, straight lines first, weights and waves changing from round to round.

    Each is followed in one motion, and then by every route that the task has.
    """
    ways = 1 + len(task.routes)
    if ways > 1:
        direct = starts(replace(task, routes=()), -(-count // ways), seconds)
        return tuple(replace(start, route=way) for start in direct for way in range(ways))[:count]
    times = [factor * task.swing for factor in TIMES] if seconds is None else [seconds]
    found = []
    for k in range(count):
        turn, time = divmod(k, len(times))
        found.append(Start(times[time], CALM[(turn + time) % len(CALM)], turn if len(times) > 1 else turn // len(CALM)))
    return tuple(found)


def planned(chain: Chain, task: Task, problem: Problem, start: Start, stride: int) -> tuple[Plan | None, Left]:
    """The plan that a start leads to, None where the chain cannot be led along what the solver left; and what that is.

    Args:
        chain: The chain.
        task: The task.
        problem: Its optimal control problem.
        start: Where to begin.
        stride: The duration becomes a multiple of so many samples.
    """
    samples = max(2, round(start.seconds / (stride * task.sample))) * stride
    if start.route:
        legs = task.routes[start.route - 1]
        solution, followed = _through(chain, task, legs, problem, start, stride)
        samples = samples if followed is None else len(followed[1])
    else:
        solution, followed = _led(chain, task, problem, start, samples)
    left = Left(solution.converged, solution.iterations, solution.cost, solution.infeasibility)
    if followed is None:
        return None, left
    x, u, defect = followed
    plan = Plan(
        name=chain.system.name, digest=chain.system.digest, t=np.asarray(np.arange(samples + 1) * task.sample, dtype=float), x=x, u=u,
        state_names=(*chain.system.q_names, *chain.system.v_names), input_names=chain.system.u_names, start=task.start, target=task.target,
        limit=task.limit, rail=task.rail if np.isfinite(task.rail) else 0.0, sample=task.sample, solver=problem.solver,
        converged=solution.converged, iterations=solution.iterations, cost=solution.cost, infeasibility=solution.infeasibility,
        defect=defect, p=chain.system.values(), **looks(chain.system),
    )  # fmt: skip
    return plan, left


def _led(chain: Chain, task: Task, problem: Problem, start: Start, samples: int) -> tuple[Solution, Followed | None]:
    """What the solver leaves, and the chain led along it: on finer intervals while that is far off, with joints bounded if need be."""
    seconds = samples * task.sample
    best: tuple[Solution, Followed] | None = None
    left: list[Solution] = []
    guess = _guess(problem, task, start, seconds)
    # Where it is met nowhere the bound would only slow the solver down; long chains meet it.
    for turn in (np.inf, TURN) if chain.system.links < LONG else (TURN, np.inf):
        grid, solution = problem, problem.solve(seconds, *guess, start.calm, SHARE, turn)
        left.append(solution)
        while True:
            followed = _followed(chain, task, solution, samples)
            if followed is not None and (best is None or (solution.converged, -followed[2]) > (best[0].converged, -best[1][2])):
                best = solution, followed
            if not solution.converged or grid.intervals >= FINEST or (followed is not None and followed[2] <= WIDE):
                break
            grid = grid.finer()
            solution = grid.solve(seconds, *_finer(chain, solution), start.calm, SHARE, TURN)
        if best is not None and (best[1][2] <= WIDE or not best[0].converged):
            return best
    return best or (left[0], None)


def _through(
    chain: Chain, task: Task, legs: tuple[Task, ...], problem: Problem, start: Start, stride: int
) -> tuple[Solution, Followed | None]:
    """Several motions, one after the other, as one; of the solver's words those of the first that did not converge.

    Each motion is tried for longer and for less time, and more calmly, where it is not found in that of the start.
    """
    found: list[Solution] = []
    led: list[Followed] = []
    for leg in legs:
        for factor, calm in AGAIN:
            samples = max(2, round(factor * start.seconds / (stride * task.sample))) * stride
            solution, followed = _led(chain, leg, problem.of(leg), replace(start, calm=max(calm, start.calm)), samples)
            if followed is not None and solution.converged:
                break
        found.append(solution)
        if followed is None:
            break
        led.append(followed)
    whole = replace(
        next((one for one in found if not one.converged), found[-1]), cost=sum(one.cost for one in found),
        iterations=sum(one.iterations for one in found), infeasibility=max(one.infeasibility for one in found),
    )  # fmt: skip
    if len(led) < len(legs):
        return whole, None
    x = np.concatenate([*(one[0][:-1] for one in led[:-1]), led[-1][0]])
    joined = _along(chain, task, x, np.concatenate([one[1] for one in led]))
    return whole, None if joined is None else (joined[0], joined[1], max(joined[2], *(one[2] for one in led)))


def _finer(chain: Chain, solution: Solution) -> tuple[Vector, Vector]:
    """Nodes and slopes of the same motion on twice as many intervals: states by cubic Hermite interpolation."""
    nx, K = chain.system.nx, len(solution.slopes)
    x = _between(chain, solution, np.linspace(0, solution.seconds, 2 * K + 1))
    u = np.repeat(solution.nodes[:, nx:], 2, axis=0)[:-1]
    u[1::2] = (solution.nodes[:-1, nx:] + solution.nodes[1:, nx:]) / 2
    return np.hstack([x, u]), np.repeat(solution.slopes, 2, axis=0)


def _between(chain: Chain, solution: Solution, t: Vector) -> Vector:
    """States (m, nx) at times t (m,), by the nodes' states and rates."""
    nx, K = chain.system.nx, len(solution.slopes)
    nodes = solution.nodes
    rates = np.array(chain.rate.map(K + 1)(nodes[:, :nx].T, nodes[:, nx:].T, np.zeros((chain.parameters.size, K + 1)))).T
    grid = np.arange(K + 1) * (solution.seconds / K)
    return np.asarray(CubicHermiteSpline(grid, nodes[:, :nx], rates)(t))


def _guess(problem: Problem, task: Task, start: Start, seconds: float) -> tuple[Vector, Vector]:
    """Nodes on a straight line from start to target, with waves about it that vanish at both."""
    nq, K = task.first.size, problem.intervals
    share = np.linspace(0, 1, K + 1)[:, None]
    nodes = np.zeros((K + 1, problem.nx + problem.nu))
    nodes[:, :nq] = task.first + (task.last - task.first) * share
    nodes[:, nq : 2 * nq] = (task.last - task.first) / seconds
    draw = np.random.default_rng(start.seed)
    for wave in range(1, _WAVES + 1) if start.seed else ():
        size = draw.normal(size=nq) / (2 * wave)
        nodes[:, :nq] += size * np.sin(np.pi * wave * share)
        nodes[:, nq : 2 * nq] += size * np.pi * wave / seconds * np.cos(np.pi * wave * share)
    return nodes, np.zeros((K, problem.nu))


def _followed(chain: Chain, task: Task, solution: Solution, samples: int) -> Followed | None:
    """(x, u, defect): the chain led along the solution sample by sample, twice, the second time along what the first left."""
    nx, K = chain.system.nx, len(solution.slopes)
    nodes, h = solution.nodes, solution.seconds / K
    x = _between(chain, solution, np.asarray(np.arange(samples + 1) * task.sample, dtype=float))
    if not np.all(np.isfinite(x)):
        return None
    # What a solver left may begin anywhere; the chain begins at rest where the task says.
    x[0] = np.concatenate([task.first, np.zeros(nx - task.first.size)])
    middle = (np.arange(samples) + 0.5) * task.sample
    at = np.minimum((middle / h).astype(int), K - 1)
    u = nodes[at, nx:] + solution.slopes[at] * (middle - at * h)[:, None]
    return _along(chain, task, x, u)


def _along(chain: Chain, task: Task, x: Vector, u: Vector) -> Followed | None:
    """The chain led along states (samples + 1, nx) and inputs (samples, nu), twice, and how far it was off the first time."""
    samples = len(u)
    step, derivatives = chain.step(task.sample), chain.derivatives(task.sample)
    none, defect = np.zeros(chain.parameters.size), 0.0
    for turn in range(2):
        path = linear_path(derivatives, x, u)
        K_t = regulated(path, *catch_gains(chain, task, derivatives, _GUIDE))
        led, pushed = np.empty_like(x), np.empty_like(u)
        led[0] = x[0]
        for k in range(samples):
            pushed[k] = u[k] - K_t[k] @ (led[k] - x[k])
            led[k + 1] = np.array(step(led[k], pushed[k], none)).ravel()
            if not np.max(np.abs(led[k + 1])) < _LARGEST:
                return None
        defect = float(np.max(np.abs(led - x))) if turn == 0 else defect
        x, u = led, pushed
    return x, u, defect
