"""Python callables of emitted functions: shape-checked, whole trajectories at once, other threads running.

A single state, given as arrays or lists of numbers, takes a short path: its values are copied into preallocated
buffers whose addresses C already knows. Other types are converted first, and a batch goes through the function's
row loop in one foreign call. Whatever the short path does not take goes the long way, which says what is wrong.

A buffer set serves one call at a time and goes back to its pool afterwards, so threads never share one.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy import ndarray
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.native.memory.arrays import (
    SCALAR,
    Rows,
    address,
    layout,
    place,
    row_count,
    rows_of,
    steps_through,
)
from phichain.native.memory.parameters import ParameterBlock
from phichain.native.memory.room import demand_room
from phichain.native.memory.slots import slot
from phichain.native.signature import Argument, Signature

SIZE = ctypes.c_size_t
"""What C takes for a number of rows, a stride, or an address."""

Arrays = Any
"""One array, or a tuple of arrays for functions with several outputs."""

_Short = tuple[tuple[int, ...], NDArray[Any], Callable[[Any], bool]]
"""The shape of a buffer, the buffer, and what fills it from anything but an array of its own type."""


@dataclass(frozen=True)
class Kept:
    """A struct that C makes of the runtime parameters and takes in their place.

    Attributes:
        make: The foreign function of parameters and struct.
        size: Its bytes.
    """

    make: Callable[..., None]
    size: int


def struct_of(size: int) -> NDArray[np.float64]:
    """Memory of a struct of so many bytes, aligned for numbers."""
    return np.zeros(-(-size // ctypes.sizeof(ctypes.c_double)))


def make_callable(
    signature: Signature, function: Callable[..., None], row_loop: Callable[..., None], real: np.dtype[Any],
    kept: Kept | NDArray[Any] | None = None,
) -> Callable[..., Arrays]:  # fmt: skip
    """Wrap an emitted function as a Python function of its inputs and the keyword ``p``.

    Args:
        signature: What the function takes and returns.
        function: The foreign function ``NAME_f``.
        row_loop: The foreign function ``NAME_rows_f``.
        real: The type that C computes in.
        kept: What C takes in place of the runtime parameters: made of them whenever they change, or a struct that is there.

    Returns:
        A callable that raises `ArrayError` for arrays of the wrong number, shape or type.
    """
    count, takes_parameters = len(signature.inputs), signature.takes_parameters
    layouts, row_size = [layout(item, real) for item in signature.inputs], sum(item.size for item in signature.outputs)
    idle: list[_Frame] = []

    def call(*values: Any, p: Mapping[str, Any] | None = None) -> Arrays:
        if len(values) != count:
            _refuse_count(signature, values)
        try:
            frame = idle.pop()
        except IndexError:
            frame = _Frame(signature, real, kept)
        if not _copied(values, frame.slots, real):
            rows, places = steps_through(values, layouts, real)
            if rows is None:
                inputs = _checked(signature, values, real)
                rows = row_count(signature, inputs)
                places = [part for item in inputs for part in (place(item.values), item.stride)]
            if rows is not None:
                if takes_parameters or p is not None:
                    frame.fill(p)
                demand_room(signature.name, rows, row_size, real)
                outputs = [np.empty((rows, *item.shape), real) for item in signature.outputs]
                row_loop(SIZE(rows), *frame.block, *map(SIZE, places), *map(address, outputs))
                idle.append(frame)
                return outputs[0] if len(outputs) == 1 else tuple(outputs)
            frame.take(inputs)
        if takes_parameters or p is not None:
            frame.fill(p)
        function(*frame.arguments)
        result = frame.result()
        idle.append(frame)
        return result

    return _described(call, signature, real)


def _copied(values: Iterable[Any], slots: Iterable[_Short], real: np.dtype[Any]) -> bool:
    """Fill buffers from values that need no conversion; False at the first that does."""
    # Callers counted the values; checking again would take a tenth of the whole call.
    for value, (shape, buffer, take) in zip(values, slots):  # noqa: B905
        if type(value) is ndarray and value.dtype is real and value.shape == shape:
            buffer[...] = value
        elif not take(value):
            return False
    return True


def _short(shape: tuple[int, ...], buffer: NDArray[Any]) -> _Short:
    return shape, buffer, slot(shape, buffer).take


class _Frame:
    """Preallocated buffers of one call, and the arguments C takes for them."""

    __slots__ = ("arguments", "block", "fill", "kept", "result", "slots")

    def __init__(self, signature: Signature, real: np.dtype[Any], kept: Kept | NDArray[Any] | None) -> None:
        parameters = ParameterBlock(signature, real)
        self.slots: list[_Short] = []
        self.fill: Callable[[Any], object] = parameters.fill
        self.kept = kept if isinstance(kept, ndarray) else parameters.values
        if isinstance(kept, Kept):
            self.kept = struct_of(kept.size)
            self.fill = _maker(parameters, kept.make, address(self.kept))
        self.block = [address(self.kept)] if signature.takes_parameters or kept is not None else []
        arguments: list[Any] = [*self.block]
        for item in signature.inputs:
            buffer, argument = _buffer(item, real)
            self.slots.append(_short(item.shape, buffer))
            arguments.append(argument)
        outputs = [np.zeros(item.shape, real) for item in signature.outputs]
        self.arguments = (*arguments, *map(address, outputs))
        self.result = _reader(outputs)

    def take(self, inputs: list[Rows]) -> None:
        """Copy checked inputs of a single state into the buffers."""
        for (_, buffer, _), item in zip(self.slots, inputs, strict=True):
            buffer[...] = item.values


def _maker(parameters: ParameterBlock, make: Callable[..., None], struct: ctypes.c_void_p) -> Callable[[Any], object]:
    """What takes parameters and, where they are not those of the last call, has C make the struct of them."""
    given = address(parameters.values)

    def fill(p: Any) -> None:
        if parameters.fill(p):
            make(given, struct)

    return fill


def _buffer(item: Argument, real: np.dtype[Any]) -> tuple[NDArray[Any], Any]:
    """Memory for one input and the C argument that stands for it: its address, or a scalar's value itself."""
    if item.shape:
        buffer = np.zeros(item.shape, real)
        return buffer, address(buffer)
    scalar = SCALAR[real.name]()
    return np.ctypeslib.as_array(scalar), scalar


