"""One orbit of a family: chosen by a quantity, refined by Newton, propagated over its period."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from phichain.continuation import Branch, Engine, Options, Point, Problem, predictors, start_on
from phichain.continuation.point import tangent_of
from phichain.continuation.problem import Multipliers, relative_residual
from phichain.continuation.record import demand_unknowns
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits.closed.kinds import KINDS, problem_of, state_of
from phichain.orbits.conical.problem import conical_problem
from phichain.orbits.conical.starts import METHOD as CONICAL
from phichain.orbits.conical.turning import turning
from phichain.orbits.in_plane import METHOD as IN_PLANE
from phichain.orbits.in_plane import at_rest, plane_problem
from phichain.orbits.in_space import METHOD as IN_SPACE
from phichain.orbits.in_space import space_problem, state_at_rest
from phichain.orbits.in_space.problem import kept_of, pairs_of
from phichain.orbits.orbit import Orbit
from phichain.orbits.quarter import EPS
from phichain.orbits.run import demand_same_values
from phichain.orbits.shooting import demand_shooting
from phichain.orbits.targets import Target, target_of
from phichain.orbits.unmirrored import METHOD as UNMIRRORED
from phichain.orbits.unmirrored import problem_of_branch
from phichain.orbits.unmirrored.problem import read_closing, state_of_free
from phichain.orbits.whirling.fixed import turned
from phichain.orbits.whirling.problem import state_of_whirl, whirling_of
from phichain.orbits.whirling.starts import METHOD as WHIRLING
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import whole
from phichain.system.drawn import looks

SAMPLES = 241
"""Samples of a period."""
_MIRRORED = ("quarter", "half", IN_PLANE, IN_SPACE)
_REMEDY = 'write "theta_1=1.2", "amplitude=2", "omega=3", "energy=1.5", "point=17" or "event=2"'


def pick(system: System, branch: Branch, at: Any = None, p: Parameters | None = None, *, samples: int = SAMPLES) -> Orbit:
    """One orbit of a family.

    Args:
        system: The chain of the family, with the functions that its method calls.
        branch: The family. One of harmonics names the start from which Newton finds an orbit of the whole equations.
        at: "WHAT=VALUE" as in `trace`: where the family first has it; "point=K" or "event=K", counted from 1; None for its last point.
        p: Runtime parameters.
        samples: Points over the period, its end included.

    Raises:
        ArrayError: The branch belongs to another scene, or has no such orbit.
        UnsupportedError: The branch's method is none of these, or the system lacks what it needs.
        ConvergenceError: Newton did not come back to the family.
    """
    if branch.digest != system.digest:
        raise ArrayError(
            "branch", branch.scene or branch.digest, f"is the scene of that branch, and '{system.name}' is another one",
            "name the scene that it was traced with",
        )  # fmt: skip
    demand_same_values("branch", system, branch, p)
    samples = whole("samples", samples, 2, 10_000_000, "ask for two or more", ArrayError)
    kind = _kind(branch)
    problem = _problem(system, branch, kind, p)
    demand_unknowns(problem, branch)
    carts = int(system.has_cart and kind != IN_PLANE)
    point = _chosen(system, problem, branch, at, carts)
    z = point.z(problem)
    turn = float(z[-2]) if kind in (UNMIRRORED, WHIRLING) else 0.0
    if kind == CONICAL:
        t, q, v, closure = _turned(system, z, p, samples)
    else:
        t, q, v, closure = _swung(system, *_start(system, branch, kind, z), float(z[-1]), p, samples, turn)
    return Orbit(
        scene=branch.scene, digest=branch.digest, method=kind, mode=branch.mode,
        space=system.space, omega=float(z[-1]), energy=float("nan") if problem.energy is None else problem.energy(z),
        turn=turn, kappa=np.array(point.multipliers), multipliers=_floquet(point.multipliers, kind),
        error=_error(problem, point, at), closure=closure, t=t, q=q, v=v,
        q_names=system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq)),
        v_names=system.v_names or tuple(f"v_{k + 1}" for k in range(system.nv)), p=system.values(p), tol=branch.tol, **looks(system, p),
    )  # fmt: skip


def _error(problem: Problem, point: Point, at: Any) -> float:
    """What the method believes of omega; of an event nothing, for it was located by another system of equations."""
    if problem.error is None or str(at).partition("=")[0].strip() == "event":
        return float("nan")
    return problem.error(point)


def _kind(branch: Branch) -> str:
    """Which orbits the family is of; one harmonic stands for brake orbits.

    Raises:
        UnsupportedError: They are none that are refined here.
    """
    if branch.method in (CONICAL, IN_PLANE, IN_SPACE, UNMIRRORED, WHIRLING):
        return branch.method
    kind = branch.closing or "quarter"
    if branch.method not in ("shooting", "one harmonic", "harmonics") or kind not in KINDS:
        raise UnsupportedError(
            "branch.method", branch.method, "is none whose orbits are refined here", 'trace the family with method = "shooting"'
        )
    return kind


def _problem(system: System, branch: Branch, kind: str, p: Parameters | None) -> Problem:
    """The problem that the family, or the true one beside it, solves.

    Raises:
        UnsupportedError: The system lacks what it needs.
    """
    if kind == CONICAL:
        return conical_problem(system, p, omega=float(branch.scale[-1]))
    if kind == IN_PLANE:
        return plane_problem(system, p, omega=float(branch.scale[-1]))
    if kind == IN_SPACE:
        return space_problem(system, p, omega=float(branch.scale[-1]), kept=kept_of(branch.closing))
    if kind == UNMIRRORED:
        return problem_of_branch(system, p, branch)
    if kind == WHIRLING:
        return whirling_of(system, p, branch)
    demand_shooting(system)
    return problem_of(system, p, kind, branch.scale)


def _chosen(system: System, problem: Problem, branch: Branch, at: Any, carts: int) -> Point:
    """The orbit that is asked for.

    Raises:
        ArrayError: The family has none such.
    """
    what, _, text = str(at).partition("=")
    if at is None or what.strip() == "point":
        k = len(branch) - 1 if at is None else _number(at, text, len(branch), "points")
        return _refined(problem, branch.points[k], branch.tangent[k], False)
    if what.strip() == "event":
        # Newton may stall beside what it marks, and it was located better than that.
        event = branch.own_events[_number(at, text, len(branch.own_events), "events")]
        y = event.z / problem.sizes
        residual, jacobian, extra = problem.at(y)
        along = branch.tangent[event.index] / problem.sizes
        size = relative_residual(residual, jacobian, y)
        return Point(y, tangent_of(jacobian, along), event.arclength, jacobian, size, 0, (), extra)
    target = target_of(system, at)
    assert target is not None
    if target.what not in ("omega", "energy") and branch.closing not in ("", "quarter", IN_PLANE) and branch.method not in (IN_SPACE, WHIRLING):
        raise ArrayError("at", at, f"is no matter of the starts of this family, {branch.closing} periods", "use omega, energy, point or event")
    values = np.array([target.level(system, problem, carts).scalar(z) for z in branch.points])
    if values[-1] == target.value:
        return _refined(problem, branch.points[-1], branch.tangent[-1], False)
    crossed = np.flatnonzero((values[:-1] - target.value) * (values[1:] - target.value) <= 0)
    if not crossed.size:
        raise ArrayError(
            "at", at, f"is not met: along this family {target.what} goes from {np.min(values):.6g} to {np.max(values):.6g}",
            "choose a value between these, or trace further",
        )  # fmt: skip
    return _between(system, problem, branch, target, int(crossed[0]), carts)


def _number(at: Any, text: str, count: int, what: str) -> int:
    """An index from a number that counts from 1."""
    if not text.strip().isdecimal() or not 1 <= int(text) <= count:
        raise ArrayError("at", at, f"is none of this family's {count} {what}", _REMEDY)
    return int(text) - 1


def _between(
    system: System, problem: Problem, branch: Branch, target: Target, k: int, carts: int
) -> Point:
    """Where the family has the value between its points k and k + 1."""
    level = target.level(system, problem, carts)
    low, high = branch.points[k], branch.points[k + 1]
    length = branch.arclength[k + 1] - branch.arclength[k]

    def along(share: float) -> Vector:
        """Hermite's cubic through both points and their tangents."""
        rest = 1 - share
        ends = low * (rest**2 * (1 + 2 * share)) + high * (share**2 * (1 + 2 * rest))
        return ends + length * share * rest * (rest * branch.tangent[k] - share * branch.tangent[k + 1])

    def off(share: float) -> float:
        return level.scalar(_refined(problem, along(share), high - low, False).z(problem)) - target.value

    if level.held is None:
        share = float(brentq(off, 0.0, 1.0, xtol=1e-15))
        return _refined(problem, along(share), high - low, False)
    share = float(brentq(lambda s: level.scalar(along(s)) - target.value, 0.0, 1.0))
    guess = along(share)
    index, value = level.held(guess)
    guess[index] = value
    return _refined(problem, guess, np.eye(len(guess))[index], True)


