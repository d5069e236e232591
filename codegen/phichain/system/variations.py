"""Columns for a flow that carries derivatives: by every entry of the state, and by whole parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phichain.errors import UnsupportedError
from phichain.system.system import System

Along = dict[str, NDArray[np.float64]]


def variations(system: System, *names: str) -> tuple[NDArray[np.float64], Along]:
    """The columns that become the derivatives of where a motion ends by its start and by some parameters.

    Args:
        system: whose flow carries derivatives by them, `[flow] variational = ["state", "mass", ...]`.
        names: parameters, in the order of the columns behind those of the state; "amplitude" and "omega" of a forcing.

    Returns:
        `transition` (nx, nx + m) and `along`, for `propagate(..., transition=transition, along=along)`.

    Raises:
        UnsupportedError: The flow carries no derivatives by one of them.
    """
    varied: Mapping[str, int] = system.varied
    for name in names:
        if name not in varied:
            known = f"it varies {', '.join(varied)}" if varied else "it varies the state alone"
            raise UnsupportedError(
                "variations", name, f"is nothing that the flow of '{system.name}' carries derivatives by: {known}",
                f'name it in the scene, as [flow] variational = ["state", "{name}"]',
            )
    total, first = sum(varied[name] for name in names), system.nx
    transition = np.eye(system.nx, system.nx + total)
    along: Along = {}
    for name in names:
        size = varied[name]
        along[name] = np.eye(size, system.nx + total, first)
        first += size
    return transition, along
