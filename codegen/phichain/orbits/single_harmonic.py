"""Single-harmonic families: theta_k = A_k cos(omega t) with Phi(A, omega) = 0 (equations (17), (20)-(22)).

The unforced chain is conservative: its in-phase oscillations come in one-parameter families (nonlinear normal
modes), which start at the linear modes of the hanging chain and are followed by arclength because they fold.
For one link the family is known: omega^2 = 2 g J1(A) / (r A).

Phi itself and its Jacobian are the system's callables `phi` and `phi_jacobian` (section 6 of docs/theory.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Evaluation,
    Extremum,
    Fold,
    Level,
    Options,
    Point,
    Problem,
    TestFunction,
    follow,
    start_on,
)
from phichain.orbits.modes import LinearModes
from phichain.orbits.run import Run
from phichain.orbits.targets import Target
from phichain.system import Parameters, System, Vector, input_arguments


def harmonic_problem(system: System, p: Parameters | None = None, *, omega: float, shape: Vector) -> Problem:
    """Phi(A, omega) = 0 as a continuation problem with unknowns (A_1 .. A_n, omega).

    One harmonic satisfies no equation of motion, so there is no motion to linearise about: the problem computes no
    multipliers, and its points carry none. Angles count in radians, a cart's amplitude in units of its share of the mode, omega in units of the mode's.

    Args:
        system: A planar system with `phi` and `phi_jacobian`.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s.
        shape: Its shape (n,).
    """
    phi, phi_jacobian = system.function("phi"), system.function("phi_jacobian")
    parameters = system.parameters(p)
    cart = np.abs(shape[: system.cart_size])
    scale = np.concatenate([np.where(cart > 0, cart, 1.0), np.ones(system.links), [omega]])

    def evaluate(z: Vector) -> Evaluation:
        at = z[:-1], float(z[-1])
        return Evaluation(np.asarray(phi(*at, **parameters)), np.asarray(phi_jacobian(*at, **parameters)))

    return Problem(
        evaluate=evaluate,
        names=(*_amplitude_names(system), "omega"),
        scale=scale,
        energy=energy_of_amplitude(system, p),
        error=omitted_harmonic(system, p, scale),
    )


def _amplitude_names(system: System) -> tuple[str, ...]:
    names = system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq))
    return tuple(f"amplitude_{name}" for name in names)


def energy_of_amplitude(system: System, p: Parameters | None = None) -> Callable[[Vector], float] | None:
    """z = (A, omega) -> energy of the orbit, J, counted from the hanging rest; None without an energy callable.

    At its turning point theta = A the chain is at rest, so that the energy is V(A) - V(0).
    """
    if not system.has("energy"):
        return None
    parameters, still = system.parameters(p), np.zeros(system.nv)

    def potential(q: Vector) -> float:
        return float(system.energy(q, still, **parameters)[1])

    @cache
    def bottom() -> float:
        return potential(np.zeros(system.nq))

    return lambda z: potential(np.asarray(z[:-1])) - bottom()


START = 1e-3
"""Largest angle of the first point, rad."""
UNTRUE = 0.05
"""Size of the first omitted harmonic, in amplitudes, from which one harmonic is no longer true."""
_SAMPLES = 16
"""Samples of half a period, the other half being its mirror image; what folds back onto the third harmonic is the 29th."""


def settings(options: Options | None) -> Engine:
    """Predictor, corrector and options of a family of one harmonic."""
    return Engine(options=options or Options(step_max=0.1, max_points=2000))


def trace_one_harmonic(
    system: System,
    modes: LinearModes,
    mode: int,
    target: Target,
    run: Run,
) -> Branch:
    """Follow the single-harmonic family of one mode from small amplitudes.

    Args:
        system: A planar, undamped system with `phi` and `phi_jacobian`; `energy` is used when present.
        modes: Its linear modes.
        mode: Number of the mode, from 1.
        target: Where to end.
        run: How it is followed.

    Returns:
        The Branch of (A, omega), with the folds in omega and in the first link's amplitude, branch points and (with an
        energy) extrema of the energy located; it carries no multipliers, and the first omitted harmonic as its error.

    Raises:
        AbsentFunctionError: The system lacks `phi` or `phi_jacobian`.
        ConvergenceError: Newton did not reach the family.
    """
    omega, shape = float(modes.omega[mode - 1]), modes.shapes[:, mode - 1]
    problem = harmonic_problem(system, run.p, omega=omega, shape=shape)
    first = run.earlier if run.earlier is not None else start_on(
        problem, np.append(run.amplitude_start * shape, omega), np.append(shape, 0.0), run.engine, fixed=True
    )  # fmt: skip
    tests = _tests(system, problem, run.amplitude_start, target, omega)
    name = f"{system.name}, mode {mode}, one harmonic"
    branch = follow(problem, first, run.engine, tests, name=name, through=run.through, progress=run.progress)
    return replace(branch, reason=branch.reason + _doubt(branch, system.cart_size))


def _doubt(branch: Branch, carts: int) -> str:
    """Where one harmonic stops being true, in words; empty where it is true all along."""
    largest = np.max(np.abs(branch.points[:, carts:-1]), axis=1)
    said = "; amplitudes beyond pi are of links that turn over, which one harmonic does not know" if np.any(largest > np.pi) else ""
    if branch.error is None or not np.any(untrue := branch.error > UNTRUE):
        return said
    first = int(np.argmax(untrue))
    return (
        f"; from the amplitude {largest[first]:.4g} on (s = {branch.arclength[first]:.4g}) one harmonic is no longer true:"
        f" the first omitted one is above {UNTRUE:.0%} of it{said}"
    )


def omitted_harmonic(system: System, p: Parameters | None, scale: Vector) -> Callable[[Point], float] | None:
    """Point of the family -> the largest third harmonic that theta = A cos(omega t) calls for, in its largest amplitude.

    The equations of motion along it leave a residual on cos(3 omega t), R_3; small oscillations answer it with
    (K - 9 omega^2 M) A_3 = -R_3. None without callables that say what is left over.
    """
    if not (system.has("forward_dynamics") and system.has("mass_matrix")):
        return None
    dynamics, mass_of, slope = (system.function(name) for name in ("forward_dynamics", "mass_matrix", "phi_jacobian"))
    parameters, still, carts = system.parameters(p), np.zeros(system.nq), system.cart_size
    inputs = input_arguments(system, still, None)
    phase = np.pi * np.arange(_SAMPLES) / _SAMPLES

    def size(point: Point) -> float:
        z = point.y * scale
        amplitude, omega = z[:-1], float(z[-1])
        left = np.zeros(system.nq)
        for angle in phase:
            q, v = amplitude * np.cos(angle), -omega * amplitude * np.sin(angle)
            wanted = -(omega**2) * q - np.asarray(dynamics(q, v, *inputs, **parameters))
            left += np.asarray(mass_of(q, **parameters)) @ wanted * (2 / _SAMPLES * np.cos(3 * angle))
        answer = np.linalg.lstsq(np.asarray(slope(still, 3 * omega, **parameters))[:, :-1], -left, rcond=None)[0]
        return float(np.max(np.abs(answer[carts:])) / np.max(np.abs(amplitude[carts:])))

    return size


def _tests(system: System, problem: Problem, start: float, target: Target, omega: float) -> list[TestFunction]:
    cart = system.cart_size

    def amplitude(z: Vector) -> float:
        return float(np.max(np.abs(z[cart:-1])))

    tests: list[TestFunction] = [
        Fold(name="fold in omega"),
        Fold(cart, f"fold in {problem.names[cart]}"),
        BranchPoint(),
    ]
    if problem.energy is not None:
        tests.append(Extremum(problem.energy, "energy extremum"))
    return [
        *tests,
        target.level(system, problem),
        Level(amplitude, start / 2, "back at rest"),
        Level(lambda z: float(z[-1]), 1e-3 * omega, "omega near zero"),
    ]