def _refined(problem: Problem, guess: Vector, direction: Vector, is_kept: bool) -> Point:
    return start_on(problem, guess, direction, Engine(predictors.cubic, options=Options(tol=1e-9)), fixed=is_kept)


def _start(system: System, branch: Branch, kind: str, z: Vector) -> tuple[Vector, Vector]:
    """(q, v) of the orbit z."""
    if kind == IN_SPACE:
        return state_at_rest(system.links, pairs_of(z, kept_of(branch.closing))), np.zeros(system.nv)
    if kind == IN_PLANE:
        at = at_rest(system, z)
        return at.q, at.v
    if kind in (UNMIRRORED, WHIRLING):
        x = state_of_whirl(z) if kind == WHIRLING else state_of_free(z, read_closing(branch.closing)[2])
        return x[: system.nq], x[system.nq :]
    return state_of(kind, z)


def _swung(
    system: System, start: Vector, rates: Vector, omega: float, p: Parameters | None, samples: int, turn: float = 0.0
) -> tuple[Vector, Vector, Vector, float]:
    """An orbit over its period (t, q, v), and how well it closes, turned back about the vertical by `turn` where it whirls."""
    period = 2 * np.pi / omega
    t = np.linspace(0.0, period, samples)
    found = system.propagate(start, rates, 0.0, period, EPS, times=t[1:], **system.parameters(p))
    q, v = np.vstack([start, found.q_at]), np.vstack([rates, found.v_at])
    ends = (turned(q[-1], -turn), turned(v[-1], -turn)) if turn else (q[-1], v[-1])
    off = np.abs(ends[0] - start).max() / np.abs(q).max() + np.abs(ends[1] - rates).max() / np.abs(v).max()
    return t, q, v, float(off)


