"""Tensions of a chain whose masses sit at the link ends (theory section 5): one symmetric tridiagonal system, free of cancellation.

The links are distance constraints. Link k (from 0) joins mass k-1 to mass k, mass -1 being the cart. With c_k = q_{k-1}.q_k,
s_k^2 = |q_{k-1} x q_k|^2 and s_0^2 = |C^T q_0|^2 the tensions lambda solve

    -(c_k / m_{k-1}) lambda_{k-1} + (1/m_{k-1} + 1/m_k) lambda_k - (c_{k+1} / m_k) lambda_{k+1} = b_k

(first row: s_0^2/m_{-1} + 1/m_0 on the diagonal). Eliminating from the base and from the tip towards the middle (a twisted
factorisation) halves the chain of dependent operations; writing pivots as 1/m_k + x_k, x_k > 0, from s_k^2 and never from
1 - c_k^2 keeps every term positive. Everything is scaled by the masses, so equal masses cost nothing. With
rho_k = m_k / m_{k-1}, the slacks t_k = m_k x_k (from the base) and Y_k = m_k y_k (from the tip) follow

    t_{k+1} = rho_{k+1} (s_{k+1}^2 + t_k) / (1 + t_k),    t_0 = rho_0 s_0^2
    Y_{k-1} = (s_k^2 + z_k) / (1 + z_k),  z_k = Y_k / rho_k,    Y_{N-1} = 1

Both are fractions of numbers that obey linear recurrences (t = n / d: d' = d + n, n' = rho (s^2 d + n)), as do the right sides
scaled by d. Carrying numerator and denominator takes the divisions off the chain of dependent operations. Since t_k <= rho_k
and z_k <= 1 / rho_k, the growth of d is bounded beforehand; where the bound is too large, or unknown because the masses are
runtime parameters, every step divides instead and d stays 1.

Two links of like masses need none of it: with 1 - c_1^2 for s_1^2 the pivot is a plain difference that leaves a known part of 1
(`takes_cosines`), and no product of the links is waited for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene

#: Up to so many links what counts is the operations; beyond, how long a tension waits for its neighbour's.
_SHORT = 3
#: Up to so many units of rounding of a pivot cosines alone may cost in the worst of all states.
_MOST_ROUNDINGS = 5
#: Largest growth of a denominator that leaves the scaled loads far from overflow.
_LARGEST_GROWTH = {"double": 1e100, "float": 1e12}


@dataclass(frozen=True)
class Joints:
    """What the tridiagonal system needs of the joints.

    Attributes:
        cosine: q_{k-1}.q_k for k >= 1.
        sine_squared: |q_{k-1} x q_k|^2 for k >= 1; None where pivots are made of cosines alone.
        base_slack: rho_0 s_0^2, zero on a fixed base.
        right_side: b_k.
        meeting: the link where the fronts from the base and from the tip meet.
    """

    cosine: ArrayRef
    sine_squared: ArrayRef | None
    base_slack: Expr
    right_side: ArrayRef
    meeting: int


def takes_cosines(scene: Scene) -> bool:
    """Whether two links' pivot may be made of 1 - c_1^2: it is at least 1 / (1 + rho_1), and off by two roundings of 1 and two of rho_0."""
    if scene.links != 2 or isinstance(scene.mass, str) or isinstance(scene.cart_mass, str):
        return False
    first, second = scene.mass
    on_cart = 0.0 if scene.cart_mass is None else first / scene.cart_mass
    return 2 * (1 + on_cart) * (1 + second / first) <= _MOST_ROUNDINGS