def _checked(signature: Signature, values: tuple[Any, ...], real: np.dtype[Any]) -> list[Rows]:
    arguments = zip(signature.inputs, values, strict=True)
    return [rows_of(signature.name, argument, value, real) for argument, value in arguments]


def _reader(outputs: list[NDArray[Any]]) -> Callable[[], Arrays]:
    """A function that returns copies of the outputs; scalars come as NumPy scalars."""
    if len(outputs) > 1:
        return lambda: tuple(output.copy() if output.shape else output[()] for output in outputs)
    output = outputs[0]
    return output.copy if output.shape else lambda: output[()]


def _refuse_count(signature: Signature, values: tuple[Any, ...]) -> NoReturn:
    names = ", ".join(argument.name for argument in signature.inputs)
    problem = f"takes {len(signature.inputs)} arrays ({names}) and was given {len(values)}"
    remedy = f"call {signature}" + (", p= by keyword" if signature.takes_parameters else "")
    raise ArrayError(signature.name, len(values), problem, remedy)


def _described(
    call: Callable[..., Arrays], signature: Signature, real: np.dtype[Any]
) -> Callable[..., Arrays]:
    kinds = inspect.Parameter
    parameters = [kinds(argument.name, kinds.POSITIONAL_ONLY) for argument in signature.inputs]
    keyword = [kinds("p", kinds.KEYWORD_ONLY, default=None)]
    lines = [
        f"{signature}, compiled from {signature.symbol}.",
        "",
        f"Takes {', '.join(map(str, signature.inputs))}.",
        f"Returns {', '.join(map(str, signature.outputs))}, all {real}.",
        "Each input may carry one leading batch axis; those without one are shared by all rows.",
    ]
    if signature.takes_parameters:
        lines.append(f"Runtime parameters p: {', '.join(map(str, signature.parameters))}.")
    call.__name__ = call.__qualname__ = signature.name
    call.__doc__ = "\n".join(lines)
    call.__signature__ = inspect.Signature(parameters + keyword)  # type: ignore[attr-defined]
    return call
