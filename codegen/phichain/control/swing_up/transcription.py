"""The optimal control problem of a motion, by multiple shooting: one flat step mapped over the intervals, stage by stage.

With s = (q, v, u) at the nodes and w = u' constant in between,

    minimise  int |u / limit|^2 + 1e-3 |w swing / limit|^2 + calm |v swing|^2 dt
    subject to  s_{k+1} = F(s_k, w_k, T / K),  s_0 = (first, 0, 0),  s_K = (last, 0, 0),  |x| <= rail',  |u| <= limit',

F one step of the classical Runge-Kutta method. The trajectory is carried over by the law's own sampling afterwards, so that F need
only be as good as the law can mend. Inputs that are continuous, and kept from their limits, leave the law something to mend with.
Variables stand stage by stage, (s_0, w_0, s_1, ..), which fatrop asks for and IPOPT does not mind.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from phichain.control.swing_up.chain import Chain, runge_kutta
from phichain.control.swing_up.task import Task
from phichain.records import Held
from phichain.system import Vector

INTERVALS: Final = 120
SOLVERS: Final = ("fatrop", "ipopt")
_SLEW: Final = 1e-3
_TOLERANCE: Final = 1e-6
MOST: Final = 400
"""Iterations that one start is worth."""


@dataclass(frozen=True, eq=False)
class Solution(Held):
    """What a solver left.

    Attributes:
        converged: Whether it says that it solved the problem.
        seconds: T.
        nodes: s at the nodes (K + 1, nx + nu).
        slopes: w (K, nu).
        cost: The objective.
        infeasibility: Largest violation of an equation.
        iterations: How many it took.
    """

    converged: bool
    seconds: float
    nodes: Vector
    slopes: Vector
    cost: float
    infeasibility: float
    iterations: int


class Problem:
    """The problem of a task: made once, solved for every time, weight and guess."""

    def __init__(self, chain: Chain, task: Task, solver: str = "fatrop", most: int = MOST, intervals: int = INTERVALS) -> None:
        """Write it down; `solver` is one of SOLVERS, and stops after `most` iterations."""
        import casadi as ca

        self.task, self.intervals, self.solver, self.cart = task, intervals, solver, chain.system.cart_size
        self._chain, self._most = chain, most
        self._finer: Problem | None = None
        self._others: dict[Any, Problem] = {}
        nx, nu = chain.system.nx, chain.system.nu
        self.nx, self.nu = nx, nu
        K, stage = intervals, nx + 2 * nu
        flat = ca.MX.sym("z", K * stage + nx + nu)
        given = ca.MX.sym("p", 2)
        T, calm = given[0], given[1]
        inner = ca.reshape(flat[: K * stage], stage, K)
        nodes, slopes = ca.horzcat(inner[: nx + nu, :], flat[K * stage :]), inner[nx + nu :, :]
        after = _interval(chain).map(K)(nodes[:, :K], slopes, ca.repmat(T / K, 1, K))
        gaps = nodes[:, 1:] - after
        ends = [ca.vertcat(*task.first, *np.zeros(nx - task.first.size + nu)), ca.vertcat(*task.last, *np.zeros(nx - task.last.size + nu))]
        equations = ca.vertcat(gaps[:, 0], nodes[:, 0] - ends[0], ca.reshape(gaps[:, 1:], -1, 1), nodes[:, K] - ends[1])
        pushes = ca.diag(1 / task.limit) @ nodes[nx:, :]
        slew = ca.diag(task.swing / task.limit) @ slopes
        rates = task.swing * nodes[nx // 2 : nx, :]
        cost = T / K * (ca.sumsqr(pushes) + _SLEW * ca.sumsqr(slew) + calm * ca.sumsqr(rates))
        problem = {"x": flat, "p": given, "f": cost, "g": equations}
        self._solve = ca.nlpsol("swing_up", solver, problem, _options(solver, equations.numel(), most))

    def finer(self) -> Problem:
        """The same on twice as many intervals; made once."""
        if self._finer is None:
            self._finer = Problem(self._chain, self.task, self.solver, self._most, 2 * self.intervals)
        return self._finer

    def of(self, task: Task) -> Problem:
        """The same of another task; made once."""
        key = (task.start, task.target)
        if key not in self._others:
            self._others[key] = Problem(self._chain, task, self.solver, self._most, self.intervals)
        return self._others[key]

    def solve(self, seconds: float, nodes: Vector, slopes: Vector, calm: float, share: float, turn: float = np.inf) -> Solution:
        """Solve it from a guess.

        Args:
            seconds: T.
            nodes: Guess of s (K + 1, nx + nu).
            slopes: Guess of w (K, nu).
            calm: Weight of the rates.
            share: Share of the rail and of the limits that the plan may use.
            turn: Largest angle by which a joint may turn in an interval, rad.
        """
        nx, nu, K = self.nx, self.nu, self.intervals
        high = np.full((K + 1, nx + 2 * nu), np.inf)
        high[:, 0] = share * self.task.rail + (1 - share) * max(abs(self.task.first[0]), abs(self.task.last[0])) if np.isfinite(self.task.rail) else np.inf
        high[:, nx // 2 + self.cart : nx] = turn * K / seconds
        high[:, nx : nx + nu] = share * self.task.limit
        bounds = self._flat(high[:, : nx + nu], high[:-1, nx + nu :])
        parameters = np.array([seconds, calm])
        found = self._solve(x0=self._flat(nodes, slopes), lbx=-bounds, ubx=bounds, lbg=0, ubg=0, p=parameters)
        flat = np.array(found["x"]).ravel()
        inner = flat[: K * (nx + 2 * nu)].reshape(K, nx + 2 * nu)
        stats = self._solve.stats()
        return Solution(
            bool(stats["success"]), seconds, np.vstack([inner[:, : nx + nu], flat[K * (nx + 2 * nu) :]]), inner[:, nx + nu :],
            float(found["f"]), float(np.max(np.abs(np.array(found["g"])))), int(stats.get("iter_count", 0)),
        )  # fmt: skip

    def _flat(self, nodes: Vector, slopes: Vector) -> Vector:
        return np.concatenate([np.hstack([nodes[:-1], slopes]).ravel(), nodes[-1]])


def _interval(chain: Chain) -> Any:
    """F: one Runge-Kutta step of (q, v, u) with u' = w."""
    import casadi as ca

    nx, nu = chain.system.nx, chain.system.nu
    s, w, h = ca.SX.sym("s", nx + nu), ca.SX.sym("w", nu), ca.SX.sym("h")
    none = np.zeros(chain.parameters.size)
    after = runge_kutta(lambda z: ca.vertcat(chain.rate(z[:nx], z[nx:], none), w), s, h)
    return ca.Function("interval", [s, w, h], [after])


def _options(solver: str, equations: int, most: int) -> dict[str, Any]:
    if solver == "fatrop":
        return {
            "structure_detection": "auto", "equality": [True] * equations, "print_time": False,
            "fatrop": {"print_level": 0, "max_iter": most, "tolerance": _TOLERANCE},
        }  # fmt: skip
    return {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": most, "tol": _TOLERANCE, "mu_strategy": "adaptive"}}
