"""Arrays on their way to C: converted without loss of kind, checked, and laid out in rows.

Accepted is whatever NumPy converts within its kind or to a wider one: lists, integers, either precision.
Complex numbers, objects and text are refused, and so is every shape but the expected one, with or without a
leading axis.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.native.signature import Argument, Signature

REAL: Final[dict[str, np.dtype[Any]]] = {"double": np.dtype(np.float64), "float": np.dtype(np.float32)}
SCALAR: Final[dict[str, Any]] = {"float64": ctypes.c_double, "float32": ctypes.c_float}


@dataclass(frozen=True)
class Rows:
    """One input as C reads it.

    Attributes:
        values: Aligned array whose rows are contiguous; kept alive while C reads it.
        stride: Entries from one row to the next; 0 when all rows share the values.
        count: Number of rows, or None when all rows share the values.
    """

    values: NDArray[Any]
    stride: int
    count: int | None


def rows_of(function: str, argument: Argument, value: Any, real: np.dtype[Any]) -> Rows:
    """One input, with or without a leading batch axis.

    Args:
        function: Name of the function, for messages.
        argument: What it expects.
        value: What it got.
        real: The type that C computes in.

    Raises:
        ArrayError: The type has no loss-free conversion, or the shape is another.
    """
    array = converted(f"{function}.{argument.name}", value, real)
    if array.shape == argument.shape:
        return Rows(_packed(array), 0, None)
    if array.shape[1:] != argument.shape or array.ndim != len(argument.shape) + 1:
        raise wrong_shape(f"{function}.{argument.name}", argument, value, array, batch=True)
    array = _rows_packed(array)
    return Rows(array, array.strides[0] // array.itemsize, len(array))


Layout = tuple[tuple[int, ...], tuple[int, ...]]
"""Shape of one input, and bytes from entry to entry along each of its axes where it is packed."""


def layout(argument: Argument, real: np.dtype[Any]) -> Layout:
    """How one input lies in memory where C can read it."""
    return argument.shape, np.empty(argument.shape, real).strides


def steps_through(values: Sequence[Any], layouts: Sequence[Layout], real: np.dtype[Any]) -> tuple[int | None, list[int]]:
    """How C steps through inputs that are there already: arrays of its own type whose rows are packed.

    Returns:
        The number of rows, and address and stride (in entries) of every input; None and nothing where one has to be converted
        first, or is wrong, or none has a batch axis.
    """
    rows, places = None, []
    for value, (shape, packed) in zip(values, layouts, strict=True):
        if type(value) is not np.ndarray or value.dtype is not real or not (flags := value.flags).aligned:
            return None, []
        if value.shape == shape and flags.c_contiguous:
            places += [place(value), 0]
            continue
        stride, rest = divmod(value.strides[0], real.itemsize) if value.size else (-1, 0)
        if value.shape[1:] != shape or value.strides[1:] != packed or rest or stride < 0 or rows not in (None, len(value)):
            return None, []
        rows = len(value)
        places += [place(value), stride]
    return rows, places


def row_count(signature: Signature, inputs: Sequence[Rows]) -> int | None:
    """The common number of rows, or None when no input has a batch axis.

    Raises:
        ArrayError: Two inputs disagree.
    """
    batched = [
        (argument, rows.count)
        for argument, rows in zip(signature.inputs, inputs, strict=True)
        if rows.count is not None
    ]
    for argument, count in batched[1:]:
        if count != batched[0][1]:
            first = f"{batched[0][0].name} has {batched[0][1]}"
            problem = f"has {count} rows where {first}"
            remedy = (
                "give both the same number, or leave the batch axis of one away to share it between all rows"
            )
            raise ArrayError(f"{signature.name}.{argument.name}", count, problem, remedy)
    return batched[0][1] if batched else None


def address(array: NDArray[Any]) -> ctypes.c_void_p:
    """Where an array's entries begin, as C takes it."""
    return ctypes.c_void_p(place(array))


def place(array: NDArray[Any]) -> int:
    """Where an array's entries begin, as a number; 0 where there are none, for C reads nothing there."""
    if not array.size:
        return 0
    try:
        # A third of the time of array.ctypes, and a call takes microseconds.
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    except (TypeError, ValueError):  # nobody may write to it, or it does not lie in one piece
        return int(array.__array_interface__["data"][0])


def converted(field: str, value: Any, real: np.dtype[Any]) -> NDArray[Any]:
    """A value as an array of type `real`.

    Raises:
        ArrayError: It is ragged, or of a kind that real numbers cannot hold.
    """
    try:
        array = np.asarray(value)
    except Exception as error:  # a caller's object may fail in its own way when it is made an array
        problem = "cannot be read as an array of numbers"
        raise ArrayError(field, value, problem, "give rows of equal length") from error
    if array.dtype == real:
        return array.astype(real, copy=False)
    if not np.can_cast(array.dtype, real, "same_kind"):
        what, remedy = _other(array, real)
        raise ArrayError(field, value, f"holds {what} where real numbers are expected", remedy, dtype=array.dtype)
    with np.errstate(over="ignore"):  # what a float cannot hold becomes infinite, as it does in C
        return array.astype(real)


def _other(array: NDArray[Any], real: np.dtype[Any]) -> tuple[str, str]:
    """What stands where numbers should, and what to do about it: no function, text or None is converted to one."""
    if array.dtype.kind in "US":
        return "text", "give numbers"
    if array.dtype.kind == "c":
        return str(array.dtype), "give the real parts, if the imaginary ones are none"
    if array.dtype.kind != "O":
        return str(array.dtype), f"convert it to {real}"
    others = [entry for entry in array.flat if not isinstance(entry, int | float)]
    if any(callable(entry) for entry in others):
        return "a function", "call it, and give the numbers that it returns"
    if any(entry is None for entry in others):
        return "None", "give a number for each entry"
    return "objects", "give numbers"


def wrong_shape(field: str, argument: Argument, value: Any, array: NDArray[Any], batch: bool) -> ArrayError:
    alone = str(argument.shape) if argument.shape else "a single number"
    inner = "".join(f", {size}" for size in argument.shape) or ","
    wanted = f"{alone}, or (n{inner}) for n rows at once" if batch else alone
    return ArrayError(
        field,
        value,
        f"has shape {array.shape} where {alone} is expected",
        f"pass {wanted}",
        expected=argument.shape,
        shape=array.shape,
    )


def _packed(array: NDArray[Any]) -> NDArray[Any]:
    return np.require(array, requirements=["C", "A"])


def _rows_packed(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself where C can step through its rows (as in x[:, :nq]), a packed copy otherwise."""
    stride = array.strides[0]
    steppable = stride >= 0 and stride % array.itemsize == 0 and array.flags.aligned
    if steppable and len(array) > 0 and array[0].flags.c_contiguous:
        return array
    return _packed(array)
