"""One extreme case: a chain, where it starts, what is asked of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from phichain.errors import PhichainError
from phichain.scene import FUNCTIONS, Scene

#: Double and single round-off; what is attainable is the condition number times this.
ROUND_OFF = {"double": 2.0**-53, "float": 2.0**-24}

_STEPS = ("step_lie4", "step_variational")
_NEEDED = ("forward_dynamics", "energy", "state_jacobian", "project")


@dataclass(frozen=True)
class Case:
    """A case of the stability table.

    Attributes:
        id: its name in the table and in references.json.
        title: what makes it hard.
        kind: "dynamics" (accelerations at one state), "motion" (states at times), "energy" (the energy's largest
            change over a long motion, over its height above the hanging rest), "period" (the frequency of one link
            released at rest).
        chain: keyword arguments of Scene.
        q, v, u: the state and the held force on a cart.
        times: when states are compared, s.
        means: how the reference is made: "extrapolation", "radau", "elliptic", "oracle", "engine", "given", "constant",
            "sweep" (a long chain in 80-bit arithmetic).
        side: up to this time the first angle must be in the reference's turn: on its side of the separatrix. None where
            there is none, or where no double could tell.
        slow: left out of a quick run.
    """

    id: str
    title: str
    kind: str
    chain: Mapping[str, Any] = field(repr=False)
    q: tuple[float, ...] = field(repr=False)
    v: tuple[float, ...] = field(repr=False)
    u: tuple[float, ...] = field(default=(), repr=False)
    times: tuple[float, ...] = ()
    means: str = "extrapolation"
    side: float | None = None
    slow: bool = False

    @property
    def real(self) -> str:
        """The type the chain computes in."""
        return str(self.chain.get("real", "double"))

    @property
    def round_off(self) -> float:
        """Unit round-off of that type."""
        return ROUND_OFF[self.real]

    def plain(self) -> Scene:
        """The chain with nothing but its forward dynamics wanted."""
        return Scene(self.id.lower(), **self.chain)

    def scene(self) -> Scene:
        """The chain with everything wanted that a method of this version may need."""
        wanted = (
            ["forward_dynamics"]
            if self.kind == "dynamics"
            else [name for name in integrators() if self._has(name)]
        )
        return Scene(self.id.lower(), **{**self.chain, "want": wanted})

    def _has(self, name: str) -> bool:
        try:
            Scene("probe", **{**self.chain, "want": [name]})
        except PhichainError:
            return False
        return True


def integrators() -> list[str]:
    """Functions of this version that serve simulation, whether every scene has them or not."""
    flows = [name for name in FUNCTIONS if name in ("step", *_STEPS) or name.startswith("propagate")]
    return [*(name for name in _NEEDED if name in FUNCTIONS), *flows]
