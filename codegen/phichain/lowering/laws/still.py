"""Readings that stay to the bit while the model says that their places move, within Programs: a sensor that is stuck."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from phichain.ir.builder import Builder, Expr
from phichain.ir.handles import ArrayRef
from phichain.laws import FORGOTTEN, STILL, TrajectoryLaw


def pulled(builder: Builder, law: TrajectoryLaw, measured: ArrayRef, expected: ArrayRef, z: Sequence[Expr]) -> tuple[list[Expr], Expr]:
    """What is kept of readings, (y, r', p') one behind the other, and what it adds to `off`.

    While a reading stays,

        r' = k r + z_v - z_v,expected,    p' = k p + z_q - z_q,expected + T r',    k = 1 - T / FORGOTTEN,

    and both are 0 where it changes. `off` gains the squares of tube p / (STILL q), so that it is beyond the tube where p is beyond STILL steps q.
    """
    assert law.observer is not None and law.observer.learning is not None
    nq, start, sample = law.measured, law.observer.estimated, Fraction(law.catch.sample)
    share = max(Fraction(0), 1 - sample / Fraction(FORGOTTEN))
    rates, places, strain = [], [], builder.lift(Fraction(0))
    for i in range(nq):
        name, last = law.catch.state_names[i], expected[start + i]
        stays = builder.let(f"{name}_stays", _equal(measured[i], last))
        rates.append(builder.let(f"{name}_dot_pull", stays * (share * expected[start + nq + i] + (z[nq + i] - expected[nq + i]))))
        places.append(builder.let(f"{name}_pull", stays * (share * expected[start + 2 * nq + i] + (z[i] - expected[i]) + sample * rates[i])))
        strained = places[i] * (Fraction(law.tube) / (STILL * Fraction(float(law.observer.learning.steps[i]))))
        strain = strain + strained * strained
    return [*(measured[i] for i in range(nq)), *rates, *places], strain


def _equal(a: Expr, b: Expr) -> Expr:
    """1 where a = b or one of them is not a number, 0 elsewhere."""
    none, one = (a.builder.lift(Fraction(k)) for k in (0, 1))
    return a.builder.apply("select", a, b, none, a.builder.apply("select", b, a, none, one))