@dataclass(frozen=True)
class _Front:
    """An elimination front: its slack as a fraction, and the scaled load that the eliminated links pass on."""

    numerator: Expr
    denominator: Expr
    incoming: Expr
    #: Whether the denominator grows, instead of every step dividing.
    scaled: bool
    #: What of the numerator waits for the last joint's sine, and what does not, where both are still apart.
    parts: tuple[Expr, Expr] | None = None

    def carried(self, loop: Loop, side: str) -> _Front:
        """The same front as loop-carried scalars (a denominator that is 1 throughout is not carried)."""
        denominator = self.denominator
        if self.scaled:
            denominator = loop.carry(f"{side}_denominator", self.denominator)
        return replace(
            self, numerator=loop.carry(f"{side}_numerator", self.numerator), denominator=denominator,
            incoming=loop.carry(f"{side}_incoming", self.incoming), parts=None,
        )  # fmt: skip

    def followed(self, loop: Loop, after: _Front) -> None:
        """Say what the front is on the next turn."""
        loop.follow(self.numerator, after.numerator)
        loop.follow(self.incoming, after.incoming)
        if self.scaled:
            loop.follow(self.denominator, after.denominator)


def middle(links: int) -> int:
    """Where fronts meet soonest; of an even number of links the tip's side takes one more, since its first pivot is a number."""
    return (links - 1) // 2


def solve_tensions(builder: Builder, parameters: Parameters, joints: Joints) -> ArrayRef:
    """Scaled tensions lambda_k / m_k, N + 1 cells, the last one (beyond the tip) zero."""
    links, meeting = parameters.links, joints.meeting
    if joints.sine_squared is None:
        return _of_two(builder, parameters, joints)
    sweep = _Sweep(builder, parameters, joints)
    scaled = parameters.pivot_growth <= _LARGEST_GROWTH[parameters.real]
    one, nothing = builder.lift(1), builder.lift(0)
    base = _Front(joints.base_slack, one, nothing, scaled)
    tip = _Front(one, one, nothing, scaled)
    before, beyond = meeting, links - 1 - meeting
    if both := min(before, beyond):
        with builder.loop("i", 0, both) as loop:
            base, tip = base.carried(loop, "base"), tip.carried(loop, "tip")
            base.followed(loop, sweep.from_base(base, loop.index))
            tip.followed(loop, sweep.from_tip(tip, links - 1 - loop.index))
    if before > both:
        base = sweep.from_base(base, meeting - 1)
    if beyond > both:
        tip = sweep.from_tip(tip, meeting + 1)
    return sweep.substitute_back(base, tip, meeting)


def write_tensions(builder: Builder, parameters: Parameters, scaled: ArrayRef, out: ArrayRef) -> None:
    """lambda_k, N, from lambda_k / m_k in the units of the scene's parameters."""
    unit = parameters.units.force
    with builder.loop("k", 0, parameters.links) as loop:
        out[loop.index] = scaled[loop.index] * (parameters.mass[loop.index] * unit)


def _of_two(builder: Builder, parameters: Parameters, joints: Joints) -> ArrayRef:
    """The same of two links by the first one's plain pivot, 1 + t_0 less what the other takes of it."""
    ratio, turn, load = parameters.mass_ratio[1], joints.cosine[1], joints.right_side[1]
    tension, inverse = builder.array("tension", 3), 1 / (1 + ratio)
    lever = builder.let("lever", turn * inverse)
    pivot = (1 + joints.base_slack) - ratio * (turn * lever)
    tension[0] = first = builder.let("middle_tension", (joints.right_side[0] + ratio * (lever * load)) / pivot)
    tension[1] = builder.let("outer_tension_next", load * inverse + lever * first)
    tension[2] = builder.lift(0)
    return tension


