"""Inputs by name: which entry of u a name is."""

from __future__ import annotations

from difflib import get_close_matches

from phichain.errors import ArrayError
from phichain.system import System


def position(system: System, field: str, name: object) -> int:
    """The entry of u that has a name.

    Raises:
        ArrayError: No input is called so.
    """
    if isinstance(name, str) and name in system.u_names:
        return system.u_names.index(name)
    near = get_close_matches(name, system.u_names, 1) if isinstance(name, str) else []
    meant = f"did you mean {near[0]}?" if near else f"use {', '.join(system.u_names) or 'no names, but one vector'}"
    raise ArrayError(field, name, f"is the name of no input of system '{system.name}'", meant)
