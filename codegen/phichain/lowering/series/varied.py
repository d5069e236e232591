"""Derivatives of a motion by runtime parameters: the recurrences differentiated where parameters stand in them.

Along a direction (dx_0, dp) of the state at a step's start and of the parameters the coefficients move by

    d held = d factor / dp . dp,      d x_{n+1} = d order / d(held, sums, x_n, p) . (d held, d sums, dx_n, dp)

the state's own part of d held being in the rows, whose frames are those of the motion itself (`Series.columns`). Both are
derivatives along one direction, so what a column costs does not grow with the number of parameters.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from phichain.errors import DerivationError
from phichain.ir.nodes import Program
from phichain.lowering.series.series import COEFFICIENT, FORCE, HELD, LATER, LEFT, NEWEST, RIGHT, SUMS, Series
from phichain.scene import Scene
from phichain.transform.along import along
from phichain.transform.pattern import jacobian_pattern

FORCING: Final = ("amplitude", "omega")
"""What varies of a forcing, behind the parameters."""


def varied_parameters(scene: Scene) -> tuple[str, ...]:
    """The runtime parameters that derivatives are by."""
    return tuple(name for name in scene.varied if name not in FORCING)


def with_parameters(made: Series, scene: Scene) -> Series:
    """The recurrences with derivatives by what the scene varies.

    Raises:
        DerivationError: A row of order 0 depends on a parameter, which no recurrence of ours has.
    """
    names = varied_parameters(scene)
    _demand_free_rows(made.factor, names)
    in_factor = [name for name in names if _has(made.factor, name)]
    in_order = [name for name in names if _has(made.order, name)]
    force = [FORCE] if made.is_forced else []
    newest = [NEWEST] if _has(made.order, NEWEST) else []
    return replace(
        made,
        factor_along=along(
            made.factor, "flow_factor_along", "How the factored step moves with the parameters.", [*force, *in_factor],
            [*([LATER] if made.is_forced else []), HELD],
        ),
        order_along=along(
            made.order, "flow_order_along", "Derivatives of the coefficients of order n + 1.",
            [HELD, SUMS, *newest, COEFFICIENT, *force, *in_order], [LEFT, RIGHT, "next"],
        ),
    )  # fmt: skip


def _has(program: Program, name: str) -> bool:
    return any(array.name == name for array in (*program.params, *program.inputs))


def _demand_free_rows(factor: Program, names: tuple[str, ...]) -> None:
    pattern = jacobian_pattern(factor)
    for name in names:
        for row in (LEFT, RIGHT):
            if pattern.get((row, name)):
                raise DerivationError("flow.variational", name, f"moves {row} of order 0, which its columns do not know", "leave it out")
