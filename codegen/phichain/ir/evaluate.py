"""The oracle: a Program evaluated with NumPy arrays (whole batches at once) or mpmath numbers (any number of digits)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import scipy.special
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Array, Program

_NUMPY: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative, "sqrt": np.sqrt,
    "sin": np.sin, "cos": np.cos, "tanh": np.tanh, **{f"besselj{n}": lambda x, n=n: scipy.special.jv(n, x) for n in range(5)},
    # A complex step moves along the branch that the real parts take.
    "select": lambda a, b, x, y: np.where(np.real(a) < np.real(b), x, y), "floor": lambda x: np.floor(np.real(x)),
}  # fmt: skip

_MPMATH: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b,
    "neg": lambda a: -a, "sqrt": mpmath.sqrt, "sin": mpmath.sin, "cos": mpmath.cos, "tanh": mpmath.tanh,
    **{f"besselj{n}": lambda x, n=n: mpmath.besselj(n, x) for n in range(5)},
    "select": lambda a, b, x, y: x if a < b else y, "floor": mpmath.floor,
}  # fmt: skip


def evaluate(program: Program, arguments: Mapping[str, ArrayLike]) -> dict[str, NDArray[Any]]:
    """Evaluate with NumPy; real, complex (complex step) and batched arguments alike.

    Args:
        program: the function.
        arguments: every parameter and input by name, shape ``(*batch, *shape)`` with one common batch shape.

    Returns:
        Every output by name, shape ``(*batch, *shape)``.

    Raises:
        ArrayError: an argument is missing or has another shape.
    """
    values: dict[str, list[Any]] = {}
    batch: tuple[int, ...] = ()
    for array in (*program.params, *program.inputs):
        given = _argument(array, arguments)
        batch = np.broadcast_shapes(batch, given.shape[: given.ndim - len(array.shape)])
        flat = given.reshape(*given.shape[: given.ndim - len(array.shape)], array.size)
        values[array.name] = list(np.moveaxis(flat, -1, 0))
    algebra = Algebra(float, lambda kind, args, label: _NUMPY[kind](*args))
    with np.errstate(all="ignore"):
        results = run(program, algebra, values)
    return {
        array.name: np.stack([np.broadcast_to(cell, batch) for cell in results[array.name]], -1).reshape(
            (*batch, *array.shape)
        )
        for array in program.outputs
    }


def evaluate_exactly(
    program: Program, arguments: Mapping[str, Sequence[Any]], digits: int = 50
) -> dict[str, list[Any]]:
    """Evaluate with mpmath at the given number of digits.

    Args:
        program: the function.
        arguments: flat values of every parameter and input array by name; floats are taken as they are.
        digits: decimal digits of the arithmetic.

    Returns:
        Flat mpmath values of every output array by name.
    """
    with mpmath.workdps(digits):
        values = {name: [mpmath.mpmathify(value) for value in given] for name, given in arguments.items()}
        return run(program, Algebra(_rational, lambda kind, args, label: _MPMATH[kind](*args)), values)


def _rational(value: Fraction) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


def _argument(array: Array, arguments: Mapping[str, ArrayLike]) -> NDArray[Any]:
    if array.name not in arguments:
        raise ArrayError(array.name, None, "is missing", f"give an array of shape {array.shape}")
    given = np.asarray(arguments[array.name])
    if given.shape[given.ndim - len(array.shape) :] != array.shape or given.ndim < len(array.shape):
        raise ArrayError(array.name, given.shape, "has another shape", f"end the shape with {array.shape}")
    return given
