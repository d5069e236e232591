"""A law as it was before a run: a copy of all that it may remember, which answers as if nothing had been asked yet.

A law that keeps the first answer of every sample interval gives one question one answer, always: no question asked of it alone tells
that from a function of time. Its copy does. A copy is made of everything or not at all: what half a copy shared with the law might be
written to by both. So laws are copied that consist of functions, closures, containers, arrays and plain objects; what holds anything
else (a file, a generator, another library's object) is left in peace.
"""

from __future__ import annotations

import dis
import io
import pickle
import random
import sys
from collections import Counter, OrderedDict, defaultdict, deque
from collections.abc import Iterator
from functools import cached_property, partial
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
    NoneType,
)
from typing import Any, Final

import numpy as np

from phichain.motion.inputs.piece import Control
from phichain.records import Held
from phichain.system import System

#: Bytes, objects and arrays of a law beyond which it is not copied.
MOST_BYTES, MOST_OBJECTS, MOST_ARRAYS = 2**22, 20_000, 64
_COPIED: Final = frozenset({partial, deque, OrderedDict, defaultdict, Counter, random.Random, BuiltinFunctionType, complex, range, slice})
_OWN: Final = ("__reduce_ex__", "__reduce__", "__getstate__", "__new__")
_UNASKED: Final = ("__init__", "__repr__")
"""Methods that a copy is not asked."""
_ABOUT: Final = ("__setstate__", "__getnewargs__", "__getnewargs_ex__", "__del__")


class _NotCopiedError(Exception):
    """A law holds what is not copied."""


class _Names:
    """The global names that functions of one module see."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.table = table


_SHARED: Final = (type, ModuleType, CodeType, np.ufunc, np.dtype, System, _Names)
_FIXED: Final = (*_SHARED, FunctionType, NoneType, bool, int, float, complex, str, bytes, np.generic)
"""What all objects of a class may read together: nobody writes to it, and asks of one of these whether it is another's."""
_UNWRAPPED: Final = {property: ("fget", "fset", "fdel"), staticmethod: ("__func__",), classmethod: ("__func__",), cached_property: ("func",)}


class Afresh:
    """A law as it is now, however often it is asked later."""

    def __init__(self, law: Control) -> None:
        """Copy it, where it can be."""
        self._shared: list[Any] = []
        self._text: bytes | None = None
        buffer = io.BytesIO()
        try:
            writer = _Writer(buffer, self._shared)
            writer.dump(law)
            writer.check()
        except Exception:  # noqa: BLE001 - whatever an object of the caller's says when it is copied
            return
        self._text = buffer.getvalue()

    def law(self) -> Control | None:
        """A copy of its own, not asked yet; None where there is none."""
        if self._text is None:
            return None
        try:
            found: Control = _Reader(io.BytesIO(self._text), self._shared).load()
        except Exception:  # noqa: BLE001 - whatever an object of the caller's says when it is made
            return None
        return found


class _Writer(pickle.Pickler):
    """Writes functions as what they are, shares what nobody writes to, and refuses what it does not know."""

    def __init__(self, buffer: io.BytesIO, shared: list[Any]) -> None:
        super().__init__(buffer, 5)
        self._shared, self._places = shared, dict[int, int]()
        self._arrays, self._names = dict[int, np.ndarray](), dict[int, _Names]()
        self._objects = self._bytes = 0

    def check(self) -> None:
        """Refuse arrays that share memory, as their copies would not."""
        arrays = list(self._arrays.values())
        for k, one in enumerate(arrays):
            for other in arrays[:k]:
                if (one.flags.writeable or other.flags.writeable) and np.may_share_memory(one, other):
                    raise _NotCopiedError

    def persistent_id(self, found: Any) -> int | None:
        """The place of what is shared; None for what is copied."""
        self._objects += 1
        if type(found) is np.ndarray and id(found) not in self._arrays:
            self._arrays[id(found)] = found
            self._bytes += found.nbytes
        elif type(found) in (bytes, str, bytearray):
            self._bytes += len(found)
        if self._objects > MOST_OBJECTS or self._bytes > MOST_BYTES or len(self._arrays) > MOST_ARRAYS:
            raise _NotCopiedError
        if not (isinstance(found, _SHARED) or _is_free(found) or (isinstance(found, FunctionType) and _is_of_library(found))):
            return None
        if id(found) not in self._places:
            self._places[id(found)] = len(self._shared)
            self._shared.append(found)
        return self._places[id(found)]

    def reducer_override(self, found: Any) -> Any:
        """How what is copied is written."""
        kind = type(found)
        if kind is FunctionType:
            names = self._names.setdefault(id(found.__globals__), _Names(found.__globals__))
            return _function, (found.__code__, names, found.__closure__), _state(found), None, None, _fill
        if kind is CellType:
            return CellType, ()
        if kind is MethodType:  # by its name it would be found in the object's own class, which may have another one
            if not (isinstance(found.__self__, _SHARED) or _is_plain(type(found.__self__))):
                raise _NotCopiedError
            return MethodType, (found.__func__, found.__self__)
        if kind in _COPIED or (kind is np.ndarray and not found.dtype.hasobject) or issubclass(kind, np.generic) or _is_plain(kind):
            return NotImplemented
        raise _NotCopiedError


