"""The batch form of the forward dynamics as a Python callable around NAME_forward_dynamics_batch.

In Python the batch axis is first, in C it is last: arrays are transposed on the way.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.native.arrays import REAL, address, converted, flat_parameters
from phichain.native.signature import Argument, Signature

_NAME = "forward_dynamics_batch"


def make_forward_dynamics_batch(
    sizes: tuple[int, int, int], parameters: Sequence[Argument], function: Any, real: str = "double"
) -> Callable[..., NDArray[Any]]:
    """Wrap NAME_forward_dynamics_batch.

    Args:
        sizes: nq, nv and nu.
        parameters: The scene's runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
        real: ``"double"`` or ``"float"``.

    Returns:
        ``forward_dynamics_batch(q, v, [u,] *, p)``: shapes (n, nq), (n, nv), (n, nu) -> accelerations (n, nv); arrays in
        Fortran order are read in place.
    """
    nq, nv, nu = sizes
    kind = REAL[real]
    shapes = {"q": nq, "v": nv, **({"u": nu} if nu else {})}
    signature = Signature(_NAME, _NAME, (), (), tuple(parameters), bool(parameters))
    function.restype = None

    def forward_dynamics_batch(*values: ArrayLike, p: Mapping[str, Any] | None = None) -> NDArray[Any]:
        if len(values) != len(shapes):
            problem = f"takes {len(shapes)} arrays ({', '.join(shapes)}) and was given {len(values)}"
            raise ArrayError(_NAME, len(values), problem, "give a row per state in each")
        n = len(np.atleast_1d(np.asarray(values[0])))
        columns = [
            _columns(name, value, (n, size), kind)
            for (name, size), value in zip(shapes.items(), values, strict=True)
        ]
        before = flat_parameters(signature, p, kind)
        a = np.empty((nv, n), kind)
        function(*map(address, before), ctypes.c_size_t(n), *map(address, columns), address(a))
        return a.T

    return forward_dynamics_batch


def _columns(name: str, value: ArrayLike, shape: tuple[int, int], kind: np.dtype[Any]) -> NDArray[Any]:
    """The rows as component-major memory."""
    array = converted(f"{_NAME}.{name}", value, kind)
    if array.shape != shape:
        problem = f"has shape {array.shape} where {shape} is expected"
        raise ArrayError(f"{_NAME}.{name}", array.shape, problem, "give a row per state in each")
    return np.require(array.T, requirements=["C", "A"])
