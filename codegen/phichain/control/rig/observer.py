"""The observer of a regulator: what is measured, how well, and what disturbs the chain, to a stationary filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from phichain.contract.words import known_names
from phichain.control.equations.kalman import Filter, gathered, kalman, reduced
from phichain.control.equations.sampled import held
from phichain.control.gains import Gains
from phichain.control.rig.sight import demand_sight
from phichain.control.weights import Spectrum
from phichain.errors import ControlError
from phichain.laws import Observer
from phichain.records import Held
from phichain.system import Vector
from phichain.system.arrays import number

Values = float | Mapping[str, float]

KINDS: Final = ("kalman", "reduced")
COUNTS: Final = 4096
"""Counts of an encoder over a turn unless a resolution is given."""

STEP: Final = 1e-4
"""Resolution of a place unless one is given, m."""


@dataclass(frozen=True)
class Sensors:
    """What is measured of a chain, and what disturbs it.

    Attributes:
        measured: Names of what is measured, entries of the state (q, v); None for all positions.
        resolution: Step of each measurement, one number or by name; a reading rounded to it has the variance r^2 / 12. Unless given
            a 4096th of a turn for an angle, 0.1 mm for a place, and their hundredfold per second for a rate.
        noise: Standard deviation of a reading beside that, one number or by name; 0 unless given.
        disturbance: Square root of the density of white noise on each coordinate's acceleration, (m/s^2 or rad/s^2)/sqrt(Hz), one
            number or by name; or of an input, in its unit. 1 for each coordinate unless given.
    """

    measured: tuple[str, ...] | None = None
    resolution: Values | None = None
    noise: Values = 0.0
    disturbance: Values = 1.0


@dataclass(frozen=True, eq=False)
class Estimator(Held):
    """A stationary observer of a regulator's chain.

    Attributes:
        kind: "kalman" or "reduced".
        measured: Names of what is measured.
        reads: Where each stands in x = (q, v).
        seen: C (ny, 2m).
        L: Correction (2m, ny).
        poles: Of the estimate's error, slowest first, 1/s.
        spread: Standard deviations (2m,) of the estimate after a measurement.
        advance: A_d (2m, 2m).
        drive: B_d (2m, nu).
        covariance: P (2m, 2m) of the error after a measurement: P = K A_d P A_d^T K^T + K W K^T + L V L^T with K = 1 - L C.
    """

    kind: str
    measured: tuple[str, ...]
    reads: tuple[int, ...]
    seen: Vector
    L: Vector
    poles: Spectrum
    spread: Vector
    advance: Vector
    drive: Vector
    covariance: Vector

    @property
    def observer(self) -> Observer:
        """The frozen record that laws hold."""
        return Observer(self.kind, self.advance, self.drive, self.seen, self.L, np.linalg.pinv(self.seen))  # type: ignore[arg-type]

    def __str__(self) -> str:
        return (
            f"{self.kind} observer from {', '.join(self.measured)}, slowest eigenvalue of its error {self.poles[0].real:.6g} 1/s, "
            f"fastest {self.poles[-1].real:.6g}, largest correction {np.max(np.abs(self.L)):.4g}"
        )


def estimator(gains: Gains, sensors: Sensors | None = None, kind: str = "kalman") -> Estimator:
    """The stationary observer of the chain that a sampled regulator belongs to.

    Args:
        gains: A sampled regulator: its chain, equilibrium and period.
        sensors: What is measured, how well, and what disturbs; all positions by encoders unless given.
        kind: "kalman", or "reduced", which takes what is measured as it is.

    Raises:
        ControlError: The regulator is not sampled; a name is none of the state, or moves only to second order there; a number is not
            positive; or what is measured does not show a mode of the chain (names it, its margin and what would).
    """
    if kind not in KINDS:
        raise ControlError("observer", kind, "is no kind of observer", f"name one of {', '.join(KINDS)}")
    if not gains.sample:
        raise ControlError("sample", None, "is what an observer needs: it works from one sample to the next", "give the time between two")
    given = sensors or Sensors()
    reads, C, units = _seen(gains, given.measured)
    names = tuple(gains.on_state(gains.K).names[k] for k in reads)
    a, b = held(gains.A, gains.B, gains.sample)
    demand_sight(gains, names, C)
    V = np.diag(variances(given, names, units))
    if kind == "kalman" and not np.all(np.diag(V) > 0):
        raise ControlError(
            "resolution, noise", 0.0, "leave a measurement without error", 'give one of them, or take the observer "reduced"'
        )
    W = gathered(gains.A, _density(gains, given.disturbance), gains.sample)
    try:
        found: Filter = kalman(a, C, W, V, gains.sample) if kind == "kalman" else reduced(a, C, W, V, gains.sample)
    except np.linalg.LinAlgError as failure:
        raise ControlError(
            "disturbance", given.disturbance, f"leaves no stationary observer: {failure}", "disturb every coordinate, and measure more"
        ) from failure
    kept = np.eye(len(a.high)) - found.L @ C
    added = kept @ W.high @ kept.T + found.L @ V @ found.L.T
    covariance = solve_discrete_lyapunov(kept @ a.high, added)
    return Estimator(kind, names, reads, C, found.L, found.poles, found.spread, a.high, b.high, (covariance + covariance.T) / 2)


def _seen(gains: Gains, measured: tuple[str, ...] | None) -> tuple[tuple[int, ...], Vector, tuple[str, ...]]:
    """Where what is measured stands in x, C, and units: x - x_target = T^T z with the signed selection z = T (x - x_target)."""
    whole = gains.on_state(np.eye(gains.K.shape[1]))
    moves = np.any(whole.gains != 0, axis=0)
    if measured is None:
        reads = [k for k in range(len(whole.names) // 2) if moves[k]]
    else:
        reads = [_place(name, whole.names, moves) for name in measured]
    if not reads or len(set(reads)) < len(reads):
        raise ControlError("measured", list(measured or ()), "names nothing, or something twice", f"name some of {', '.join(whole.names)}")
    return tuple(reads), np.ascontiguousarray(whole.gains[:, reads].T), tuple(whole.units[k] for k in reads)


def _place(name: str, names: tuple[str, ...], moves: Vector) -> int:
    if name not in names:
        raise ControlError("measured", name, "is nothing of this chain's state", known_names(name, names))
    at = names.index(name)
    if not moves[at]:
        raise ControlError(
            "measured", name, "moves only to second order about this equilibrium and shows no deviation", "measure the horizontal parts"
        )
    return at


def variances(sensors: Sensors, names: tuple[str, ...], units: tuple[str, ...]) -> Vector:
    """Variance of every measurement, from its name and unit."""
    steps = resolutions(sensors, names, units)
    noise = sizes_by_name("noise", sensors.noise, names, [0.0] * len(names))
    return steps**2 / 12 + noise**2


def resolutions(sensors: Sensors, names: tuple[str, ...], units: tuple[str, ...]) -> Vector:
    """Step of every measurement, from its name and unit."""
    return sizes_by_name("resolution", sensors.resolution, names, [_step(unit) for unit in units])


def _step(unit: str) -> float:
    step = STEP if unit.startswith("m") else 2 * pi / COUNTS
    return 100 * step if unit.endswith("/s") else step


def _density(gains: Gains, disturbance: Values) -> Vector:
    """N (2m, 2m): white accelerations of the coordinates, and white inputs."""
    m = len(gains.A) // 2
    names = gains.state_names[:m]
    sizes = sizes_by_name("disturbance", disturbance, (*names, *gains.input_names), [1.0] * m + [0.0] * len(gains.input_names), m)
    found = gains.B @ np.diag(sizes[m:] ** 2) @ gains.B.T
    found[np.arange(m, 2 * m), np.arange(m, 2 * m)] += sizes[:m] ** 2
    return np.asarray(found)


def sizes_by_name(field: str, given: Values | None, names: tuple[str, ...], usual: list[float], first: int | None = None) -> Vector:
    """Numbers by name; one number is for all, or for the first of them."""
    found = np.array(usual)
    if isinstance(given, Mapping):
        for name, value in given.items():
            if name not in names:
                raise ControlError(field, name, "is nothing that it could be of", f"name some of {', '.join(names)}")
            found[names.index(name)] = _size(field, value)
    elif given is not None:
        found[:first] = _size(field, given)
    return found


def _size(field: str, value: object) -> float:
    given = number(field, value, "give a number that is not negative", ControlError)
    if not 0 <= given < np.inf:
        raise ControlError(field, value, "is negative or not finite", "give a number that is not negative")
    return given
