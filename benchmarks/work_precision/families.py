"""Single-harmonic families: Phi and its families against quadrature and closed forms, time per point."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import mpmath as mp
import numpy as np
from scipy.optimize import fsolve
from scipy.special import ellipkm1, j1

from benchmarks.work_precision.rows import Candidate
from benchmarks.work_precision.setup import built_afresh
from phichain.orbits import trace
from phichain.reference import reference
from phichain.scene import Scene
from phichain.system import System

_REPEAT = 200
_G = 9.81


def scene(links: int) -> Scene:
    """Paper A's chain with what its families need."""
    part = 1.0 / links
    return Scene(
        f"family{links}", links, mass=part, length=part, com=part / 2, actuated="all",
        want=["inverse_dynamics", "energy", "phi", "phi_jacobian"],
    )  # fmt: skip


def evaluations(links: int) -> list[Candidate]:
    """Phi at one amplitude and frequency: closed form against alternating frequency-time with M samples."""
    system, setup = built_afresh(scene(links))
    rng = np.random.default_rng(links)
    amplitude, omega = rng.uniform(0.2, 1.2, links), 3.0
    exact = reference(scene(links), "phi", {"amplitude": amplitude.tolist(), "omega": omega}, digits=30)[
        "phi"
    ]

    def error(found: Any) -> float:
        return float(
            max(abs(mp.mpf(a) - b) for a, b in zip(found.tolist(), exact, strict=True)) / max(map(abs, exact))
        )

    def repeated(function: Callable[[], Any]) -> Callable[[], Any]:
        def solve() -> Any:
            for _ in range(_REPEAT - 1):
                function()
            return function()

        return solve

    found = [
        Candidate(
            "phichain phi", "closed form", True, repeated(lambda: system.phi(amplitude, omega)), error, setup
        )
    ]
    for samples in (8, 16, 32, 64, 128):
        sampled = repeated(lambda samples=samples: projected(system, amplitude, omega, samples))
        found.append(
            Candidate(
                "frequency-time on compiled inverse dynamics", f"{samples} samples", False, sampled, error
            )
        )
    return found


def projected(system: System, amplitude: np.ndarray, omega: float, samples: int) -> np.ndarray:
    """(1/pi) int f cos tau dtau by the trapezoidal rule over a period, all samples in one batch."""
    tau = 2 * np.pi * np.arange(samples) / samples
    cosine, sine = np.cos(tau)[:, None], np.sin(tau)[:, None]
    q, v, a = amplitude * cosine, -omega * amplitude * sine, -(omega**2) * amplitude * cosine
    return 2 / samples * np.sum(system.inverse_dynamics(q, v, a) * cosine, axis=0)


def families(links: int) -> Iterator[Candidate]:
    """The first family up to 3 rad: followed by arclength, against solving on a grid of amplitudes."""
    system, setup = built_afresh(scene(links))

    def followed() -> np.ndarray:
        branch = trace(system, mode=1, amplitude_max=3.0 if links == 1 else 1.2)
        return np.asarray(branch.points)

    def solved() -> np.ndarray:
        rows, guess = [], np.array([*np.full(links - 1, 0.01), 4.0])
        for first in np.linspace(0.05, 3.0 if links == 1 else 1.2, 60):

            def residual(z: np.ndarray, first: float = first) -> np.ndarray:
                return projected(system, np.array([first, *z[:-1]]), float(z[-1]), 64)

            guess = fsolve(residual, guess, xtol=1e-13)
            rows.append([first, *guess])
        return np.array(rows)

    def error(points: np.ndarray) -> float:
        if links == 1:  # omega^2 = 2 g J1(A) / (r A), r = 1/2
            exact = np.sqrt(2 * _G * j1(points[:, 0]) / (0.5 * points[:, 0]))
            return float(np.max(np.abs(points[:, 1] / exact - 1)))
        worst = [np.max(np.abs(projected(system, z[:-1], z[-1], 128))) for z in points]
        return float(np.max(worst))

    yield Candidate("phichain trace", "default", True, followed, error, setup)
    yield Candidate("SciPy fsolve on frequency-time, 64 samples", "60 amplitudes", False, solved, error)


def points_of(links: int) -> int:
    """Points of the followed family."""
    system, _ = built_afresh(scene(links))
    return len(trace(system, mode=1, amplitude_max=3.0 if links == 1 else 1.2).points)


def one_harmonic_against_exact() -> list[tuple[float, float]]:
    """(amplitude, relative error of one harmonic's frequency) of one link: where one harmonic stops being true."""
    amplitudes = np.array([0.1, 0.5, 1.0, 2.0, 2.5, 3.0, np.pi - 1e-2, np.pi - 1e-4])
    one = np.sqrt(2 * _G * j1(amplitudes) / (0.5 * amplitudes))
    exact = np.pi * np.sqrt(_G / 0.5) / (2 * ellipkm1(np.cos(amplitudes / 2) ** 2))
    return list(zip(amplitudes.tolist(), (one / exact - 1).tolist(), strict=True))
