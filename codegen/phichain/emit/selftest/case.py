"""One call of a function and what it must return."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from phichain.contract.functions import ROWS
from phichain.ir.nodes import Program


@dataclass(frozen=True)
class Case:
    """One call and what it must return.

    Attributes:
        function: the contract's name.
        params: values of the runtime parameters, by name.
        inputs: values of the inputs, by name.
        direction: for a Jacobian, the direction it is applied to, one part an argument.
        expected: values by output name; for a Jacobian under "slope".
    """

    function: str
    params: Mapping[str, list[float]]
    inputs: Mapping[str, list[float]]
    direction: Mapping[str, list[float]]
    expected: Mapping[str, list[float]]


def columns(program: Program, case: Case) -> dict[str, list[str]]:
    """Which arguments' directions meet the columns of each output of a Jacobian."""
    derivative = ROWS[program.name].derivative
    kept = int(derivative is not None and derivative.keeps)
    outputs, moved = [array.name for array in program.outputs[kept:]], list(case.direction)
    if len(outputs) == 1:
        return {outputs[0]: moved}
    return {output: [name] for output, name in zip(outputs, moved, strict=True)}
