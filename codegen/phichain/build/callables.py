"""Python callables of emitted functions: shape-checked, whole trajectories at once, without the interpreter lock.

A single state, given as arrays of the right type, takes a short path: its values are copied into preallocated
buffers whose addresses C already knows. Everything else (lists, other types, batches) takes the general path. Both
end in the same row loop, the short one with a single row.

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

from phichain.build.arrays import parameter_values, row_count, rows_of
from phichain.build.signature import Signature
from phichain.errors import ArrayError

Arrays = Any
"""One array, or a tuple of arrays for functions with several outputs."""

_Slot = tuple[tuple[int, ...], NDArray[Any]]
"""A buffer that C reads and the shape it takes."""


def make_callable(signature: Signature, row_loop: Callable[..., None], real: np.dtype[Any]) -> Callable[..., Arrays]:
    """Wrap a row loop as a Python function of the signature's inputs and the keyword ``p``.

    Args:
        signature: What the function takes and returns.
        row_loop: The foreign function ``NAME_rows_f``.
        real: The type that C computes in.

    Returns:
        A callable that raises `ArrayError` for arrays of the wrong number, shape or type.
    """
    count, names = len(signature.inputs), [parameter.name for parameter in signature.parameters]
    idle: list[_Frame] = []

    def call(*values: Any, p: Mapping[str, Any] | None = None) -> Arrays:
        if len(values) != count:
            _refuse_count(signature, values)
        try:
            frame = idle.pop()
        except IndexError:
            frame = _Frame(signature, real)
        if not _copied(values, frame.slots, real):
            idle.append(frame)
            return _general(signature, row_loop, real, values, p)
        if p or signature.takes_parameters:
            known = type(p) is dict and len(p) == len(names) and all(map(p.__contains__, names))
            if not (known and _copied(map(p.__getitem__, names), frame.fields, real)):
                _fill(frame.parameters, signature, p, real)
        row_loop(*frame.pointers)
        result = frame.result()
        idle.append(frame)
        return result

    return _described(call, signature, real)


def _copied(values: Iterable[Any], slots: Iterable[_Slot], real: np.dtype[Any]) -> bool:
    """Copy arrays of exactly the right type and shape, and Python numbers for scalars; False at anything else."""
    for value, (shape, buffer) in zip(values, slots, strict=True):
        plain = type(value) is ndarray and value.dtype is real and value.shape == shape
        if not plain and (shape or type(value) is not float):
            return False
        buffer[...] = value
    return True


class _Frame:
    """Preallocated buffers of one call with a single row, and the arguments C takes for them."""

    __slots__ = ("fields", "parameters", "pointers", "result", "slots")

    def __init__(self, signature: Signature, real: np.dtype[Any]) -> None:
        inputs = [np.zeros(item.shape, real) for item in signature.inputs]
        outputs = [np.zeros(item.shape, real) for item in signature.outputs]
        block, self.parameters = _parameter_block(signature, real)
        self.slots: list[_Slot] = [(buffer.shape, buffer) for buffer in inputs]
        self.fields: list[_Slot] = [(field.shape, field) for field in self.parameters]
        self.pointers = _arguments(signature, 1, block, [(buffer, 0) for buffer in inputs], outputs)
        self.result = _reader(outputs)


def _general(
    signature: Signature,
    row_loop: Callable[..., None],
    real: np.dtype[Any],
    values: tuple[Any, ...],
    p: Mapping[str, Any] | None,
) -> Arrays:
    inputs = [
        rows_of(signature.name, argument, value, real)
        for argument, value in zip(signature.inputs, values, strict=True)
    ]
    rows = row_count(signature, inputs)
    block, parameters = _parameter_block(signature, real)
    if p or signature.takes_parameters:
        _fill(parameters, signature, p, real)
    outputs = [np.empty((1 if rows is None else rows, *item.shape), real) for item in signature.outputs]
    if rows != 0:
        laid_out = [(item.values, item.stride) for item in inputs]
        row_loop(*_arguments(signature, rows or 1, block, laid_out, outputs))
    results = tuple(output[0] if rows is None else output for output in outputs)
    return results if len(results) > 1 else results[0]


def _arguments(
    signature: Signature,
    rows: int,
    block: NDArray[Any],
    inputs: list[tuple[NDArray[Any], int]],
    outputs: list[NDArray[Any]],
) -> tuple[Any, ...]:
    """The row loop's arguments in C order, converted once."""
    arguments: list[Any] = [ctypes.c_size_t(rows)]
    if signature.takes_parameters:
        arguments.append(_pointer(block))
    for values, stride in inputs:
        arguments += [_pointer(values), ctypes.c_size_t(stride)]
    return (*arguments, *map(_pointer, outputs))


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _parameter_block(signature: Signature, real: np.dtype[Any]) -> tuple[NDArray[Any], tuple[NDArray[Any], ...]]:
    """The C struct as one flat array, and a view of each field; the row loop proves the layout when compiled."""
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


def _described(call: Callable[..., Arrays], signature: Signature, real: np.dtype[Any]) -> Callable[..., Arrays]:
    kinds = inspect.Parameter
    parameters = [kinds(argument.name, kinds.POSITIONAL_ONLY) for argument in signature.inputs]
    keyword = [kinds("p", kinds.KEYWORD_ONLY, default=None)]
    lines = [
        f"{signature}, compiled from {signature.symbol}.",
        "",
        f"Takes {', '.join(map(str, signature.inputs))}; returns {', '.join(map(str, signature.outputs))} ({real}).",
        "Each input may carry one leading batch axis; those without one are shared by all rows.",
    ]
    if signature.takes_parameters:
        lines.append(f"Runtime parameters p: {', '.join(map(str, signature.parameters))}.")
    call.__name__ = call.__qualname__ = signature.name
    call.__doc__ = "\n".join(lines)
    call.__signature__ = inspect.Signature(parameters + keyword)  # type: ignore[attr-defined]
    return call
