"""What the elimination of `lanes` knows of a link: powers of lambda = l / r, and what takes results into the next link's units."""

from __future__ import annotations

from collections.abc import Callable
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


@dataclass(frozen=True)
class _Own:
    """What the other numbers of a link are products of; `scaled` is R S."""

    leverage: Expr
    inner: Expr
    outer: Expr
    mass: Expr
    force: Expr
    scaled: Expr

    def numbers(self) -> Numbers:
        """All of them."""
        leverage, inner, outer, outer_squared = self.leverage, self.inner, self.outer, self.outer * self.outer
        mass, force, scaled, minor = self.mass, self.force, self.scaled, self.force * self.scaled
        return Numbers(
            leverage=leverage, overhang=inner * outer, inner=inner, inner_squared=inner * inner, outer=outer, outer_squared=outer_squared,
            own=mass * (leverage * leverage), mass=mass, determinant=mass * scaled * outer_squared, force=force,
            minor_inner=minor * inner, minor_outer=minor * outer, lift=scaled * leverage,
        )  # fmt: skip


def beyond(builder: Builder, units: LinkUnits, k: Index) -> Numbers:
    """Of link k on the tip's side, whose next link is k - 1."""
    return _beyond(builder, units, k).numbers()


def _beyond(builder: Builder, units: LinkUnits, k: Index) -> _Own:
    mass = units.mass[k]
    return _Own(units.leverage[k], builder.lift(1), units.overhang[k], mass, mass * units.length[k], mass * units.leverage_step[k])


def _before(builder: Builder, units: LinkUnits, k: Index) -> _Own:
    """Of link k on the base's side, whose next link is k + 1; what stands for its inertia and force holds lambda^2 and lambda."""
    grown, leverage = units.leverage_step[k + 1], units.leverage[k]
    mass, force = units.mass[k + 1] * grown * grown, grown * units.outward[k + 1]
    return _Own(leverage, units.overhang[k], builder.lift(1), mass, force, mass * (leverage * units.shortening[k + 1]))


class Rows:
    """The numbers of both sides' links row by row, the tip's first: what all have in common vanishes from the code.

    Of runtime parameters six tables are made of both sides' links, and cell by cell the others, which are products of these.
    """

    def __init__(self, builder: Builder, units: LinkUnits, rows: int) -> None:
        self._builder, self._units, self._rows = builder, units, rows
        self._alike = dict[tuple[object, ...], ArrayRef]()
        with builder.first_of_all():
            self._tables, unknown = self._folded(Numbers, lambda own: own.numbers())
            if unknown:
                own = self._written()
                self._tables |= {name: own[name] if name in own else self._product(name, own) for name in unknown}

    def __getitem__(self, cell: Index) -> Numbers:
        """Those of the link of a row and a side, cell 2 row + side."""
        return Numbers(**{name: table[cell] for name, table in self._tables.items()})

    def _of(self, row: Index) -> tuple[_Own, _Own]:
        """Of a row's link on the tip's side, and on the base's."""
        builder, units = self._builder, self._units
        return _beyond(builder, units, 2 * self._rows - 1 - row), _before(builder, units, row)

    def _folded(self, kind: type[Numbers | _Own], of_own: Callable[[_Own], Numbers | _Own]) -> tuple[dict[str, ArrayRef], list[str]]:
        """The tables that are numbers, one for all that are alike; and the names of the others."""
        of, tables, others = cache(lambda row: tuple(map(of_own, self._of(row)))), dict[str, ArrayRef](), list[str]()
        for name in (field.name for field in fields(kind)):

            def entry(cell: Index, name: str = name) -> Expr:
                assert isinstance(cell, int)
                value: Expr = getattr(of(cell // 2)[cell % 2], name)
                return value

            known = self._builder.known(2 * self._rows, entry)
            if known is None:
                others.append(name)
                continue
            if known not in self._alike:
                self._alike[known] = self._builder.constants(f"row_{name}", known)
            tables[name] = self._alike[known]
        return tables, others

    def _written(self) -> dict[str, ArrayRef]:
        """Those of `_Own`, one for all that are alike."""
        tables, names = self._folded(_Own, lambda own: own)
        alike = dict[tuple[Operand, Operand], ArrayRef]()
        with self._builder.loop("i", 0, self._rows) as loop:
            tip, base = self._of(loop.index)
            for name in names:
                pair: tuple[Expr, Expr] = getattr(tip, name), getattr(base, name)
                key = pair[0].operand, pair[1].operand
                if key not in alike:
                    alike[key] = table = self._builder.array(f"row_{name}", 2 * self._rows)
                    table[2 * loop.index], table[2 * loop.index + 1] = pair
                tables[name] = alike[key]
        return tables

    def _product(self, name: str, own: dict[str, ArrayRef]) -> ArrayRef:
        """A table of products of these."""
        table = self._builder.array(f"row_{name}", 2 * self._rows)
        with self._builder.loop("cell", 0, 2 * self._rows) as loop:
            table[loop.index] = getattr(_Own(**{part: cells[loop.index] for part, cells in own.items()}).numbers(), name)
        return table
