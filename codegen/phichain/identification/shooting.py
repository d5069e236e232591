"""Least squares of a motion in pieces that join: what a chaotic motion has of one long valley, cut into short ones.

Along a motion that grows changes a millionfold the misfit is a valley so narrow and bent that no step along it is longer than rounding.
Cut at K rows, with the state at each as an unknown s_k of its own and the pieces held together by

    phi_k(s_k, theta) - s_(k+1) = 0,

every piece grows little, and Gauss and Newton go where the valley leads in a few steps (multiple shooting; Bock 1983, Springer Ser. Chem. Phys.
18). The steps that keep the pieces joined are Z y with Z an orthonormal basis of the constraints' null space, so that the covariance
Z (Z^T J^T W J Z)^-1 Z^T needs no number as large as the growth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import qr

from phichain.identification.model import Model
from phichain.records import Held
from phichain.system import Vector

_PIECES: Final = 32
"""Pieces of a measurement; each holds some rows at least."""
_LEAST_ROWS: Final = 8
_MOST_STEPS: Final = 20
_STILL: Final = 1e-3
"""A step shorter than this part of the standard errors is none."""


@dataclass(frozen=True, eq=False)
class Joined(Held):
    """Where the pieces came to rest.

    Attributes:
        z: The unknowns (k,), scaled.
        predicted: The measured columns (m, c).
        root: L (k, k) with L L^T the covariance of z for residuals of size one.
        iterations: Steps taken.
        is_settled: Whether the last of them was none.
    """

    z: Vector
    predicted: Vector
    root: Vector
    iterations: int
    is_settled: bool


@dataclass(frozen=True, eq=False)
class _Trial(Held):
    """All pieces at a point: predicted columns (m, c), their slopes by (theta, own state) (m, c, n + nx), and each piece's end with its."""

    predicted: Vector
    slopes: Vector
    ends: Vector
    end_slopes: Vector


