"""Python callables of emitted functions: shape-checked, whole trajectories at once, other threads running.

A single state, given as arrays of the right type, takes a short path: its values are copied into preallocated
buffers whose addresses C already knows. Lists and other types are converted first, and a batch goes through
the function's row loop in one foreign call.

A buffer set serves one call at a time and goes back to its pool afterwards, so threads never share one.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn

import numpy as np
from numpy import ndarray
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.native.arrays import SCALAR, Rows, address, demand_range, parameter_values, row_count, rows_of
from phichain.native.signature import Argument, Signature

Arrays = Any
"""One array, or a tuple of arrays for functions with several outputs."""

_Slot = tuple[tuple[int, ...], NDArray[Any]]
"""A buffer that C reads and the shape it takes."""


def make_callable(
    signature: Signature, function: Callable[..., None], row_loop: Callable[..., None], real: np.dtype[Any]
) -> Callable[..., Arrays]:
    """Wrap an emitted function as a Python function of its inputs and the keyword ``p``.

    Args:
        signature: What the function takes and returns.
        function: The foreign function ``NAME_f``.
        row_loop: The foreign function ``NAME_rows_f``.
        real: The type that C computes in.

    Returns:
        A callable that raises `ArrayError` for arrays of the wrong number, shape or type.
    """
    count, names = len(signature.inputs), [parameter.name for parameter in signature.parameters]
    takes_parameters = signature.takes_parameters
    idle: list[_Frame] = []

    def call(*values: Any, p: Mapping[str, Any] | None = None) -> Arrays:
        if len(values) != count:
            _refuse_count(signature, values)
        try:
            frame = idle.pop()
        except IndexError:
            frame = _Frame(signature, real)
        if not _copied(values, frame.slots, real):
            inputs = _checked(signature, values, real)
            rows = row_count(signature, inputs)
            if rows is not None:
                idle.append(frame)
                return _batch(signature, row_loop, real, rows, inputs, p)
            frame.take(inputs)
        if takes_parameters or p is not None:
            if not _known(p, names, frame.fields, real):
                _fill(frame.parameters, signature, p, real)
            frame.demand_ranges(signature)
        function(*frame.arguments)
        result = frame.result()
        idle.append(frame)
        return result

    return _described(call, signature, real)


def _copied(values: Iterable[Any], slots: Iterable[_Slot], real: np.dtype[Any]) -> bool:
    """Copy arrays of the right type and shape, and Python numbers for scalars; False at anything else."""
    # Callers counted the values; checking again would take a tenth of the whole call.
    for value, (shape, buffer) in zip(values, slots):  # noqa: B905
        plain = type(value) is ndarray and value.dtype is real and value.shape == shape
        if not plain and (shape or not isinstance(value, float)):
            return False
        buffer[...] = value
    return True


def _known(p: Any, names: list[str], fields: Iterable[_Slot], real: np.dtype[Any]) -> bool:
    """Copy runtime parameters that need no conversion; False at anything else."""
    whole = type(p) is dict and len(p) == len(names) and all(map(p.__contains__, names))
    return whole and _copied(map(p.__getitem__, names), fields, real)


class _Frame:
    """Preallocated buffers of one call, and the arguments C takes for them."""

    __slots__ = ("arguments", "block", "checked", "fields", "parameters", "result", "slots")

    def __init__(self, signature: Signature, real: np.dtype[Any]) -> None:
        block, self.parameters = _parameter_block(signature, real)
        self.block, self.checked = block, b""
        self.fields: list[_Slot] = [(field.shape, field) for field in self.parameters]
        self.slots: list[_Slot] = []
        arguments: list[Any] = [address(block)] if signature.takes_parameters else []
        for item in signature.inputs:
            buffer, argument = _buffer(item, real)
            self.slots.append((item.shape, buffer))
            arguments.append(argument)
        outputs = [np.zeros(item.shape, real) for item in signature.outputs]
        self.arguments = (*arguments, *map(address, outputs))
        self.result = _reader(outputs)

    def demand_ranges(self, signature: Signature) -> None:
        """Check runtime parameters that are others than last time; comparing costs a tenth of checking."""
        given = self.block.tobytes()
        if given != self.checked:
            for parameter, values in zip(signature.parameters, self.parameters, strict=True):
                demand_range(f"{signature.name}.p[{parameter.name!r}]", parameter.name, values)
            self.checked = given

    def take(self, inputs: list[Rows]) -> None:
        """Copy checked inputs of a single state into the buffers."""
        for (_, buffer), item in zip(self.slots, inputs, strict=True):
            buffer[...] = item.values


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


def _batch(
    signature: Signature,
    row_loop: Callable[..., None],
    real: np.dtype[Any],
    rows: int,
    inputs: list[Rows],
    p: Mapping[str, Any] | None,
) -> Arrays:
    """All rows in one foreign call."""
    block, parameters = _parameter_block(signature, real)
    if signature.takes_parameters or p is not None:
        _fill(parameters, signature, p, real)
    outputs = [np.empty((rows, *item.shape), real) for item in signature.outputs]
    row_loop(*_row_arguments(signature, rows, block, inputs, outputs))
    return tuple(outputs) if len(outputs) > 1 else outputs[0]


def _row_arguments(
    signature: Signature, rows: int, block: NDArray[Any], inputs: list[Rows], outputs: list[NDArray[Any]]
) -> tuple[Any, ...]:
    """The row loop's arguments in C order."""
    arguments: list[Any] = [ctypes.c_size_t(rows)]
    if signature.takes_parameters:
        arguments.append(address(block))
    for item in inputs:
        arguments += [address(item.values), ctypes.c_size_t(item.stride)]
    return (*arguments, *map(address, outputs))


def _parameter_block(
    signature: Signature, real: np.dtype[Any]
) -> tuple[NDArray[Any], tuple[NDArray[Any], ...]]:
    """The C struct as one flat array, and a view of each field; `rows_source` proves the layout in C."""
    sizes = [parameter.size for parameter in signature.parameters]
    block, ends = np.zeros(sum(sizes), real), np.cumsum(sizes)
    fields = zip(signature.parameters, ends - sizes, ends, strict=True)
    return block, tuple(block[start:end].reshape(item.shape) for item, start, end in fields)


def _fill(
    fields: tuple[NDArray[Any], ...], signature: Signature, p: Mapping[str, Any] | None, real: np.dtype[Any]
) -> None:
    for field, value in zip(fields, parameter_values(signature, p, real), strict=True):
        field[...] = value


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
