"""The rows of `contract.flows` as ctypes: structs, and how each argument of a flow is handed to C."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, Final

from phichain.contract.chain import Chain
from phichain.contract.flow import Field, Passed, Struct
from phichain.native.memory.arrays import REAL, SCALAR, address

_PLAIN: Final[dict[str, Any]] = {
    "int": ctypes.c_int, "unsigned long": ctypes.c_ulong, "size_t": ctypes.c_size_t,
}  # fmt: skip
RESULTS: Final[dict[str, Any]] = {**_PLAIN, "void": None}
"""ctypes of what flows return."""


def struct_type(struct: Struct, chain: Chain) -> type[ctypes.Structure]:
    """A struct as ctypes lays it out for a chain."""
    fields = [(field.name, _field_type(field, chain)) for field in struct.fields_of(chain)]
    return type(struct.name, (ctypes.Structure,), {"_fields_": fields})


def _field_type(field: Field, chain: Chain) -> Any:
    if field.is_pointer:
        return ctypes.c_void_p
    plain = _number(field.type, chain)
    return plain * field.extent(chain) if field.extent else plain


def _number(name: str, chain: Chain) -> Any:
    """The ctypes of a plain type, or of the scene's numbers."""
    return SCALAR[REAL[chain.real].name] if name == "real" else _PLAIN[name]


def handed(argument: Passed, chain: Chain) -> Callable[[Any], Any]:
    """What makes of a value the argument that C takes: a ctypes number, or the address of an array or a struct."""
    if argument.form == "value":
        return _number(argument.type, chain)
    return address if argument.type in ("real", "params", "prepared") else _struct_address


def _struct_address(struct: ctypes.Structure | None) -> Any:
    return None if struct is None else ctypes.byref(struct)