def _turned(system: System, z: Vector, p: Parameters | None, samples: int) -> tuple[Vector, Vector, Vector, float]:
    """A conical orbit over one turn (t, q, v): its start, turned; what is left of Omega G x - f(x) over one turn is how well it closes."""
    at, rate = turning(system, z), float(z[-1])
    t = np.linspace(0.0, 2 * np.pi / rate, samples)
    cosine, sine = np.cos(rate * t)[:, None], np.sin(rate * t)[:, None]
    # What lies along the vertical does not turn: -G G x is the rest.
    flat = -(at.about @ at.spun)
    x = (at.x - flat) + cosine * flat + sine * at.spun
    problem = conical_problem(system, p, omega=rate)
    left = problem.evaluate(z).residual
    q, v = x[:, : system.nq], x[:, system.nq :]
    return t, q, v, float(np.abs(left).max() * 2 * np.pi / rate / np.abs(v).max())


def _floquet(kappa: Multipliers, kind: str) -> Multipliers:
    """lambda and 1/lambda (2 k,) of every kappa: mu^2 where kappa belongs to half a period and its mirror image, else mu itself."""
    root = np.sqrt(kappa - 1) * np.sqrt(kappa + 1)
    # Of the two the larger loses nothing, and the other is its inverse.
    large = np.where(np.abs(kappa + root) >= np.abs(kappa - root), kappa + root, kappa - root)
    mu = np.stack([large, 1 / large], axis=1).ravel()
    return np.asarray(mu**2 if kind in _MIRRORED else mu, complex)
