"""Frozen records that hold arrays: nobody can write to them, nor to what they hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, DTypeLike


def frozen(value: Any) -> Any:
    """Nested tables that nobody can write to: mappings as proxies, lists as tuples, arrays as copies; all else as it is."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        return MappingProxyType({key: frozen(entry) for key, entry in value.items()})
    if isinstance(value, np.ndarray):
        return held(value, value.dtype)
    return tuple(frozen(entry) for entry in value) if isinstance(value, list | tuple) else value


def thawed(value: Any) -> Any:
    """The same as plain dictionaries, which can be pickled."""
    return {key: thawed(entry) for key, entry in value.items()} if isinstance(value, Mapping) else value


_WRITEABLE: Final = (np.ndarray, dict)


class Held:
    """Base of frozen records that hold arrays: like the record itself, nobody can write to what it holds."""

    def __post_init__(self) -> None:
        """Put views that cannot be written to in the place of arrays and dictionaries."""
        fields = vars(self)
        for name, value in fields.items():
            if not isinstance(value, _WRITEABLE):
                continue
            if isinstance(value, dict):
                fields[name] = MappingProxyType(value)
            elif value.flags.writeable:
                view = value.view()
                view.setflags(write=False)
                fields[name] = view

    @classmethod
    def made(cls, **fields: Any) -> Self:
        """The record of all its fields, whose arrays are its own already: a fifth of the time where a call takes microseconds."""
        record = cls.__new__(cls)
        object.__setattr__(record, "__dict__", fields)
        return record

    def __getstate__(self) -> dict[str, Any]:
        """The fields, such as can be pickled and copied."""
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in vars(self).items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take the fields back; an array that was pickled has forgotten that nobody may write to it."""
        vars(self).update(state)
        Held.__post_init__(self)


@dataclass(frozen=True, eq=False, repr=False)
class Valued(Held):
    """Base of frozen records of a chain some of whose parameters got their values at run time.

    Attributes:
        p: These values by name, `system.values(p)`; empty where the scene holds all numbers. They belong to what its digest is of.
    """

    p: Mapping[str, Any] = field(default_factory=dict, kw_only=True, hash=False)

    def __post_init__(self) -> None:
        """Have values that nobody can write to."""
        object.__setattr__(self, "p", frozen(self.p))
        super().__post_init__()

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "p": thawed(self.p)}


class Rest(Protocol):
    """What computes the fields of a record that wait to be read."""

    @property
    def computed(self) -> Mapping[str, str]:
        """By the name of each field: the method that computes it, with all others that come of the same work."""


class Later(Held):
    """Base of frozen records some of whose fields are computed when one of them is first read.

    Whoever copies, replaces or pickles such a record reads all of its fields, and so has them computed.
    """

    @classmethod
    def awaiting(cls, rest: Rest, fields: dict[str, Any]) -> Self:
        """The record of the fields that are known, whose arrays are its own already, and of what computes all others."""
        return cls.made(**fields, **{_REST: rest})

    def __getattr__(self, name: str) -> Any:
        """A field that was not read before: it and what is computed with it.

        Raises:
            AttributeError: There is no such field.
        """
        rest = vars(self).get(_REST)
        method = None if rest is None else rest.computed.get(name)
        if method is None:
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")
        found: dict[str, Any] = getattr(rest, method)()
        for value in found.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        vars(self).update(found)
        return found[name]

    def __getstate__(self) -> dict[str, Any]:
        """All fields, such as can be pickled and copied."""
        self.settle()
        return {name: value for name, value in super().__getstate__().items() if name != _REST}

    def settle(self) -> Self:
        """Have all fields computed now."""
        rest = vars(self).get(_REST)
        for name in () if rest is None else rest.computed:
            getattr(self, name)
        return self


_REST: Final = "_rest"


def held(values: ArrayLike, dtype: DTypeLike = float) -> np.ndarray:
    """A copy of an array that nobody can write to: what frozen records keep."""
    array: np.ndarray = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array