def joined(model: Model, z: Vector, noise: Vector) -> Joined:
    """Least squares over pieces, from the motion of z.

    Args:
        model: The model, whose flow carries derivatives by all unknowns.
        z: Where to begin (k,), scaled.
        noise: Standard deviation of every measured column (c,).
    """
    values, unknowns = np.asarray(model.data.values), model.unknowns
    count, scale, nx = unknowns.count, np.asarray(unknowns.scale), model.system.nx
    cuts = np.unique(np.linspace(0, len(values) - 1, 1 + max(1, min(_PIECES, (len(values) - 1) // _LEAST_ROWS))).astype(int))
    size = scale[count:] if unknowns.fits_state else np.ones(nx)
    theta, states = np.array(z[:count]), _started(model, z, cuts)
    low, is_settled, steps = np.asarray(unknowns.low)[:count], False, 0
    while True:
        trial = _tried(model, theta * scale[:count], states, cuts)
        system = _System(trial, states, cuts, values, noise, scale[:count], size, unknowns.fits_state)
        step, root = system.step(theta, low)
        if is_settled or steps == _MOST_STEPS or not np.isfinite(step).all():
            break
        steps += 1
        spread = np.sqrt(np.sum(root**2, axis=1))
        theta = np.maximum(theta + step[:count], low)
        states = states + step[count:].reshape(-1, nx) * size
        is_settled = bool((np.abs(step[: len(root)]) <= _STILL * spread).all())
    if unknowns.fits_state:
        return Joined(np.concatenate([theta, states[0] / size]), trial.predicted, root, steps, is_settled)
    return Joined(theta, trial.predicted, root, steps, is_settled)


class _System:
    """min |r + J w| with C w + c = 0 in the steps w of (theta, s_0, ..), scaled."""

    def __init__(
        self, trial: _Trial, states: Vector, cuts: Vector, values: Vector, noise: Vector, scale: Vector, size: Vector, is_free: bool
    ) -> None:  # fmt: skip
        count, (pieces, nx) = len(scale), states.shape
        self.count, self.nx, self.width, self.kept = count, nx, count + pieces * nx, count + (nx if is_free else 0)
        inner = np.concatenate([scale, size])
        off = ((trial.predicted - values) / noise)[..., None]
        slopes, blocks = trial.slopes * inner / noise[:, None], []
        for k in range(pieces):
            rows = slice(cuts[k] + (k > 0), cuts[k + 1] + 1)
            both = np.concatenate([slopes[rows], off[rows]], axis=-1).reshape(-1, count + nx + 1)
            block = np.zeros((count + nx + 1, self.width + 1))
            triangle = np.linalg.qr(both, mode="r")
            block[: len(triangle), [*range(count), *self._of(k), -1]] = triangle
            blocks.append(block)
        whole = np.concatenate(blocks)
        self.J, self.r = whole[:, :-1], whole[:, -1]
        joints = np.zeros(((pieces - 1) * nx, self.width))
        for k in range(pieces - 1):
            rows = slice(k * nx, (k + 1) * nx)
            joints[rows, [*range(count), *self._of(k)]] = trial.end_slopes[k] * inner / size[:, None]
            joints[rows, self._of(k + 1)] -= np.eye(nx)
        gaps = ((trial.ends[:-1] - states[1:]) / size).ravel()
        kept = np.eye(self.width)[[] if is_free else self._of(0)]
        self.C, self.c = np.concatenate([joints, kept]), np.concatenate([gaps, np.zeros(len(kept))])

    def _of(self, k: int) -> list[int]:
        return list(range(self.count + k * self.nx, self.count + (k + 1) * self.nx))

    def step(self, theta: Vector, low: Vector) -> tuple[Vector, Vector]:
        """The step, with parameters that would pass their bound kept on it, and a root of the covariance without bounds."""
        step, root = self._solved(self.C, self.c)
        for _ in range(self.count):
            beyond = np.flatnonzero(theta + step[: self.count] < low - 1e-12)
            if not beyond.size:
                break
            pins = np.eye(self.width)[beyond]
            step, _ = self._solved(np.concatenate([self.C, pins]), np.concatenate([self.c, (theta - low)[beyond]]))
        return step, root

    def _solved(self, C: Vector, c: Vector) -> tuple[Vector, Vector]:
        if len(C):
            Q, R = qr(C.T)
            there = Q[:, : len(c)] @ np.linalg.solve(R[: len(c)].T, -c)
            Z = Q[:, len(c) :]
        else:
            there, Z = np.zeros(self.width), np.eye(self.width)
        left, sizes, right = np.linalg.svd(self.J @ Z, full_matrices=False)
        inverse = Z @ (right.T / sizes)
        step: Vector = there - inverse @ (left.T @ (self.r + self.J @ there))
        return step, inverse[: self.kept]


def _started(model: Model, z: Vector, cuts: Vector) -> Vector:
    """The states (K, nx) at the first row of every piece, on the motion of z."""
    everything = replace(model, at=tuple(range(model.system.nx)))
    return np.asarray(everything.predicted(z, int(cuts[-1]) + 1)[cuts[:-1]])


def _tried(model: Model, theta: Vector, states: Vector, cuts: Vector) -> _Trial:
    """Run all pieces."""
    system, unknowns, at = model.system, model.unknowns, list(model.at)
    count, (pieces, nx) = unknowns.count, states.shape
    p = unknowns.parameters(np.concatenate([theta / unknowns.scale[:count], np.zeros(len(unknowns.scale) - count)]))
    along = {name: np.zeros((size, count + nx)) for name, size in system.varied.items() if name in unknowns.given}
    for j, (name, place) in enumerate(unknowns.keys):
        along[name][place, j] = 1.0
    begin, rows = np.concatenate([np.zeros((nx, count)), np.eye(nx)], axis=1), int(cuts[-1]) + 1
    predicted, slopes = np.empty((rows, nx)), np.empty((rows, nx, count + nx))
    predicted[0], slopes[0] = states[0], begin
    ends, end_slopes = np.empty((pieces, nx)), np.empty((pieces, nx, count + nx))
    for k in range(pieces):
        ends[k], end_slopes[k] = model.run(
            states[k], p, begin, along, int(cuts[k]), int(cuts[k + 1]), predicted[cuts[k] + 1 : cuts[k + 1] + 1], slopes[cuts[k] + 1 : cuts[k + 1] + 1]
        )
    return _Trial(predicted[:, at], slopes[:, at], ends, end_slopes)
