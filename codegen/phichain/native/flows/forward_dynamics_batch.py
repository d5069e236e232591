"""The batch form of the forward dynamics as a Python callable around NAME_forward_dynamics_batch.

In Python the batch axis is first, in C it is last: arrays are transposed on the way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.errors import ArrayError
from phichain.native.memory.arrays import converted
from phichain.native.flows.call import calls, flow_call
from phichain.native.signature import Argument

_NAME = "forward_dynamics_batch"


@calls(_NAME)
def make_forward_dynamics_batch(
    chain: Chain, parameters: Sequence[Argument], function: Any
) -> Callable[..., NDArray[Any]]:
    """Wrap NAME_forward_dynamics_batch.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.

    Returns:
        ``forward_dynamics_batch(q, v, [u,] *, p)``: shapes (n, nq), (n, nv), (n, nu) -> accelerations (n, nv); arrays in
        Fortran order are read in place.
    """
    call, shapes = flow_call(_NAME, chain, parameters, function), {"q": chain.nq, "v": chain.nv}
    if chain.nu:
        shapes["u"] = chain.nu

    def forward_dynamics_batch(*values: ArrayLike, p: Mapping[str, Any] | None = None) -> NDArray[Any]:
        if len(values) != len(shapes):
            problem = f"takes {len(shapes)} arrays ({', '.join(shapes)}) and was given {len(values)}"
            raise ArrayError(_NAME, len(values), problem, "give a row per state in each")
        n = len(np.atleast_1d(converted(f"{_NAME}.q", values[0], call.kind)))
        columns = {
            name: _columns(name, value, (n, size), call.kind)
            for (name, size), value in zip(shapes.items(), values, strict=True)
        }
        a = np.empty((chain.nv, n), call.kind)
        call({**columns, "n": n, "a": a}, p)
        return a.T

    return forward_dynamics_batch


def _columns(name: str, value: ArrayLike, shape: tuple[int, int], kind: np.dtype[Any]) -> NDArray[Any]:
    """The rows as component-major memory."""
    array = converted(f"{_NAME}.{name}", value, kind)
    if array.shape != shape:
        problem = f"has shape {array.shape} where {shape} is expected"
        raise ArrayError(f"{_NAME}.{name}", array.shape, problem, "give a row per state in each")
    return np.require(array.T, requirements=["C", "A"])
