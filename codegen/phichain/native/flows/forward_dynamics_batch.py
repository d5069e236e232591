"""The batch form of the forward dynamics as a Python callable around NAME_forward_dynamics_batch.

In Python the batch axis is first, in C it is last: arrays are transposed on the way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.errors import ArrayError
from phichain.native.flows.call import calls, flow_call
from phichain.native.memory.arrays import converted
from phichain.native.memory.room import demand_room
from phichain.native.signature import Argument
from phichain.system.threads import pieces, run

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
        ``forward_dynamics_batch(q, v, [u,] *, p, workers)``: shapes (n, nq), (n, nv), (n, nu) -> accelerations (n, nv); a small
        batch's arrays in Fortran order are read in place. `workers` threads ($PHICHAIN_WORKERS, or one per core, when None), whose
        number changes no bit of the result.
    """
    call, shapes = flow_call(_NAME, chain, parameters, function), {"q": chain.nq, "v": chain.nv}
    if chain.nu:
        shapes["u"] = chain.nu

    def forward_dynamics_batch(
        *values: ArrayLike, p: Mapping[str, Any] | None = None, workers: int | None = None
    ) -> NDArray[Any]:
        if len(values) != len(shapes):
            problem = f"takes {len(shapes)} arrays ({', '.join(shapes)}) and was given {len(values)}"
            raise ArrayError(_NAME, len(values), problem, "give a row per state in each")
        n = len(np.atleast_1d(converted(f"{_NAME}.q", values[0], call.kind)))
        rows = {
            name: _rows(name, value, (n, size), call.kind)
            for (name, size), value in zip(shapes.items(), values, strict=True)
        }
        demand_room(f"{_NAME}.q", n, sum(shapes.values()) + chain.nv, call.kind)
        a = np.empty((chain.nv, n), call.kind)

        def some(piece: slice) -> None:
            """Some of the states."""
            columns = {name: np.require(array[piece].T, requirements=["C", "A"]) for name, array in rows.items()}
            part = a if piece.stop - piece.start == n else np.empty((chain.nv, piece.stop - piece.start), call.kind)
            call({**columns, "n": piece.stop - piece.start, "a": part}, p)
            if part is not a:
                a[:, piece] = part

        run([partial(some, piece) for piece in pieces(n, _LEAST, workers)], workers)
        return a.T

    return forward_dynamics_batch


_LEAST: Final = 4096
"""States that are worth a thread; whole lanes of every kind of number."""


def _rows(name: str, value: ArrayLike, shape: tuple[int, int], kind: np.dtype[Any]) -> NDArray[Any]:
    """A row per state.

    Raises:
        ArrayError: It has another shape, or there is none.
    """
    array = converted(f"{_NAME}.{name}", value, kind)
    if array.shape != shape:
        problem = f"has shape {array.shape} where {shape} is expected"
        raise ArrayError(f"{_NAME}.{name}", array.shape, problem, "give a row per state in each")
    if not len(array):
        raise ArrayError(f"{_NAME}.{name}", array.shape, "has no row", "give at least one state")
    return array
