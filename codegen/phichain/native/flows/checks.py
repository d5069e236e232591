"""What the flows take from a caller: vectors, times, budgets and tolerances, each checked and brought into the type of the C."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from math import inf, isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.native.memory.arrays import converted
from phichain.native.memory.room import demand_room
from phichain.system.arrays import number, positive, whole

_MOST_STEPS: Final = 2 ** (8 * ctypes.sizeof(ctypes.c_ulong)) - 1


def step_budget(name: str, max_steps: int) -> int:
    """A budget that C can count.

    Raises:
        ToleranceError: It is no whole number, negative, or larger.
    """
    if type(max_steps) is int and 0 <= max_steps <= _MOST_STEPS:
        return max_steps
    return whole(f"{name}.max_steps", max_steps, 0, _MOST_STEPS, "leave it out for a million steps")


def forcing_of(function: str, forcing: Any, is_forced: bool, kind: np.dtype[Any]) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """Amplitude and angular frequency of A cos(omega t), each a number or one a trajectory; None for a chain that nothing forces.

    Raises:
        ArrayError: A forced chain is given none, a frequency is missing, they are not finite, or nothing forces the chain.
    """
    field = f"{function}.forcing"
    if not is_forced:
        if forcing is not None:
            raise ArrayError(field, forcing, "is given to a chain that nothing forces", "leave it out, or add [forcing] to the scene")
        return None
    if forcing is None:
        problem = "is missing, and the scene is forced by A cos(omega t)"
        raise ArrayError(field, None, problem, "give forcing=(amplitude, omega), and (0, 1) for none")
    if not isinstance(forcing, Sequence | np.ndarray) or isinstance(forcing, str) or len(forcing) != 2:
        problem = "is not an amplitude and its frequency" if np.size(forcing) != 1 else "is an amplitude without a forcing frequency"
        raise ArrayError(field, forcing, problem, "give forcing=(amplitude, omega), omega in rad/s")
    amplitude, omega = (finite(field, own(field, part, kind), "give finite numbers") for part in forcing)
    return amplitude, omega


def time_of(field: str, value: Any, kind: np.dtype[Any]) -> float:
    """A time that C can hold.

    Raises:
        ArrayError: It is no number, or not finite in the type of the C.
    """
    time = value if type(value) is float and isfinite(value) else number(field, value, "give a finite time in s")
    if abs(time) > _MOST[kind]:
        raise ArrayError(field, value, f"is outside the range of {kind}", "give a shorter time in s")
    return time


_MOST: Final = {np.dtype(kind): float(np.finfo(kind).max) for kind in (np.float64, np.float32)}


def vector(field: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change.

    Raises:
        ArrayError: it has another shape, or is not finite.
    """
    array = own(field, value, kind)
    if array.shape != (size,):
        raise ArrayError(field, array.shape, f"must have shape ({size},)", "give one vector")
    return finite(field, array)


def own(field: str, value: ArrayLike, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy in rows that C may change.

    Raises:
        ArrayError: It is ragged, or of a kind that real numbers cannot hold.
    """
    return np.array(converted(field, value, kind), order="C")


def finite(field: str, array: NDArray[Any], remedy: str = "give finite values") -> NDArray[Any]:
    """The array, if it is finite.

    Raises:
        ArrayError: it is not.
    """
    if not np.isfinite(array).all():
        raise ArrayError(field, array.tolist(), "is not finite", remedy)
    return array


def output_times(function: str, times: ArrayLike, t: float, t_end: float, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """The times at which states are wanted, in the order of travel from t to t_end.

    Raises:
        ArrayError: a time is not finite, they do not lie in that order, or no memory holds a state of that size at each.
    """
    wanted = converted(f"{function}.times", times, kind)
    demand_room(f"{function}.times", wanted.size, 1 + size, kind)
    grid = np.atleast_1d(own(f"{function}.times", wanted, kind))
    if grid.ndim != 1:
        raise ArrayError(f"{function}.times", grid.shape, "is no list of times", "give them one after the other")
    if not grid.size:
        return grid
    finite(f"{function}.times", grid, "give finite times")
    first, last, start, end = float(grid[0]), float(grid[-1]), float(kind.type(t)), float(kind.type(t_end))
    rises = start <= first and last <= end and bool((grid[1:] >= grid[:-1]).all())
    if not rises and not (start >= first and last >= end and bool((grid[1:] <= grid[:-1]).all())):
        problem = "do not lie between t and t_end in the order of travel"
        raise ArrayError(f"{function}.times", grid, problem, "sort them")
    return grid


def demand_alone(function: str, times: ArrayLike) -> None:
    """Refuse times where the ends of the flow's own steps are asked for.

    Raises:
        ArrayError: There are some.
    """
    if isinstance(times, tuple) and not times:
        return
    if np.size(times):
        problem = "are given, and so is own, which asks for the ends of the flow's own steps instead"
        raise ArrayError(f"{function}.times", times, problem, "leave one of them out")


def checked_tolerance(field: str, tol: float, usual: float = 1e-12) -> float:
    """The tolerance, if it is one.

    Raises:
        ToleranceError: it is not positive and finite.
    """
    return tol if type(tol) is float and 0 < tol < inf else positive(field, tol, f"use {usual:g}")


def demand_rounding(name: str, lost: NDArray[Any], way: NDArray[Any] | float) -> None:
    """Refuse what rounding cannot have taken from t: as much as the whole way, so that the end would be reached without a step.

    Raises:
        ArrayError: So much is said to be lost.
    """
    beyond = (np.abs(lost) >= np.abs(way)) & (np.abs(way) > 0)
    if np.any(beyond):
        worst = float(np.max(np.abs(lost)))
        raise ArrayError(name, worst, "is no rounding of t: it is as long as the way to t_end", "give what an earlier call left there")
