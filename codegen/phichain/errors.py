"""The errors of phichain: one base class, one child per kind of trouble, each carrying the offending values.

Every message is one sentence of the same shape, so that a reader finds the field, the value and the remedy
at the same place whatever went wrong::

    chain.com: puts the mass of link 2 beyond the link's length 0.25 (got 0.3); use 0 < com <= length

A caller that wants to react instead of print reads the attributes `field`, `value`, `problem` and `remedy`,
and whatever more the error carries from the mapping `data` (or as an attribute of the same name).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, Final

_LONGEST_VALUE: Final = 80
_FEW: Final = 4


class PhichainError(Exception):
    """Base of every error phichain raises on purpose.

    Args:
        field: What is wrong: a key as it is written (`chain.mass`), a file, an argument's name.
        value: The offending value, shown shortened.
        problem: What is wrong with it, without the value.
        remedy: What the reader can do about it.
        **data: Further values that a caller may want, e.g. `nearest="mass"`.
    """

    def __init__(self, field: str, value: object, problem: str, remedy: str, **data: object) -> None:
        super().__init__(printable(f"{field}: {problem} (got {shown(value)}); {remedy}"))
        self.field = field
        self.value = value
        self.problem = problem
        self.remedy = remedy
        self.data: Mapping[str, Any] = MappingProxyType(dict(data))

    def __getattr__(self, name: str) -> Any:
        """Read an entry of `data` as an attribute."""
        data: Mapping[str, Any] = self.__dict__.get("data", {})
        if name in data:
            return data[name]
        raise AttributeError(f"{type(self).__name__} carries no {name!r}; it carries {sorted(data)}")

    def __reduce__(self) -> tuple[Callable[..., PhichainError], tuple[object, ...]]:
        """Pickle through the constructor, so that errors cross process boundaries whole."""
        rebuild = partial(type(self), **self.data)
        return rebuild, (self.field, self.value, self.problem, self.remedy)


class SceneError(PhichainError):
    """A scene's key or value is not valid."""


class UnsupportedError(PhichainError):
    """A function was asked of a scene that has none; `remedy` names what to use instead."""


class DerivationError(PhichainError):
    """The mechanics of a scene could not be derived."""


class ContractError(PhichainError):
    """A function of the contract lacks its row, its writer or its reference; `missing` says which."""


class ProofError(PhichainError):
    """A function, or a Lagrangian, does not meet the mechanics; `data` holds `function`, `output`, `point` and `digest`."""


class EmissionError(PhichainError):
    """A program could not be written as source text."""


class CompilerError(PhichainError):
    """The C compiler is missing, failed or hung; `data` holds `command` and the first lines of `stderr`."""


class CacheError(PhichainError):
    """A cached artefact does not hold what its key promises."""


class OutputError(PhichainError):
    """A file or folder cannot be written or read."""


class ArrayError(PhichainError):
    """An array has the wrong shape, data type or layout."""


class ConvergenceError(PhichainError):
    """An iteration (Newton, continuation, integration) did not reach its goal."""


class ControlError(PhichainError):
    """A controller cannot be synthesised; `data` may hold the `mode` and its `margin`."""


class IdentificationError(PhichainError):
    """Measured data cannot tell parameters apart; `data` holds `names` and the `directions` in which they move together."""


class StudyError(PhichainError):
    """A study cannot be planned, run, stored or read."""


class SignalError(PhichainError):
    """A sampled signal is not uniform, too short, or holds values that are not finite."""


class ToleranceError(PhichainError):
    """A requested tolerance is not positive or lies below what the arithmetic can reach."""


def shown(value: object) -> str:
    """Return a value as an error message shows it: one line of at most 80 characters, arrays of more than a few numbers by shape and type."""
    if value is None:
        return "nothing"
    shape, dtype = getattr(value, "shape", None), getattr(value, "dtype", None)
    if isinstance(shape, tuple) and dtype is not None:
        if len(shape) > 1 or (shape and shape[0] > _FEW):
            return f"an array of shape {shape} and dtype {dtype}"
        # A number is shown as one, whatever kind of number it was given as.
        value = value.tolist() if hasattr(value, "tolist") else value
    text = _repr(value)
    if len(text) <= _LONGEST_VALUE:
        return text
    return f"{text[: _LONGEST_VALUE - 24]} ... {text[-18:]}"


def printable(text: str) -> str:
    """Return a text with every character that would move the cursor or colour the terminal written as its escape.

    Keys and file names come from others: a line break or an escape sequence in one must not pass for a line of ours.
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def _repr(value: object) -> str:
    """Return `repr` on one line.

    Python refuses to print integers of more than 4300 digits and what nests too deeply, and a caller's object may fail at it.
    """
    try:
        return " ".join(repr(value).split())
    except ValueError:
        return "a number too long to print"
    except Exception:  # noqa: BLE001 - what a caller's own __repr__ raises is anyone's guess
        return f"{type(value).__name__}, which cannot be printed"
