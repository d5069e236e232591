"""What the planar recurrences know of links: moments about their joints, of points on them or of rigid bodies (`lowering.chain.body`)."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.chain.parameters import Parameters


@dataclass(frozen=True)
class PlanarLinks:
    """Per-link numbers, each a table made on first use.

    Attributes:
        parameters: the numbers of the chain.
    """

    parameters: Parameters

    @property
    def mass(self) -> ArrayRef:
        """m, that of the point."""
        bodies = self.parameters.bodies
        return self.parameters.mass if bodies is None else bodies.point

    @property
    def moment(self) -> ArrayRef:
        """m r."""
        parameters, bodies = self.parameters, self.parameters.bodies
        if bodies is not None:
            return bodies.first
        return parameters.derived("moment", lambda k: parameters.mass[k] * parameters.com[k])

    @property
    def own(self) -> ArrayRef:
        """m r^2."""
        parameters, bodies = self.parameters, self.parameters.bodies
        if bodies is not None:
            return bodies.second
        return parameters.derived("own_inertia", lambda k: parameters.mass[k] * parameters.com[k] * parameters.com[k])

    @property
    def lever(self) -> ArrayRef:
        """m r (l - r)."""
        parameters, bodies = self.parameters, self.parameters.bodies
        if bodies is not None:
            return bodies.lever
        mass, length, com = parameters.mass, parameters.length, parameters.com
        return parameters.derived("lever", lambda k: mass[k] * com[k] * (length[k] - com[k]))

    @property
    def overhang(self) -> ArrayRef:
        """(l - r) / r."""
        parameters, bodies = self.parameters, self.parameters.bodies
        if bodies is not None:
            return parameters.derived("overhang", lambda k: bodies.lever[k] * bodies.over_second[k])
        length, com = parameters.length, parameters.com
        return parameters.derived("overhang", lambda k: (length[k] - com[k]) / com[k])

    def alone(self, k: Index) -> tuple[Expr, Expr, Expr]:
        """1 / (m r^2), m r and 1 / r of one link."""
        mass, com, bodies = self.parameters.mass[k], self.parameters.com[k], self.parameters.bodies
        if bodies is not None:
            return bodies.over_second[k], bodies.first[k], bodies.first[k] * bodies.over_second[k]
        return 1 / (mass * com * com), mass * com, 1 / com
