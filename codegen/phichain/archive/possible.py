"""Numbers that a record can hold: what every record read back from a file is held against, whatever the file's kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn, TypeVar

import numpy as np

from phichain.errors import OutputError

Record = TypeVar("Record")
_WRONG: Final[dict[str, tuple[str, Callable[[np.ndarray], np.ndarray]]]] = {
    "finite": ("is no finite number", lambda values: ~np.isfinite(values)),
    "positive": ("is not finite and above zero", lambda values: ~(np.isfinite(values) & (values > 0))),
    "not negative": ("is not finite and from zero", lambda values: ~(np.isfinite(values) & (values >= 0))),
}


class Part(NamedTuple):
    """Numbers of a record and where they stand in it, NAME[K] and what comes behind; None where it has none."""

    name: str
    values: Any
    behind: str = ""


@dataclass(frozen=True)
class Possible:
    """What the numbers of one kind of record must be; the parts are named where a rule does not hold.

    Attributes:
        finite: Attributes whose numbers are finite.
        positive: Those whose numbers are above zero.
        not_negative: Those whose numbers are from zero.
        rising: Those whose numbers rise from one to the next.
        more: A record -> further parts by what they must be, "finite", "positive" or "not negative".
    """

    finite: tuple[str, ...] = ()
    positive: tuple[str, ...] = ()
    not_negative: tuple[str, ...] = ()
    rising: tuple[str, ...] = ()
    more: Callable[[Any], Iterable[tuple[str, Part]]] = lambda record: ()

    def demand(self, path: Path | str, record: Record, within: str = "") -> Record:
        """The record, if it can be one.

        Args:
            path: The file.
            record: What was read there.
            within: Where it stands in a larger record, put before the names of its fields.

        Raises:
            OutputError: A number is none that it can hold; field, value and file are named.
        """
        kind = type(record).__name__
        for rule, names in (("finite", self.finite), ("positive", self.positive), ("not negative", self.not_negative)):
            for name in names:
                _demand(path, kind, rule, Part(within + name, getattr(record, name)))
        for rule, part in self.more(record):
            _demand(path, kind, rule, part._replace(name=within + part.name))
        for name in self.rising:
            steps = np.diff(np.asarray(getattr(record, name)))
            if not np.all(steps > 0):
                k = int(np.argmin(steps > 0)) + 1
                impossible(path, kind, f"{within}{name}[{k}]", float(getattr(record, name)[k]), "is not above what stands before it")
        return record


def _demand(path: Path | str, kind: str, rule: str, part: Part) -> None:
    problem, wrong = _WRONG[rule]
    values = np.asarray(() if part.values is None else part.values)
    found = np.argwhere(wrong(values))
    if len(found):
        at: Sequence[int] = tuple(map(int, found[0]))
        impossible(path, kind, part.name + "".join(f"[{k}]" for k in at) + part.behind, values[tuple(at)].item(), problem)


def impossible(path: Path | str, kind: str, field: str, value: object, problem: str) -> NoReturn:
    """Say which field of which file holds what its record cannot.

    Raises:
        OutputError: Always.
    """
    where = str(path)
    raise OutputError(field, value, f"{problem}, in the {kind} of the file {where}", f"name a file as {'an' if kind[0] in 'AEIO' else 'a'} {kind} wrote it, or write it again", path=where)
