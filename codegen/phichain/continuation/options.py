"""Options of a continuation run, checked when they are made."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from phichain.errors import ToleranceError
from phichain.system.arrays import positive, whole


@dataclass(frozen=True)
class Options:
    """Step control and limits.

    Attributes:
        step: First arclength step (in scaled unknowns).
        step_min: Smallest step; a run that needs a smaller one ends there and says so.
        step_max: Largest step.
        max_points: Number of points after which the run ends.
        tol: Newton stops when its last correction is below tol (1 + |y|), y the scaled unknowns; convergence is
            quadratic, so what is left is about its square. It takes no correction that is rounding.
        trust: A correction below trust (1 + |y|) is taken without asking the problem again: the Jacobian, and what came with it, stay those of the
            place before. Nothing is trusted on the way of a run, for one that goes on finds only the places; events are looked for so.
        max_iterations: Newton iterations allowed per point.
        max_angle: Largest turn of the tangent in one step, rad; larger ones are repeated with a smaller step, which
            keeps the run from jumping to another branch.
        aim_angle: Turn per step that the step control aims at, rad.
        max_change: Largest eigenvalue of [J; t]^-1 dJ over one step: how far the Jacobian may change in its own units, whatever those of
            the equations. Below 1 no step can reach a singular Jacobian unseen, so that none jumps a gap.
    """

    step: float = 0.02
    step_min: float = 1e-7
    step_max: float = 0.2
    max_points: int = 1000
    tol: float = 1e-11
    trust: float = 0.0
    max_iterations: int = 7
    max_angle: float = 0.3
    aim_angle: float = 0.1
    max_change: float = 0.7

    def __post_init__(self) -> None:
        for item in fields(self):
            given = getattr(self, item.name)
            value: Any = 0.0 if item.name == "trust" and given == 0 else positive(f"options.{item.name}", given, "leave it out")
            if item.name in ("max_points", "max_iterations"):
                value = whole(f"options.{item.name}", value, 2, 2**31, "leave it out")
            object.__setattr__(self, item.name, value)
        if not self.step_min <= self.step <= self.step_max:
            raise ToleranceError(
                "options.step",
                self.step,
                f"must lie between step_min = {self.step_min:g} and step_max = {self.step_max:g}",
                "change one of the three",
            )
        if not self.aim_angle < self.max_angle < math.pi / 2:
            raise ToleranceError(
                "options.max_angle",
                self.max_angle,
                f"must lie between aim_angle = {self.aim_angle:g} and pi/2",
                "use 0.3",
            )
