"""The differintegrals of pycaputo and differint, each as its documentation says to call it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.peers import present

Signal = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Peer:
    """One method.

    Attributes:
        name: As the peer calls it.
        run: (alpha, samples) -> times and values of D^alpha of the signal.
        samples: Grids it can do in reasonable time.
        quadratic: Whether its time grows with the square of the samples.
    """

    name: str
    run: Callable[[float, int], tuple[np.ndarray, np.ndarray]]
    samples: tuple[int, ...]
    quadratic: bool = False


def methods(signal: Signal, end: float) -> tuple[list[Peer], list[str]]:
    """Every method of the two packages that integrates a whole signal, and why a package is left out."""
    found: list[Peer] = []
    absent = []
    for make in (_of_differint, _of_pycaputo):
        try:
            found += make(signal, end)
        except present.PeerAbsent as reason:
            absent.append(str(reason))
    return found, absent


def _of_differint(signal: Signal, end: float) -> list[Peer]:
    differint = present.module("differint.differint")
    few, many = (20, 50, 100, 300, 1000), (20, 100, 1000, 10_000, 100_000)
    return [
        Peer("differint GL", partial(_differint, differint.GL, signal, end), many),
        Peer("differint RL", partial(_differint, differint.RL, signal, end), few, True),
    ]


def _of_pycaputo(signal: Signal, end: float) -> list[Peer]:
    rl = present.module("pycaputo.quadrature.riemann_liouville")
    uniform = partial(_pycaputo, signal, end)
    grids = (20, 50, 100, 300, 1000, 3000)
    spline = partial(rl.SplineLagrange, npoints=4)
    return [
        Peer("pycaputo Rectangular", partial(uniform, rl.Rectangular), grids, True),
        Peer("pycaputo Trapezoidal", partial(uniform, rl.Trapezoidal), grids, True),
        Peer("pycaputo Simpson", partial(uniform, rl.Simpson), grids, True),
        Peer("pycaputo Lubich, order 4", partial(uniform, partial(_lubich, rl, 1.0)), grids[1:], True),
        Peer("pycaputo Lubich, order 4, no start", partial(uniform, partial(_lubich, rl, np.inf)), grids[1:], True),
        Peer("pycaputo SplineLagrange, 4 points", partial(uniform, spline), (20, 50, 100, 300), True),
        Peer("pycaputo SpectralJacobi", partial(_jacobi, rl, signal, end), (16, 32, 64, 96, 128)),
    ]


def _lubich(rl: object, beta: float, alpha: float) -> object:
    return rl.Lubich(alpha, 4, beta)  # type: ignore[attr-defined]


def _differint(
    method: Callable[..., np.ndarray], signal: Signal, end: float, alpha: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0.0, end, count)
    return t, method(alpha, signal(t), 0.0, end, count)


def _pycaputo(
    signal: Signal, end: float, method: Callable[[float], object], alpha: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    from pycaputo.grid import make_uniform_points
    from pycaputo.quadrature import quad

    points = make_uniform_points(count, a=0.0, b=end)
    return points.x, quad(method(alpha), signal, points)


def _jacobi(
    rl: object, signal: Signal, end: float, alpha: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    from pycaputo.grid import make_jacobi_gauss_lobatto_points
    from pycaputo.quadrature import quad

    points = make_jacobi_gauss_lobatto_points(count, a=0.0, b=end)
    return points.x, quad(rl.SpectralJacobi(alpha), signal, points)  # type: ignore[attr-defined]
