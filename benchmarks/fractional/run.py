"""Fractional operators: error against time, phichain beside SciPy, pycaputo and differint, in one run.

Examples::

    python -m benchmarks.fractional
    python -m benchmarks.fractional --write
    python -m benchmarks.fractional --quick      # small sizes, to see that it runs
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from math import log2
from pathlib import Path

import mpmath
import numpy as np

if __package__ in (None, ""):  # started as a file
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks import plan, table
from benchmarks.fractional.powers import fastest, power_table
from benchmarks.peers import fractional as peers
from phichain.fractional import differintegrate, grunwald_letnikov

HEADING = "Fractional operators"
ALPHA = np.linspace(-2.0, 0.0, 101)
END = 10.0
Modes = tuple[tuple[float, float, float], ...]
MODES: Modes = ((1.0, 3.0, 0.7), (0.3, 11.0, 0.2))


@dataclass(frozen=True)
class Row:
    """One method on one grid.

    Attributes:
        method: Its name.
        samples: Length of the signal it worked on.
        error: Max norm over max norm, the worst over the probed alpha.
        seconds: For all 101 alpha.
        note: How the time came about when it was not simply measured.
    """

    method: str
    samples: int
    error: float
    seconds: float
    note: str = ""


def signal(t: np.ndarray, modes: Modes = MODES) -> np.ndarray:
    """Two incommensurate modes with f(0) != 0, as an acceleration of a double pendulum has."""
    return np.sum([a * np.cos(omega * t + phase) for a, omega, phase in modes], axis=0)


def exact(alpha: float, t: float, modes: Modes = MODES) -> float:
    """D^alpha of the signal: D^alpha e^(i w t) = t^-alpha 1F1(1; 1-alpha; i w t) / Gamma(1-alpha), 30 digits."""
    whole = alpha >= 0.0 and alpha == round(alpha)
    with mpmath.workdps(30):
        a, x, total = mpmath.mpf(alpha), mpmath.mpf(t), mpmath.mpf(0)
        for amplitude, omega, phase in modes:
            if whole:
                wave = (1j * omega) ** int(alpha) * mpmath.expj(omega * x)
            else:
                wave = x**-a * mpmath.hyp1f1(1, 1 - a, 1j * omega * x) * mpmath.rgamma(1 - a)
            total += amplitude * mpmath.re(mpmath.expj(phase) * wave)
        return float(total)


def error_at(alpha: float, t: np.ndarray, values: np.ndarray, probes: int = 40) -> float:
    """Largest error over largest value at some of the times, the first ones among them."""
    chosen = np.unique(np.r_[1:6, np.linspace(1, len(t) - 1, probes).astype(int)])
    chosen = chosen[chosen < len(t)]
    expected = np.array([exact(alpha, float(t[k])) for k in chosen])
    return float(np.max(np.abs(values[chosen] - expected)) / np.max(np.abs(expected)))


def our_rows(samples: Sequence[int], probed: Sequence[float]) -> list[Row]:
    """Gruenwald-Letnikov and every order of convolution quadrature, all 101 alpha at once, on one thread."""
    rows = []
    for count in samples:
        t = np.linspace(0.0, END, count)
        f = signal(t)
        for order in (0, 1, 2, 3, 4, 5, 6):

            def work(order: int = order, t: np.ndarray = t, f: np.ndarray = f) -> np.ndarray:
                if order == 0:
                    return grunwald_letnikov(t, f, ALPHA, workers=1).values
                return differintegrate(t, f, ALPHA, order=order, workers=1).values

            values = work()
            errors = [
                error_at(ALPHA[k], t, values[k]) for k in (int(np.argmin(abs(ALPHA - a))) for a in probed)
            ]
            name = f"phichain order {order}" if order else "phichain Gruenwald-Letnikov"
            rows.append(Row(name, count, max(errors), fastest(work, 5 if count < 20000 else 3)))
    return rows


def peer_rows(quick: bool, probed: Sequence[float]) -> list[Row]:
    """Each peer alpha by alpha, timed on the probed alpha and scaled to 101."""
    found, absent = peers.methods(signal, END)
    rows = [Row(reason.split()[0], 0, np.nan, np.nan, f"skipped: {reason}") for reason in absent]
    for peer in found:
        mine = [_peer_row(peer, count, probed) for count in peer.samples[: 2 if quick else None]]
        rows += mine
        if peer.quadratic and not quick:
            grown = mine[-1].seconds * (100_000 / mine[-1].samples) ** 2
            rows.append(Row(peer.name, 100_000, np.nan, grown, f"from {mine[-1].samples} samples, as n^2"))
    return rows


def _peer_row(peer: peers.Peer, count: int, probed: Sequence[float]) -> Row:
    errors, seconds, refused = [], [], []
    for alpha in probed:
        begin = time.process_time()
        try:
            t, values = peer.run(alpha, count)
        except (ValueError, AssertionError):
            refused.append(f"{alpha:g}")
            continue
        seconds.append(time.process_time() - begin)
        errors.append(error_at(alpha, t, values))
    note = f"{len(seconds)} alpha timed" + (f", fails at {', '.join(refused)}" if refused else "")
    median = float(np.median(seconds)) if seconds else np.nan
    return Row(peer.name, count, max(errors, default=np.nan), median * ALPHA.size, note)


def differintegral_table(quick: bool) -> table.Table:
    probed = (-1.9, -1.5, -1.0, -0.5, -0.1)
    samples = (100, 1000) if quick else (50, 100, 300, 1000, 3000, 10_000, 100_000)
    ours = our_rows(samples, probed)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = peer_rows(quick, probed)
    cells = [_cells(row, "") for row in ours]
    for row in theirs:
        as_good = min((mine.seconds for mine in ours if mine.error <= row.error), default=np.nan)
        cells.append(_cells(row, "" if np.isnan(as_good) else f"{row.seconds / as_good:.3g}"))
    return table.Table(
        "Differintegrals: 101 alpha in [-2, 0], cos(3t + 0.7) + 0.3 cos(11t + 0.2) on [0, 10]",
        (
            "method",
            "samples",
            "error",
            "processor s for 101 alpha",
            "its time / ours at no larger error",
            "note",
        ),
        tuple(cells),
        (
            (
                "Errors: max norm over max norm at some 45 times, the first five samples included, worst of "
                f"alpha = {', '.join(map(str, probed))}, against 30 digits. One thread each, processor time. "
                "pycaputo returns no first sample; its SpectralJacobi and SplineLagrange evaluate the function where they like, the others and "
                "phichain see samples alone. differint's GL wraps around: its FFT is not padded."
            ),
            (
                f"Peak memory of the process after phichain's rows, 100 000 samples included: {memory:.0f} MiB. "
                f"{_versions('scipy', 'pycaputo', 'differint', 'mpmath')}."
            ),
        ),
    )


def _cells(row: Row, ratio: str) -> tuple[str, ...]:
    error = "" if np.isnan(row.error) else f"{row.error:.1e}"
    seconds = "" if np.isnan(row.seconds) else f"{row.seconds:.3g}"
    return (row.method, str(row.samples), error, seconds, ratio, row.note)


def order_table() -> table.Table:
    """Measured orders: log2 of the ratio of errors over all t > 0 on the finest grids above round-off."""
    rows = []
    alphas = (-2.0, -1.5, -1.0, -0.5, 0.5, 1.0)
    for order in range(1, 7):
        cells = [str(order)]
        for alpha in alphas:
            cells.append(f"{_measured_order(order, alpha):.2f}")
        rows.append(tuple(cells))
    return table.Table(
        "Measured order of convergence, max norm over all t > 0, cos(3t + 0.7) on [0, 10]",
        ("order", *(f"alpha = {a:g}" for a in alphas)),
        tuple(rows),
    )


def _measured_order(order: int, alpha: float) -> float:
    errors = []
    for count in (200, 400, 800, 1600, 3200, 6400, 12_800, 25_600):
        t = np.linspace(0.0, END, count + 1)
        found = differintegrate(t, signal(t, MODES[:1]), alpha, order=order).values[0]
        chosen = np.unique(np.r_[1:8, np.linspace(1, count, 21).astype(int)])
        expected = np.array([exact(alpha, float(t[k]), MODES[:1]) for k in chosen])
        errors.append(float(np.max(np.abs(found[chosen] - expected))))
    floor = 1e-15 * (2.8 * 25_600) ** max(alpha, 0.0)
    good = [k for k, error in enumerate(errors) if error > 100 * floor]
    last = max(1, good[-1]) if good else 1
    return log2(errors[last - 1] / errors[last])


def _versions(*names: str) -> str:
    return ", ".join(f"{name} {table.version(name)}" for name in names)


def tables(run: plan.Plan) -> list[table.Table]:
    """Differintegrals, powers, orders."""
    return [differintegral_table(run.tiny), power_table(run.tiny), *([] if run.tiny else [order_table()])]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fractional", description=__doc__)
    parser.add_argument("--write", action="store_true", help="write benchmarks/results/fractional.md")
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that it runs")
    given = parser.parse_args(arguments)
    made = tables(plan.TINY if given.quick else plan.FULL)
    for one in made:
        print(one.markdown())
    if given.write:
        print(
            table.write(
                "fractional", HEADING, made, "python -m benchmarks.fractional --write"
            )
        )


if __name__ == "__main__":
    main()
