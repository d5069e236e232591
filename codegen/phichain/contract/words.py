"""Words that a user may have meant: those that a slip of the fingers away is valid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

_LETTERS_A_SLIP: Final = 5
"""One slip is forgiven, and one more for so many letters."""


def nearest(name: str, valid: Iterable[str]) -> str | None:
    """Return the valid name that the fewest slips turn into `name`, of equally near ones the first; None where none is near.

    A slip is a letter too many, one missing, one for another, or two neighbours changed round.
    """
    most = 1 + len(name) // _LETTERS_A_SLIP
    near = [candidate for candidate in valid if abs(len(candidate) - len(name)) <= most]
    slips = [(_slips(name.lower(), candidate.lower()), place, candidate) for place, candidate in enumerate(near)]
    fewest, _, best = min(slips, default=(most + 1, 0, ""))
    return best if fewest <= most and fewest < len(name) else None


def known_names(name: str, valid: Sequence[str]) -> str:
    """A remedy for a name that is not known: the one that was meant, where one is near, and all there are."""
    best = nearest(name, valid)
    meant = f'did you mean "{best}"? ' if best else ""
    return f"{meant}There are {', '.join(valid)}" if best else f"name one of {', '.join(valid)}"


def _slips(a: str, b: str) -> int:
    """The number of slips between two words (the distance of Damerau and Levenshtein with neighbours changed once)."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, letter in enumerate(a, 1):
        above, row = (before, row), [i]
        for j, other in enumerate(b, 1):
            least = min(above[1][j] + 1, row[j - 1] + 1, above[1][j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                least = min(least, above[0][j - 2] + 1)
            row.append(least)
        before = above[1]
    return row[-1]
