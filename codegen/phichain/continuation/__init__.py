"""Continuation: problem x predictor x corrector x events -> Branch. It knows curves of solutions, not what they solve."""

from phichain.continuation.branch import Branch
from phichain.continuation.core import follow, start_on
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Extremum, Fold, Level, Quantity, TestFunction
from phichain.continuation.met.specials import Passage, Special
from phichain.continuation.options import Options
from phichain.continuation.point import Point, Reached
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
    "Passage",
    "Point",
    "Problem",
    "Quantity",
    "Reached",
    "Special",
    "TestFunction",
    "follow",
    "start_on",
]
