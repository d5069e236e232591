"""What the elimination of `lanes` knows of a link: powers of lambda = l / r, and what takes results into the next link's units."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cache

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Operand
from phichain.lowering.chain.link_units import LinkUnits


@dataclass(frozen=True)
class Numbers:
    """Those of one link, with (p, q) = (1, lambda - 1) on the tip's side and (lambda - 1, 1) on the base's.

    R, G and S take inertia, force and lambda into the next link's units.

    Attributes:
        leverage: lambda.
        overhang: lambda - 1 = p q.
        inner: p.
        inner_squared: p^2.
        outer: q.
        outer_squared: q^2.
        own: R lambda^2.
        mass: R.
        determinant: R^2 S q^2.
        force: G.
        minor_inner: R G S p.
        minor_outer: R G S q.
        lift: R S lambda.
    """

    leverage: Expr
    overhang: Expr
    inner: Expr
    inner_squared: Expr
    outer: Expr
    outer_squared: Expr
    own: Expr
    mass: Expr
    determinant: Expr
    force: Expr
    minor_inner: Expr
    minor_outer: Expr
    lift: Expr


def beyond(builder: Builder, units: LinkUnits, k: Index) -> Numbers:
    """Of link k on the tip's side, whose next link is k - 1."""
    mass = units.mass[k]
    pair = builder.lift(1), units.overhang[k]
    return _numbers(units, k, pair, (mass, mass * units.length[k], units.leverage_step[k]))


def before(builder: Builder, units: LinkUnits, k: Index) -> Numbers:
    """Of link k on the base's side, whose next link is k + 1; what stands for its inertia and force holds lambda^2 and lambda."""
    grown = units.leverage_step[k + 1]
    pair = units.overhang[k], builder.lift(1)
    mass, force = units.mass[k + 1] * grown * grown, grown * units.outward[k + 1]
    return _numbers(units, k, pair, (mass, force, units.leverage[k] * units.shortening[k + 1]))


def _numbers(units: LinkUnits, k: Index, pair: tuple[Expr, Expr], steps: tuple[Expr, Expr, Expr]) -> Numbers:
    (inner, outer), (mass, force, step) = pair, steps
    leverage, outer_squared, scaled = units.leverage[k], outer * outer, mass * step
    minor = force * scaled
    return Numbers(
        leverage=leverage, overhang=units.overhang[k], inner=inner, inner_squared=inner * inner, outer=outer, outer_squared=outer_squared,
        own=mass * (leverage * leverage), mass=mass, determinant=mass * scaled * outer_squared, force=force,
        minor_inner=minor * inner, minor_outer=minor * outer, lift=scaled * leverage,
    )  # fmt: skip


class Rows:
    """The numbers of both sides' links row by row, the tip's first: what all have in common vanishes from the code."""

    def __init__(self, builder: Builder, units: LinkUnits, rows: int) -> None:
        self._builder, self._units, self._rows = builder, units, rows
        self._tables = dict[str, ArrayRef]()
        with builder.first_of_all():
            self._write(self._folded())

    def __getitem__(self, cell: Index) -> Numbers:
        """Those of the link of a row and a side, cell 2 row + side."""
        return Numbers(**{name: table[cell] for name, table in self._tables.items()})

    def _of(self, row: Index) -> tuple[Numbers, Numbers]:
        """Of a row's link on the tip's side, and on the base's."""
        builder, units = self._builder, self._units
        return beyond(builder, units, 2 * self._rows - 1 - row), before(builder, units, row)

    def _folded(self) -> list[str]:
        """Make the tables that are numbers, one for all that are alike; returns the names of the others."""
        of, alike, others = cache(self._of), dict[tuple[object, ...], ArrayRef](), list[str]()
        for name in (field.name for field in fields(Numbers)):

            def entry(cell: Index, name: str = name) -> Expr:
                assert isinstance(cell, int)
                return getattr(of(cell // 2)[cell % 2], name)

            known = self._builder.known(2 * self._rows, entry)
            if known is None:
                others.append(name)
                continue
            if known not in alike:
                alike[known] = self._builder.constants(f"row_{name}", known)
            self._tables[name] = alike[known]
        return others

    def _write(self, names: list[str]) -> None:
        """Compute the tables that runtime parameters determine, one for all that are alike."""
        if not names:
            return
        alike = dict[tuple[Operand, Operand], ArrayRef]()
        with self._builder.loop("i", 0, self._rows) as loop:
            tip, base = self._of(loop.index)
            for name in names:
                pair: tuple[Expr, Expr] = getattr(tip, name), getattr(base, name)
                key = pair[0].operand, pair[1].operand
                if key not in alike:
                    alike[key] = table = self._builder.array(f"row_{name}", 2 * self._rows)
                    table[2 * loop.index], table[2 * loop.index + 1] = pair
                self._tables[name] = alike[key]
