"""Which derivatives of a Program are wanted, and where they go."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Block:
    """One Jacobian d(output)/d(argument) and the name of the array that receives it, row-major.

    `column` and `columns` place several arguments side by side in one array: the block's first column, and the row length.
    """

    output: str
    argument: str
    name: str
    column: int = 0
    columns: int = 0
