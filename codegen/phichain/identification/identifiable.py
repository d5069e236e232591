"""What data can tell apart: the singular values of the columns, and the directions in which they say nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.errors import IdentificationError
from phichain.records import Held
from phichain.system import Vector

LEAST: Final = 1e-8
"""Singular value of columns of length one below which their combination is none that the data know."""
_SILENT: Final = 1e-7
"""Length of a column, relative to the longest, below which its unknown does nothing."""
_TAKES_PART: Final = 0.02
"""Share from which an unknown is named in a direction."""
_SHOWN: Final = 4


@dataclass(frozen=True, eq=False)
class Directions(Held):
    """Directions of the unknowns along which nothing measured changes.

    Attributes:
        singular: Singular values (k,) of the columns, each brought to length one, falling.
        blind: Changes of the unknowns (b, k), each in its scale, the largest entry 1; none where the data tell all apart.
        shares: How much of each unknown lies in these directions (k,), 0 to 1.
    """

    singular: Vector
    blind: Vector
    shares: Vector


def directions(columns: Vector, noise: float = 0.0, least: float = LEAST) -> Directions:
    """Find what the columns cannot tell apart.

    With D the lengths of the columns of J, J D^-1 = U S V^T; where s_i is below 10^-8 (or what differencing leaves), D^-1 V_i changes
    no prediction. A column that has no length is such a direction by itself.

    Args:
        columns: J (m, k), each row over its noise, each column in the scale of its unknown.
        noise: Relative error of the columns.
        least: Singular value, over the largest, below which a direction is blind.
    """
    lengths = np.linalg.norm(columns, axis=0)
    silent = lengths <= max(_SILENT, 10 * noise) * max(float(lengths.max()), np.finfo(float).tiny)
    kept = np.flatnonzero(~silent)
    k = len(lengths)
    blind, shares = [np.eye(k)[j] for j in np.flatnonzero(silent)], silent.astype(float)
    singular = np.zeros(k)
    if kept.size:
        _, values, rows = np.linalg.svd(columns[:, kept] / lengths[kept], full_matrices=False)
        singular[: kept.size] = values
        lost = values < max(least, 10 * noise) * values[0]
        shares[kept] = np.sum(rows[lost] ** 2, axis=0)
        for row in rows[lost]:
            change = np.zeros(k)
            change[kept] = row / lengths[kept]
            blind.append(change / change[np.argmax(np.abs(change))])
    return Directions(singular, np.array(blind).reshape(-1, k), shares)


def demand_told_apart(found: Directions, names: Sequence[str], count: int) -> None:
    """Refuse a fit of more than the data can tell.

    Args:
        found: What the columns say.
        names: Names of the unknowns, parameters first.
        count: How many of them are parameters.

    Raises:
        IdentificationError: Some direction is blind; it names the unknowns that move together, and by how much.
    """
    if not len(found.blind):
        return
    lost = [name for name, part in zip(names, np.sqrt(found.shares), strict=True) if part > _TAKES_PART]
    ways, heads = reduced(found.blind)
    told = [
        ", ".join(f"{name} {100 * change:+.3g} %" for name, change in zip(names, way, strict=True) if abs(change) > _TAKES_PART)
        for way in ways
    ]
    problem = "cannot be told apart by this data, which says nothing of a change by " + "; or by ".join(told[:_SHOWN])
    if len(lost) == 1:
        problem = "does not change what was measured"
    fixable = [names[head] for head in heads if head < count]
    further = "measure more (with known inputs, from another start, further columns)"
    remedy = f"fix {', '.join(fixable)} (--fix {' --fix '.join(fixable)}), or {further}" if fixable else further
    raise IdentificationError("parameters", ", ".join(lost), problem, remedy, names=tuple(lost), directions=tuple(told), fix=tuple(fixable))


def reduced(blind: Vector) -> tuple[Vector, tuple[int, ...]]:
    """The same directions with as few entries as can be: each begins with an unknown that no other one holds.

    Args:
        blind: Directions (b, k).

    Returns:
        Directions (b, k) in reduced echelon form, each with the entry 1 at its head, and the heads: with these unknowns fixed nothing is blind.
    """
    rows, heads = np.array(blind), list[int]()
    for column in range(rows.shape[1]):
        at = len(heads)
        if at == len(rows):
            break
        pivot = at + int(np.argmax(np.abs(rows[at:, column])))
        if abs(rows[pivot, column]) < _TAKES_PART * np.max(np.abs(rows[at:])):
            continue
        rows[[at, pivot]] = rows[[pivot, at]]
        rows[at] /= rows[at, column]
        for other in range(len(rows)):
            if other != at:
                rows[other] -= rows[other, column] * rows[at]
        heads.append(column)
    return rows[: len(heads)], tuple(heads)
