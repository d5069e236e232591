"""Taylor recurrences of two links, whose matrix is inverted as a whole: as many digits as by two sweeps, whatever the masses and lengths."""

from __future__ import annotations

import math
import random
from fractions import Fraction

import pytest
from mpmath import mp, mpf

from phichain.ir.nodes import Cell, Local, Op, Operand, Program, Store
from phichain.ir.passes import total_operations
from phichain.lowering.series import planar, planar_held
from phichain.lowering.series.run import Expanded, expand
from phichain.lowering.series.series import SUMS, Series
from phichain.lowering.series.two_links.factor import TwoFactor
from phichain.mechanics import Model, derive
from phichain.scene import Scene
from tests.lowering.taylor_oracle import DOUBLES, EXACT

ORDERS = 16
#: Masses, lengths and centres of both links.
CHAINS = {
    "alike": ((1.0, 1.0), (1.0, 1.0), (0.5, 0.5)),
    "light tip": ((1.0, 1e-15), (1.0, 1.0), (1.0, 1.0)),
    "heavy tip": ((1e-15, 1.0), (1.0, 1.0), (1.0, 1.0)),
    "short tip": ((1.0, 1.0), (1.0, 1e-8), (0.5, 5e-9)),
    "short carrier": ((1.0, 1.0), (1e-8, 1.0), (5e-9, 0.5)),
    "carrier held near its centre": ((1.0, 1.0), (1.0, 1.0), (1e-8, 1.0)),
    "all of it": ((1e12, 1.0), (1.0, 1e-4), (1e-6, 1e-4)),
}


def by_sweeps(model: Model, monkeypatch: pytest.MonkeyPatch) -> Series:
    """The recurrences as those of longer chains are."""
    for module in (planar, planar_held):
        monkeypatch.setattr(module, "inverts", lambda scene: False)
    return planar.planar_series(model)


def errors(made: Series, true: list[Expanded], starts: list[list[float]]) -> list[float]:
    """Of every start the largest error of a coefficient, over the largest of its order."""
    found = []
    for exact, (a, b, v, w) in zip(true, starts, strict=True):
        rows = expand(made, DOUBLES, ORDERS, [a, b], [v, w], [], Fraction(1, 64)).state
        sizes = [max(abs(x) for x in row[2:]) for row in exact.state]
        found.append(max(float(abs(x - y) / sizes[n]) for n in range(1, ORDERS) for x, y in zip(rows[n][2:], exact.state[n][2:], strict=True)))
    return sorted(found)


def both(name: str, monkeypatch: pytest.MonkeyPatch) -> tuple[list[float], list[float]]:
    mass, length, com = CHAINS[name]
    model = derive(Scene("two", 2, mass=list(mass), length=list(length), com=list(com)))
    made, source = planar.planar_series(model), random.Random(7)
    starts = [[source.uniform(-3, 3), scale * source.uniform(-3, 3), source.uniform(-2, 2), source.uniform(-2, 2)] for scale in (1, 1, 1, 1e-3, 1e-7, 0)]
    swept = by_sweeps(model, monkeypatch)
    with mp.workdps(60):
        true = [expand(swept, EXACT, ORDERS, [mpf(x) for x in start[:2]], [mpf(x) for x in start[2:]], [], Fraction(1, 64)) for start in starts]
    return errors(made, true, starts), errors(swept, true, starts)


@pytest.mark.parametrize("name", CHAINS)
def test_extreme_chains_keep_their_digits(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = both(name, monkeypatch)
    assert ours[-1] < 8 * theirs[-1] + 1e-13 and ours[len(ours) // 2] < 4 * theirs[len(theirs) // 2] + 1e-14, (ours, theirs)


def test_a_share_that_cancels_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would be lost if the row of a light carrier were formed by a difference."""
    whole = TwoFactor.keep

    def keep(self: TwoFactor, name: str, k: object, value: object) -> None:
        if name == "inverse" and k == 0:
            # 1 / D less what is common to all of it, and that again: the digits that a difference leaves.
            value = (value + 2.0**40) - 2.0**40  # type: ignore[operator]
        whole(self, name, k, value)  # type: ignore[arg-type]

    monkeypatch.setattr(TwoFactor, "keep", keep)
    ours, theirs = both("alike", monkeypatch)
    assert ours[-1] > 8 * theirs[-1] + 1e-13


def behind_the_newest(program: Program) -> int:
    """Operations that follow one another in a straight-line Program from the sums of moments along the links, which come last."""
    depths: dict[str, float] = {}

    def of(operand: Operand) -> float:
        if isinstance(operand, Local):
            return depths[operand.name]
        is_newest = isinstance(operand, Cell) and operand.array == SUMS and operand.index.at({}) >= 6
        return 0 if is_newest else -math.inf

    for statement in program.body:
        if isinstance(statement, Op):
            depths[statement.result] = 1 + max(map(of, statement.args))
    return int(max(of(statement.value) for statement in program.body if isinstance(statement, Store)))


def test_fewer_operations_wait_for_the_newest_moments(monkeypatch: pytest.MonkeyPatch) -> None:
    model = derive(Scene("counted", 2, mass=[0.5, 0.5], length=[0.5, 0.5], com=[0.25, 0.25]))
    made, swept = planar.planar_series(model).order, by_sweeps(model, monkeypatch).order
    found = [(behind_the_newest(one), total_operations(one)) for one in (made, swept)]
    assert found[0][0] <= found[1][0] - 6 and found[0][1] <= found[1][1] + 10, found