class _Sweep:
    """Elimination steps and back substitution; `load`, `coupling` and `gain` carry one to the other."""

    def __init__(self, builder: Builder, parameters: Parameters, joints: Joints) -> None:
        assert joints.sine_squared is not None
        self.builder, self.joints, self.sine_squared = builder, joints, joints.sine_squared
        self.links = parameters.links
        self.ratio, self.inverse_ratio = parameters.mass_ratio, parameters.inverse_mass_ratio
        self.is_short = self.links <= _SHORT
        self.load = builder.array("load", self.links)
        self.coupling = builder.array("coupling", self.links)
        self.gain = builder.array("gain", self.links)

    def from_base(self, front: _Front, k: Index) -> _Front:
        """Eliminate link k from the base side."""
        ratio, cosine = self.ratio[k + 1], self.joints.cosine[k + 1]
        load = self.builder.let("base_load", self.joints.right_side[k] * front.denominator + front.incoming)
        inverse = self.builder.let("base_inverse_pivot", 1 / (front.denominator + front.numerator))
        self._keep(k, load, ratio * (cosine * front.denominator), inverse)
        numerator = ratio * (self.sine_squared[k + 1] * front.denominator + front.numerator)
        return self._passed_on(front, front.numerator, numerator, cosine * load, inverse)

    def from_tip(self, front: _Front, k: Index) -> _Front:
        """Eliminate link k from the tip side."""
        ratio, cosine = self.inverse_ratio[k], self.joints.cosine[k]
        slack = ratio * front.numerator
        load = self.builder.let("tip_load", self.joints.right_side[k] * front.denominator + front.incoming)
        inverse = self.builder.let("tip_inverse_pivot", 1 / (front.denominator + slack))
        self._keep(k, load, cosine * front.denominator, ratio * inverse)
        late = self.sine_squared[k] * front.denominator
        following = self._passed_on(front, slack, late + slack, cosine * load, inverse)
        return replace(following, parts=(late, slack)) if front.scaled else following

    def _keep(self, k: Index, load: Expr, coupling: Expr, gain: Expr) -> None:
        """What back substitution needs: the tension is (load + coupling * neighbour's) * gain."""
        self.gain[k] = gain
        self.load[k], self.coupling[k] = (load, coupling) if self.is_short else (load * gain, coupling * gain)

    def _passed_on(self, front: _Front, slack: Expr, numerator: Expr, incoming: Expr, inverse: Expr) -> _Front:
        """The next front: d + n below the fraction, or everything divided by it."""
        if front.scaled:
            return replace(front, numerator=numerator, denominator=front.denominator + slack, incoming=incoming, parts=None)
        return replace(front, numerator=numerator * inverse, incoming=incoming * inverse)

    def substitute_back(self, base: _Front, tip: _Front, meeting: int) -> ArrayRef:
        """Where the fronts meet the pivot is t + Y; then outwards on both sides."""
        builder = self.builder
        tension = builder.array("tension", self.links + 1)
        load = self.joints.right_side[meeting] * (base.denominator * tip.denominator)
        load = load + base.incoming * tip.denominator + tip.incoming * base.denominator
        late, early = tip.parts or (tip.numerator, builder.lift(0))
        pivot = (base.numerator * tip.denominator + early * base.denominator) + late * base.denominator
        tension[meeting] = inner = outer = builder.let("middle_tension", load / pivot)
        before, beyond = meeting, self.links - 1 - meeting
        if both := min(before, beyond):
            with builder.loop("i", 0, both) as loop:
                inner, outer = loop.carry("inner_tension", inner), loop.carry("outer_tension", outer)
                loop.follow(inner, self._outwards("inner", tension, meeting - 1 - loop.index, inner))
                loop.follow(outer, self._outwards("outer", tension, meeting + 1 + loop.index, outer))
        if before > both:
            self._outwards("inner", tension, 0, inner)
        if beyond > both:
            self._outwards("outer", tension, self.links - 1, outer)
        tension[self.links] = builder.lift(0)
        return tension

    def _outwards(self, side: str, tension: ArrayRef, k: Index, neighbour: Expr) -> Expr:
        total = self.load[k] + self.coupling[k] * neighbour
        value = self.builder.let(f"{side}_tension_next", total * self.gain[k] if self.is_short else total)
        tension[k] = value
        return value
