"""Powers of inertia matrices along many states: error and time beside SciPy's function and NumPy's eigenvectors."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import mpmath
import numpy as np
from scipy.linalg import fractional_matrix_power

from benchmarks import table
from phichain.fractional import inertia_factor, inertia_powers, inertia_spectrum
from phichain.system import Numbers, System

POWERS = np.linspace(0.0, 1.0, 101)


def fastest(work: Callable[[], object], repeats: int = 3) -> float:
    """Least processor time of some runs, s: other work on the machine hardly touches it."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


def power_table(quick: bool) -> table.Table:
    """(I^-1)^p u on many states, beside a loop over SciPy's function and a loop-free eigendecomposition."""
    states, sampled, checked = (2000, 1, 4) if quick else (100_000, 3, 64)
    rng = np.random.default_rng(20160101)
    q, u = rng.uniform(-3.0, 3.0, (states, 4)), rng.standard_normal((states, 4))
    rows = []
    for masses in ((0.25,) * 4, (1.0, 1.0, 1.0, 1e8)):
        system = _chain(masses)
        ours = fastest(
            lambda s=system: inertia_powers(inertia_spectrum(s, q, workers=1), u, POWERS, workers=1)
        )
        factor = inertia_factor(system, q[:sampled])
        inertia = np.swapaxes(factor, 1, 2) @ factor
        begin = time.process_time()
        loop = np.array(
            [[fractional_matrix_power(m, -p) @ v for p in POWERS] for m, v in zip(inertia, u, strict=False)]
        )
        scipy_seconds = (time.process_time() - begin) / sampled * states
        everything = np.swapaxes(inertia_factor(system, q), 1, 2) @ inertia_factor(system, q)
        eigen_seconds = fastest(lambda e=everything: _by_eigh(e, u), 1)
        found = inertia_powers(inertia_spectrum(system, q[:checked]), u[:checked], POWERS)
        name = "1, 1, 1, 1e8" if masses[3] > 1 else "1/4 each"
        for method, seconds, values in (
            ("phichain, one thread", ours, found),
            (f"loop over scipy fractional_matrix_power ({sampled} states timed)", scipy_seconds, loop),
            ("numpy eigh of I, batched", eigen_seconds, _by_eigh(everything[:checked], u[:checked])),
        ):
            error = f"{_power_error(system, q, u, values):.1e}"
            rows.append((method, name, error, f"{seconds:.3g}", f"{seconds / ours:.3g}"))
    return table.Table(
        f"Matrix powers: (I^-1)^p u, 101 p in [0, 1], {states} states, N = 4",
        ("method", "masses", "error", "processor s", "time / phichain"),
        tuple(rows),
        (
            (
                "Error: max norm over max norm against 50 digits, worst of p = 0.25, 0.5, 1 and "
                f"{checked} states ({sampled} of SciPy's loop)."
            ),
        ),
    )


def _by_eigh(inertia: np.ndarray, u: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(inertia)
    modal = np.einsum("ski,sk->si", vectors, u)
    with np.errstate(invalid="ignore"):
        scales = values[:, None, :] ** -POWERS[None, :, None]
    return (scales * modal[:, None, :]) @ vectors.swapaxes(1, 2)


def _power_error(system: System, q: np.ndarray, u: np.ndarray, values: np.ndarray) -> float:
    worst = 0.0
    for state, found in enumerate(values):
        with mpmath.workdps(50):
            squares, vectors = mpmath.eigsy(_exact_inertia(system, q[state]))
            modal = vectors.T * mpmath.matrix(u[state].tolist())
            for k in (25, 50, 100):
                scaled = [m * s ** -mpmath.mpf(float(POWERS[k])) for m, s in zip(modal, squares, strict=True)]
                expected = vectors * mpmath.matrix(scaled)
                gap = max(abs(mpmath.mpf(found[k, i]) - expected[i]) for i in range(4))
                worst = max(worst, float(gap / max(abs(x) for x in expected)))
    return worst


def _exact_inertia(system: System, q: np.ndarray) -> mpmath.matrix:
    numbers, total = system.numbers, mpmath.matrix(4, 4)
    angles = [mpmath.fsum(mpmath.mpf(x) for x in q[: k + 1]) for k in range(4)]
    for a in range(4):
        columns = mpmath.matrix(2, 4)
        for k in range(a + 1):
            reach = mpmath.mpf((numbers.length if k < a else numbers.com)[k])
            for j in range(k + 1):
                columns[0, j] += reach * mpmath.cos(angles[k])
                columns[1, j] -= reach * mpmath.sin(angles[k])
        total += mpmath.mpf(numbers.mass[a]) * (columns.T * columns)
    return total


def _chain(masses: Sequence[float]) -> System:
    numbers = Numbers(mass=tuple(masses), length=(0.25,) * 4, com=(0.125,) * 4)
    return System("chain", "planar", "fixed", 4, 4, 4, 0, numbers=numbers)
