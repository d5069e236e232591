"""Continuation: problem x predictor x corrector x events -> Branch, and the families of oscillations it follows."""

from phichain.continuation.branch import Branch, Special
from phichain.continuation.core import follow, start_on, walk
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Extremum, Fold, Level
from phichain.continuation.harmonic import LinearModes, harmonic_problem, linear_modes, trace
from phichain.continuation.options import Options
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

__all__ = [
    "Branch",
    "BranchPoint",
    "Engine",
    "Extremum",
    "Fold",
    "Level",
    "LinearModes",
    "Options",
    "Point",
    "Problem",
    "Special",
    "follow",
    "harmonic_problem",
    "linear_modes",
    "start_on",
    "trace",
    "walk",
]