class _Reader(pickle.Unpickler):
    """Makes copies, whose global names are their own."""

    def __init__(self, text: io.BytesIO, shared: list[Any]) -> None:
        super().__init__(text)
        self._shared, self._tables = shared, dict[int, dict[str, Any]]()

    def persistent_load(self, place: int) -> Any:
        """What is shared."""
        found = self._shared[place]
        return self._tables.setdefault(place, dict(found.table)) if isinstance(found, _Names) else found


def _function(code: CodeType, names: dict[str, Any], closure: tuple[CellType, ...] | None) -> FunctionType:
    return FunctionType(code, names, None, None, closure)


def _state(function: FunctionType) -> tuple[Any, ...]:
    """What a function goes on with: the cells that are filled, defaults, attributes, and the global names that it may read."""
    table = function.__globals__
    read = {name: table[name] for code in _codes(function.__code__) for name in code.co_names if name in table}
    return _filled(function), function.__defaults__, function.__kwdefaults__, function.__dict__, read


def _filled(function: FunctionType) -> list[tuple[CellType, Any]]:
    """The cells of a closure and what is in them."""
    filled = []
    for cell in function.__closure__ or ():
        try:
            filled.append((cell, cell.cell_contents))
        except ValueError:  # a name that is bound later
            continue
    return filled


def _fill(function: FunctionType, state: tuple[Any, ...]) -> None:
    filled, function.__defaults__, function.__kwdefaults__, attributes, read = state
    for cell, value in filled:
        cell.cell_contents = value
    function.__dict__.update(attributes)
    function.__globals__.update(read)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code, and that of those that are made in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _is_of_library(function: FunctionType) -> bool:
    """Whether it is found by its name in a module that is none of the caller's."""
    if function.__closure__ or "<" in function.__qualname__:
        return False
    return _is_library(function.__module__)


def _is_library(module: str | None) -> bool:
    root = module.partition(".")[0] if module else ""
    file = getattr(sys.modules.get(root), "__file__", None) or ""
    return root in sys.stdlib_module_names - {"__main__"} or root == "phichain" or "site-packages" in file or "dist-packages" in file


def _is_free(found: Any) -> bool:
    """Whether it is a function of C that belongs to no object."""
    return type(found) is BuiltinFunctionType and isinstance(found.__self__, NoneType | ModuleType)


def _is_plain(kind: type) -> bool:
    """Whether all that its objects remember are their attributes: no class of C, none that makes or copies them itself, none that keeps anything for all of them."""
    is_held = issubclass(kind, Held)
    allowed = ("__getstate__", "__setstate__") if is_held else ()
    if any(getattr(kind, name) is not getattr(object, name) for name in _OWN if name not in allowed) or any(hasattr(kind, name) for name in _ABOUT if name not in allowed):
        return False
    for base in kind.__mro__[:-1]:
        if not base.__flags__ & 1 << 9:  # Py_TPFLAGS_HEAPTYPE: made by a class statement
            return False
        for name, value in vars(base).items():
            parts = [getattr(value, part) for part in _UNWRAPPED.get(type(value), ())] or [value]
            if any(not _is_common(part) for part in parts) and not name.startswith(("__", "_abc_")):
                return False
            is_asked = name not in _UNASKED and not _is_library(base.__module__)
            if is_asked and any(_keeps_outside(part) for part in parts if isinstance(part, FunctionType)):
                return False
    return True


def _is_common(value: Any) -> bool:
    """Whether objects and their copies may read it together."""
    if type(value) is tuple:
        return all(map(_is_common, value))
    return isinstance(value, (*_FIXED, MemberDescriptorType)) or _is_free(value)


def _keeps_outside(method: FunctionType) -> bool:
    """Whether a method reads objects of its module or of what is around its class, or writes to its module."""
    if any(not _is_common(value) for _, value in _filled(method)):
        return True
    for code in _codes(method.__code__):
        for step in dis.get_instructions(code):
            if step.opname in ("LOAD_GLOBAL", "LOAD_NAME") and not _is_common(method.__globals__.get(step.argval)):
                return True
            if step.opname in ("STORE_GLOBAL", "DELETE_GLOBAL"):
                return True
    return False
