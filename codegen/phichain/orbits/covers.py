"""Covers: where a family runs through another one that is traversed K times in its period, and which family that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Options,
    Point,
    Problem,
    Special,
    predictors,
    start_on,
)
from phichain.continuation.compiled.protocol import Watch
from phichain.continuation.compiled.strides import Behind, strides
from phichain.continuation.steps import StepTooSmallError
from phichain.errors import ConvergenceError
from phichain.orbits.modes import LinearModes
from phichain.orbits.quarter import EPS, quarter_problem
from phichain.orbits.targets import LARGEST
from phichain.system import Parameters, System, Vector

_MOST: Final = 99
"""Traversals that are looked for; they are odd, for only then is a quarter period of the one an odd number of the other's."""
_CLOSE: Final = 1e-6
"""Distance, in amplitudes, at which an orbit has come back."""
_SMALL: Final = 0.03
"""Largest angle, rad, at which a family has the frequency of its linear mode to 1e-3."""
_LONGEST: Final = (0.08, 0.02)
"""Steps of a family, and of one near the rest, where it meets the chain that hangs still: longer ones could leap over that."""
_NEAR: Final = 0.25
"""Largest angle, rad, near the rest."""
_ROUGH: Final = 1e-6
"""Corrections that are good enough, and taken without asking again, on the way to a name."""
_FLOW: Final = 1e-7
"""Tolerance of the flow there."""
_ENGINES: Final = tuple(Engine(predictors.osculating, options=Options(step_max=longest, tol=_ROUGH, trust=_ROUGH)) for longest in _LONGEST)
_STEPS: Final = 400
_TURNING: Final = 5
"""Traversals from which energy and frequency turn at the cover itself."""
_BESIDE: Final = 1e-5
"""Arclength within which they are found then."""
_WIDEST: Final = 0.5
"""Arclength over which it may be."""
_FLAT: Final = 1e-8
"""|kappa - 1| below which the brake-loss function is as good as zero."""


def traversals(system: System, p: Parameters | None, z: Vector) -> int:
    """How often the brake orbit z = (q_0, omega) runs through a shorter one; 1 where it does not."""
    start, period = z[:-1], 2 * np.pi / z[-1]
    counts = np.arange(_MOST, 2, -2)
    found = system.propagate(
        start, np.zeros(system.nv), 0.0, period / counts[-1], EPS, times=period / counts, **system.parameters(p)
    )
    size = np.abs(start).max()
    gap = np.abs(found.q_at - start).max(axis=1) + np.abs(found.v_at).max(axis=1) * period / (2 * np.pi * counts)
    back = counts[gap < _CLOSE * size]
    return int(back[0]) if back.size else 1


def mode_of(system: System, p: Parameters | None, modes: LinearModes, z: Vector) -> int:
    """The linear mode that the family of the brake orbit z = (q_0, omega) starts from; 0 where that is not found.

    The family is followed to small amplitudes, where it has the mode's frequency and shape.
    """
    nearest = int(np.argmin(np.abs(modes.omega / z[-1] - 1)))
    problem = quarter_problem(system, p, omega=float(modes.omega[nearest]), shape=modes.shapes[:, nearest], tol=_FLOW)
    far, near = _ENGINES
    try:
        points = [start_on(problem, z, np.append(-z[:-1], 0.0), far)]
        for engine, until in ((far, _NEAR), (near, _SMALL)):
            points, step = points[-1:], engine.options.step
            for _ in range(_STEPS):
                largest = max(map(abs, points[-1].z(problem)[system.cart_size : -1].tolist()))
                if largest <= until:
                    break
                points, step = _gone(problem, points, step, engine, until)
            else:
                return 0
            if largest <= _SMALL:
                return _likest(system, modes, points[-1].z(problem))
    except (ConvergenceError, StepTooSmallError):
        pass
    return 0


def _gone(problem: Problem, points: Sequence[Point], step: float, engine: Engine, until: float) -> tuple[list[Point], float]:
    """The last points of a family after some more steps, none beyond the one that comes below an angle; and the step to try."""
    last = points[-predictors.TOUCHED :]
    sigmas = [BranchPoint().value(problem, point) for point in last]
    behind = Behind(last, sigmas, [(1.0,)], step, 0, points[0])
    taken = strides(problem, behind, engine, [Watch(*LARGEST, until, 0)], _STEPS)
    points = list(last)
    for stride in taken:
        if isinstance(stride, BaseException):
            raise stride
        points.append(stride.point)
        step = stride.step
    return points, step


def _likest(system: System, modes: LinearModes, z: Vector) -> int:
    """The number of the mode that a small orbit is one of."""
    angles, own = z[system.cart_size : -1], modes.shapes[system.cart_size :]
    likeness = np.abs(angles @ own) / np.linalg.norm(own, axis=0) - 1e3 * np.abs(modes.omega / z[-1] - 1)
    return int(np.argmax(likeness)) + 1


def named(system: System, p: Parameters | None, modes: LinearModes, event: Special) -> Special:
    """A branch point under its own name: "cover K of mode J", or as it is."""
    count = traversals(system, p, event.z)
    if count == 1:
        return event
    shorter = np.append(event.z[:-1], count * event.z[-1])
    mode = mode_of(system, p, modes, shorter)
    whose = f"mode {mode}" if mode else f"an orbit of omega {count * event.z[-1]:.10g}"
    return replace(event, kind=f"cover {count} of {whose}")


def gathered(branch: Branch, events: Sequence[Special]) -> list[Special]:
    """The events with what belongs to a cover at the cover itself.

    On a K-fold cover of an elliptic orbit mu touches 1 with both of its vectors, so that the brake is lost there; but with
    amplitude e beside it the function whose zero that is goes as e^(K - 2): of it only rounding is left over a long stretch.
    Energy and frequency go as e^2 + O(e^(K - 2)): for K of 5 and more they turn at the cover, where Newton has fewest digits.
    """
    kept = list(events)
    for cover in (event for event in events if event.kind.startswith("cover")):
        beside = [event for event in kept if event.kind == "brake loss" and _is_flat(branch, event.arclength, cover.arclength)]
        for event in beside:
            kept.remove(event)
        if len(beside) % 2:
            kept.append(replace(cover, kind="brake loss"))
        if int(cover.kind.split()[1]) >= _TURNING:
            kept = [replace(cover, kind=event.kind) if _turns_at(event, cover) else event for event in kept]
    # What lies at the cover itself has one order, whatever rounding made of it.
    return sorted(kept, key=lambda event: (event.arclength, not event.kind.startswith("cover"), event.kind))


def _turns_at(event: Special, cover: Special) -> bool:
    return event.kind in ("energy extremum", "fold omega") and abs(event.arclength - cover.arclength) < _BESIDE


def _is_flat(branch: Branch, a: float, b: float) -> bool:
    """Whether one kappa is 1 to round-off all the way from one arclength to another."""
    low, high = min(a, b), max(a, b)
    if high - low > _WIDEST:
        return False
    between = branch.multipliers[(branch.arclength >= low) & (branch.arclength <= high)]
    return bool(np.all(np.min(np.abs(between - 1), axis=1, initial=np.inf) < _FLAT))
