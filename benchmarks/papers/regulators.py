"""Gains of paper B's 32 equilibria: ours, python-control's and SciPy's against 40 digits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import mpmath
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_are

from benchmarks import table
from benchmarks.fractional.powers import fastest
from benchmarks.peers import present
from phichain.control import Gains, lqr
from phichain.control.equations.riccati import riccati
from phichain.pipeline import build
from phichain.scene.library import find_scene

Vector = NDArray[np.float64]
ALONG_1 = [0, 3, 5, 7, 9, 11, 12, 15, 17, 19, 21, 23]
"""Motion along e_1 within z: cart position, rotations about e_2, and their rates; the two planes do not mix."""
WEIGHTS = {"identity": (1.0, 1.0), "Fig. 3: cart 8": (8.0, 1.0), "Fig. 4: links 8": (1.0, 8.0)}
EXACT = ((1, 1, 1, 1, 1), (-1, -1, -1, 1, 1), (1, -1, 1, -1, 1), (-1, -1, -1, -1, -1))
"""Equilibria whose gains are also computed in 40 digits."""


def gains_table(quick: bool) -> table.Table:
    """Largest error of the gains, largest difference from ours, and the time of one Riccati equation."""
    solvers = {"phichain": _ours, "scipy": _by_scipy}
    rows = []
    try:
        solvers["python-control"] = _python_control()
    except present.PeerAbsent as absent:
        rows.append((f"python-control skipped: {absent}", "-", "-", "-", "-"))
    for words, (cart, links) in list(WEIGHTS.items())[: 1 if quick else None]:
        weights = [cart] * 2 + [links] * 10
        system = build(find_scene("paper_b"))
        signs = EXACT if quick else tuple(product((1, -1), repeat=5))
        all_gains = {s: lqr(system, s, [*weights, *weights]) for s in signs}
        exact = {s: exact_gains(all_gains[s]) for s in EXACT[: 1 if quick else None]}
        for method, solve in solvers.items():
            found = {s: solve(gains) for s, gains in all_gains.items()}
            error = max(_gap(found[s][0, ALONG_1], exact[s]) for s in exact)
            apart = max(_gap(found[s], gains.K) for s, gains in all_gains.items())
            one = all_gains[EXACT[-1]]
            seconds = fastest(lambda solve=solve, one=one: solve(one), 1 if quick else 5)
            rows.append(
                (
                    method,
                    words,
                    f"{error:.1e}",
                    "" if method == "phichain" else f"{apart:.1e}",
                    f"{seconds:.3g}",
                )
            )
    return table.Table(
        f"Gains of control (22): five links on a cart, {len(EXACT) if quick else 32} equilibria",
        ("method", "weights", "error", "largest difference from ours", "processor s for one"),
        tuple(rows),
        (
            (
                "Error: max norm over max norm of K against 40 digits (matrix sign function of the Hamiltonian), worst of "
                f"{len(EXACT)} equilibria, all upright among them; difference: over all equilibria. Ours ends with Newton steps whose residual is "
                f"taken in extended precision. python-control {table.version('control')}, scipy {table.version('scipy')}."
            ),
        ),
    )


def _ours(gains: Gains) -> Vector:
    return riccati(gains.A, gains.B, gains.Q, gains.R).K


def _by_scipy(gains: Gains) -> Vector:
    S = solve_continuous_are(gains.A, gains.B, gains.Q, gains.R)
    return np.asarray(np.linalg.solve(gains.R, gains.B.T @ S))


def _python_control() -> Callable[[Gains], Vector]:
    control = present.module("control")
    return lambda gains: np.asarray(control.lqr(gains.A, gains.B, gains.Q, gains.R)[0])


def _gap(found: Vector, expected: Vector) -> float:
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))


def exact_gains(gains: Gains, digits: int = 40) -> Vector:
    """K along e_1 (12,) by the matrix sign function of the Hamiltonian (Roberts 1971)."""
    A, Q = (part[np.ix_(ALONG_1, ALONG_1)] for part in (gains.A, gains.Q))
    with mpmath.workdps(digits):
        a, b, q, r = (mpmath.matrix(x.tolist()) for x in (A, gains.B[ALONG_1][:, :1], Q, gains.R[:1, :1]))
        n, gain = len(A), r**-1 * b.T
        z = mpmath.zeros(2 * n)
        z[:n, :n], z[:n, n:], z[n:, :n], z[n:, n:] = a, -b * gain, -q, -a.T
        for step in range(60):
            factor = abs(mpmath.det(z)) ** (mpmath.mpf(-1) / (2 * n)) if step < 8 else 1
            new = (factor * z + z**-1 / factor) / 2
            moved, z = mpmath.mnorm(new - z, 1) / mpmath.mnorm(new, 1), new
            if moved < mpmath.mpf(10) ** (10 - digits):
                break
        z += mpmath.eye(2 * n)
        left, right = z[:, n:], -z[:, :n]
        S = (left.T * left) ** -1 * (left.T * right)
        return np.array((gain * S).tolist(), dtype=float)[0]
