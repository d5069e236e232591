"""Single-harmonic families: theta_k = A_k cos(omega t) with Phi(A, omega) = 0 (equations (17), (20)-(22)).

The unforced chain is conservative: its in-phase oscillations come in one-parameter families (nonlinear normal
modes), which start at the linear modes of the hanging chain and are followed by arclength because they fold.
For one link the family is known: omega^2 = 2 g J1(A) / (r A).

Phi itself and its Jacobian are the system's callables `phi` and `phi_jacobian` (section 6 of docs/theory.md).
"""

from __future__ import annotations

from collections.abc import Callable

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
    Problem,
    TestFunction,
    follow,
    start_on,
)
from phichain.errors import ArrayError, ToleranceError
from phichain.orbits.modes import linear_modes
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import positive, whole


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

    bottom = potential(np.zeros(system.nq))
    return lambda z: potential(np.asarray(z[:-1])) - bottom


def trace(
    system: System,
    mode: int = 1,
    amplitude_max: float = np.pi,
    *,
    p: Parameters | None = None,
    amplitude_start: float = 1e-3,
    options: Options | None = None,
    engine: Engine | None = None,
) -> Branch:
    """Follow the single-harmonic family of one mode from small amplitudes.

    Args:
        system: A planar, undamped system with `phi` and `phi_jacobian`; `energy` is used when present.
        mode: Number of the mode, from 1, by rising linear frequency.
        amplitude_max: The run ends where the largest |A_k| of the angles reaches this, rad.
        p: Runtime parameters by name.
        amplitude_start: Largest angle of the first point, rad.
        options: Step control and limits; `Options(step_max=0.1, max_points=2000)` unless given.
        engine: Predictor, corrector and options together; excludes `options`.

    Returns:
        The Branch of (A, omega), with the folds in omega and in the first link's amplitude, branch points and (with an
        energy) extrema of the energy located; it carries no multipliers.

    Raises:
        AbsentFunctionError: The system lacks `phi` or `phi_jacobian`.
        UnsupportedError: The scene is spatial or damped.
        ArrayError: No mode has that number.
        ToleranceError: Amplitudes not positive, or start not below the end.
        ConvergenceError: Newton did not reach the family.
    """
    remedy = "give an angle in rad"
    amplitude_start = positive("amplitude_start", amplitude_start, remedy)
    amplitude_max = positive("amplitude_max", amplitude_max, remedy)
    if not amplitude_start < amplitude_max:
        raise ToleranceError(
            "amplitude_start, amplitude_max",
            (amplitude_start, amplitude_max),
            "must be positive, finite and rising",
            "leave the start at 1e-3, and end at a larger angle in rad, such as 3",
        )
    modes = linear_modes(system, p)
    mode = whole("mode", mode, 1, len(modes.omega), f"this chain has the modes 1 .. {len(modes.omega)}", ArrayError)
    omega, shape = float(modes.omega[mode - 1]), modes.shapes[:, mode - 1]
    problem = harmonic_problem(system, p, omega=omega, shape=shape)
    for field, given, kind in (("options", options, Options), ("engine", engine, Engine)):
        if given is not None and not isinstance(given, kind):
            raise ArrayError(field, given, f"is no {kind.__name__}", "leave it out, or make one")
    engine = engine or Engine(options=options or Options(step_max=0.1, max_points=2000))
    direction = np.append(shape, 0.0)
    start = start_on(problem, np.append(amplitude_start * shape, omega), direction, engine, fixed=True)
    tests = _tests(problem, system.cart_size, amplitude_start, amplitude_max, omega)
    return follow(problem, start, engine, tests, name=f"{system.name}, mode {mode}, one harmonic")


def _tests(problem: Problem, cart: int, start: float, stop: float, omega: float) -> list[TestFunction]:
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
        Level(amplitude, stop, "amplitude_max"),
        Level(amplitude, start / 2, "back at rest"),
        Level(lambda z: float(z[-1]), 1e-3 * omega, "omega near zero"),
    ]
