"""The comment above a C function: what it computes, as its header says, and the named quantities that its body uses."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import groupby
from textwrap import wrap

from phichain.contract.quantities import DERIVATIVE, quantities_of
from phichain.contract.quantity import Quantities, Quantity
from phichain.emit.c.layout import WIDTH
from phichain.emit.c.names import SIDE_BY_SIDE
from phichain.emit.c.parts import words
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.units import Units, units_of_links
from phichain.lowering.dynamics import by_tensions, planar_units
from phichain.scene import Scene

#: What stands behind a quantity's name: links, repetitions, the loop it is computed in, arrays that keep it for later.
_BEHIND = re.compile(r"(_(\d+|[ijk]|lane|at|end))+$")
#: Runtime parameters have their meaning in the header.
_PARAMETER = re.compile(r"\bp->\w+")
#: Letters of names beyond which they stand above their meaning instead of beside it.
_LONGEST_NAMES = 48
#: Units of SI for those of mass and length.
_SI = (("M L^2/s^2", "N m"), ("M L/s^2", "N"), ("M", "kg"), ("L", "m"))


@dataclass(eq=False)
class Comments:
    """The comments of one file, which explain every quantity once, above the first function that uses it.

    Attributes:
        scene: whose file it is.
        explained: the function above which a quantity was explained; filled comment by comment.
    """

    scene: Scene
    explained: dict[Quantity, str] = field(default_factory=dict)

    def above(self, function: str, doc: str, lines: Iterable[str]) -> tuple[str, ...]:
        """The comment above a definition, as lines of C.

        Args:
            function: its name in the contract.
            doc: what it computes, in one line.
            lines: its body.
        """
        used = _used(self.scene, function, lines)
        known = list(dict.fromkeys(self.explained[row] for _, row in used if row in self.explained))
        new = [(group, row) for group, row in used if row not in self.explained]
        self.explained.update({row: function for _, row in new})
        text = [line for source, rows in groupby(new, lambda pair: pair[0].source) for line in self._block(source, rows)]
        if known:
            text.append(f"{'Others' if text else 'Quantities'} are named as in {', '.join(known)}.")
        if text and function == "forward_dynamics" and (second := _second(self.scene)) != 1:
            text.append(f"What is made of rates has {second.numerator}/{second.denominator} s for s, which keeps it in range.")
        return (f"/* {doc}", " *", *(f" * {line}" for line in text), " */") if text else (f"/* {doc} */",)

    def _block(self, source: str, rows: Iterable[tuple[Quantities, Quantity]]) -> list[str]:
        """The quantities of one section of docs/theory.md."""
        explained = [row for _, row in rows]
        scaled = _has_own_units(self.scene) and any(set(row.unit) & {"M", "L"} for row in explained)
        where = f" (docs/theory.md, {source})" if source else ""
        units = ", with M and L the mass and length of a link" if scaled else ""
        merged = [
            (", ".join(row.name for row in alike), unit if scaled else _in_si(unit), meaning)
            for (unit, meaning), alike in groupby(explained, lambda row: (row.unit, row.meaning))
        ]
        return [f"Quantities{where}{units}:", *_aligned(merged)]


def _used(scene: Scene, function: str, lines: Iterable[str]) -> list[tuple[Quantities, Quantity]]:
    """The rows of the table that a function's body names, those of one section together."""
    body = _PARAMETER.sub("", "\n".join(lines))
    stems = {_BEHIND.sub("", word) for long in words(body) for word in long.split("_then_")}
    stems |= {part for word in stems & {SIDE_BY_SIDE} for part in word.split("_")}
    rows = quantities_of(function, scene)
    names = {row.name for _, row in rows}
    found = [(group, row) for group, row in rows if row.name in stems]
    if any(stem.startswith("d_") and stem.removeprefix("d_") in names for stem in stems):
        found.append((found[-1][0] if found else rows[0][0], DERIVATIVE))
    order = list(dict.fromkeys(group.source for group, _ in found))
    return sorted(found, key=lambda pair: order.index(pair[0].source))


def _aligned(rows: Sequence[tuple[str, str, str]]) -> list[str]:
    """Names, units and meanings below each other."""
    unit_width = max(len(unit) for _, unit, _ in rows)
    name_width = max((len(name) for name, _, _ in rows if len(name) <= _LONGEST_NAMES), default=0)
    lines: list[str] = []
    for names, unit, meaning in rows:
        name = names
        if len(names) > name_width:  # so many names that they have lines of their own
            lines += wrap(names, WIDTH - 3, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)
            name = ""
        head = f"  {name:{name_width}}  {f'{unit:{unit_width}}  ' if unit_width else ''}"
        lines += wrap(
            meaning, WIDTH - 3, initial_indent=head, subsequent_indent=" " * len(head), break_on_hyphens=False
        )
    return lines


def _in_si(unit: str) -> str:
    """A unit in kg and m, forces and moments in N and N m."""
    for own, si in _SI:
        unit = re.sub(rf"(?<![A-Za-z]){re.escape(own)}(?![A-Za-z])", si, unit)
    return unit


def _second(scene: Scene) -> Fraction:
    """The unit of time of the dynamics, s."""
    return planar_units(point_masses(scene)).time if scene.is_planar else Fraction(1)


def _has_own_units(scene: Scene) -> bool:
    """Whether its dynamics measure masses and lengths in those of its links."""
    return by_tensions(scene) and units_of_links(scene) != Units()
