"""How one family is followed, whatever its method: what all of them take besides the chain, where it begins and where it is to end."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.continuation import Branch, Engine
from phichain.continuation.core import Progress
from phichain.system import Parameters


@dataclass(frozen=True)
class Run:
    """What a run of any method takes.

    Attributes:
        engine: Predictor, corrector and options.
        p: Runtime parameters.
        amplitude_start: Largest angle, rad, by which the first point is off where the family begins.
        through: Half width of gaps that are crossed.
        earlier: A run to go on with.
        progress: Told every new point.
    """

    engine: Engine
    p: Parameters | None = None
    amplitude_start: float = 1e-2
    through: float = 0.0
    earlier: Branch | None = None
    progress: Progress | None = None
