"""Tensions of a chain whose masses sit at the link ends (design 1.3): one symmetric tridiagonal system, free of cancellation.

The links are distance constraints. Link k (from 0) joins mass k-1 to mass k, mass -1 being the cart. With c_k = q_{k-1}.q_k,
s_k^2 = |q_{k-1} x q_k|^2 and s_0^2 = |C^T q_0|^2 the tensions lambda solve

    -(c_k / m_{k-1}) lambda_{k-1} + (1/m_{k-1} + 1/m_k) lambda_k - (c_{k+1} / m_k) lambda_{k+1} = b_k

(first row: s_0^2/m_{-1} + 1/m_0 on the diagonal). Eliminating from the base and from the tip towards the middle (a twisted
factorisation) halves the chain of dependent operations; writing pivots as 1/m_k + x_k, x_k > 0, from s_k^2 and never from
1 - c_k^2 keeps every term positive. Everything is scaled by the masses, so equal masses cost nothing. With
rho_k = m_k / m_{k-1}, the slacks t_k = m_k x_k (from the base) and Y_k = m_k y_k (from the tip) follow

    t_{k+1} = rho_{k+1} (s_{k+1}^2 + t_k) / (1 + t_k),    t_0 = rho_0 s_0^2
    Y_{k-1} = (s_k^2 + z_k) / (1 + z_k),  z_k = Y_k / rho_k,    Y_{N-1} = 1
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.program.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.program.parameters import Parameters


@dataclass(frozen=True)
class Joints:
    """What the tridiagonal system needs of the joints.

    Attributes:
        cosine: q_{k-1}.q_k for k >= 1.
        sine_squared: |q_{k-1} x q_k|^2 for k >= 1.
        base_slack: rho_0 s_0^2, zero on a fixed base.
        right_side: b_k.
    """

    cosine: ArrayRef
    sine_squared: ArrayRef
    base_slack: Expr
    right_side: ArrayRef


@dataclass(frozen=True)
class _Front:
    """An elimination front: its slack, and what the eliminated links add to the next right side."""

    slack: Expr
    incoming: Expr

    def carried(self, loop: Loop, side: str) -> _Front:
        """The same front as loop-carried scalars."""
        return _Front(loop.carry(f"{side}_slack", self.slack), loop.carry(f"{side}_incoming", self.incoming))

    def followed(self, loop: Loop, after: _Front) -> None:
        """Say what the front is on the next turn."""
        loop.follow(self.slack, after.slack)
        loop.follow(self.incoming, after.incoming)


def solve_tensions(builder: Builder, parameters: Parameters, joints: Joints) -> ArrayRef:
    """Scaled tensions lambda_k / m_k, N + 1 cells, the last one (beyond the tip) zero."""
    links = parameters.links
    middle = links // 2
    paired = links - 1 - middle
    sweep = _Sweep(builder, parameters, joints)
    base = _Front(joints.base_slack, builder.lift(0))
    tip = _Front(builder.lift(1), builder.lift(0))
    if paired:
        with builder.loop("i", 0, paired) as loop:
            base, tip = base.carried(loop, "base"), tip.carried(loop, "tip")
            base.followed(loop, sweep.from_base(base, loop.index))
            tip.followed(loop, sweep.from_tip(tip, links - 1 - loop.index))
    if middle > paired:
        base = sweep.from_base(base, middle - 1)
    return sweep.substitute_back(base, tip, middle, paired)


class _Sweep:
    """Elimination steps and back substitution; `particular` and `coupling` carry one to the other."""

    def __init__(self, builder: Builder, parameters: Parameters, joints: Joints) -> None:
        self.builder, self.joints = builder, joints
        self.links = parameters.links
        self.ratio, self.inverse_ratio = parameters.mass_ratio, parameters.inverse_mass_ratio
        self.particular = builder.array("particular", self.links)
        self.coupling = builder.array("coupling", self.links)

    def from_base(self, front: _Front, k: Index) -> _Front:
        """Eliminate link k from the base side."""
        let = self.builder.let
        inverse_pivot = let("inverse_pivot", 1 / (1 + front.slack))
        gain = let("gain", self.joints.cosine[k + 1] * inverse_pivot)
        load = let("load", self.joints.right_side[k] + front.incoming)
        self.particular[k] = inverse_pivot * load
        self.coupling[k] = gain * self.ratio[k + 1]
        slack = self.ratio[k + 1] * ((self.joints.sine_squared[k + 1] + front.slack) * inverse_pivot)
        return _Front(slack, gain * load)

    def from_tip(self, front: _Front, k: Index) -> _Front:
        """Eliminate link k from the tip side."""
        let = self.builder.let
        scaled = self.inverse_ratio[k] * front.slack
        inverse_pivot = let("inverse_pivot", 1 / (1 + scaled))
        gain = let("gain", self.joints.cosine[k] * inverse_pivot)
        load = let("load", self.joints.right_side[k] + front.incoming)
        self.particular[k] = self.inverse_ratio[k] * (inverse_pivot * load)
        self.coupling[k] = self.inverse_ratio[k] * gain
        return _Front((self.joints.sine_squared[k] + scaled) * inverse_pivot, gain * load)

    def substitute_back(self, base: _Front, tip: _Front, middle: int, paired: int) -> ArrayRef:
        """Where the fronts meet the pivot is t + Y; then outwards on both sides."""
        builder = self.builder
        tension = builder.array("tension", self.links + 1)
        load = self.joints.right_side[middle] + base.incoming + tip.incoming
        tension[middle] = met = builder.let("tension_met", load / (base.slack + tip.slack))
        inner = met
        if paired:
            with builder.loop("i", 0, paired) as loop:
                inner = loop.carry("inner_tension", met)
                outer = loop.carry("outer_tension", met)
                loop.follow(inner, self._outwards(tension, middle - 1 - loop.index, inner))
                loop.follow(outer, self._outwards(tension, middle + 1 + loop.index, outer))
        if middle > paired:
            self._outwards(tension, 0, inner)
        tension[self.links] = builder.lift(0)
        return tension

    def _outwards(self, tension: ArrayRef, k: Index, neighbour: Expr) -> Expr:
        value = self.builder.let("tension_k", self.particular[k] + self.coupling[k] * neighbour)
        tension[k] = value
        return value
