"""The forward dynamics of a scene with runtime parameters in two parts: what these alone determine, and the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from phichain.ir.inline import inline
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations
from phichain.lowering.dynamics import form_of_prepared
from phichain.lowering.lower import lower_function
from phichain.mechanics import Model
from phichain.transform.prepared import Split, joined, prepared

VALUES: Final = "values"
"""The array between the parts."""


@dataclass(frozen=True)
class Preparation:
    """The two parts.

    Attributes:
        split: them, or None where the parameters determine nothing but themselves.
        whole: the one after the other, a function like the forward dynamics.
    """

    split: Split | None
    whole: Program

    @property
    def rest(self) -> Program:
        """What is done at every state."""
        return self.split.rest if self.split else self.whole

    @property
    def size(self) -> int:
        """Numbers that are kept from one state to the next, beside the parameters."""
        return self.split.size if self.split else 0

    @property
    def operations(self) -> tuple[int, int]:
        """Of the first part, and of the rest."""
        return total_operations(self.split.first) if self.split else 0, total_operations(self.rest)


def preparation(model: Model) -> Preparation:
    """Split a scene's forward dynamics, in the form that its `code` asks for."""
    whole = inline(lower_function(model, form_of_prepared(model.scene), model.scene.code, keeps_tables=True))
    whole = replace(whole, name="forward_dynamics")
    split = prepared(whole, VALUES)
    return Preparation(split, joined(split) if split else whole)
