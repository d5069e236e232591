"""Continuation: problem x predictor x corrector x events -> Branch. It knows curves of solutions, not what they solve."""

from phichain.continuation.branch import Branch, Special
from phichain.continuation.core import follow, start_on, walk
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Extremum, Fold, Level, TestFunction
from phichain.continuation.options import Options
from phichain.continuation.point import Point
from phichain.continuation.problem import Evaluation, Extra, Problem

__all__ = [
    "Branch",
    "BranchPoint",
    "Engine",
    "Evaluation",
    "Extra",
    "Extremum",
    "Fold",
    "Level",
    "Options",
    "Point",
    "Problem",
    "Special",
    "TestFunction",
    "follow",
    "start_on",
    "walk",
]
