"""The articulated sweep of `articulated` from both ends at once, which halves the chain of dependent operations.

Seen from outside, the links between the base and a joint are a mobility: the joint accelerates by a0 - W f, with f the force
that the links beyond take there. In the units and with the names of `articulated` (F = det W, h = adj(W) a0, f at the outer end
of a link, g at its joint), in the frame of the link,

    D = 1 + lambda^2 W_xx,   Y = W_yy + lambda^2 F,   N = a0_y + lambda^2 h_y + lambda w^2 W_xy
    W'_xx = W_xx / D,   W'_xy = -(lambda - 1) W_xy / D,   W'_yy = 1 + (lambda - 1)^2 Y / D
    F' = (W_xx + (lambda - 1)^2 F) / D
    a0'_x = (a0_x - w^2 (1 + lambda (lambda - 1) W_xx) - lambda tau W_xy) / D,   a0'_y = tau - (lambda - 1) (N - lambda tau Y) / D
    h'_x = a0'_x + (lambda - 1) ((lambda - 1) (h_x - w^2 (W_yy + lambda (lambda - 1) F)) + tau W_xy) / D
    h'_y = (tau W_xx - (lambda - 1) (h_y + w^2 W_xy - lambda tau F)) / D

which is the elimination from the tip with inertia and mobility, force and acceleration exchanged: F and h are to W and a0 what
E and k are to A and b. Where the two meet, f = A a + b and a = a0 - W f give, without a difference of theirs,

    f = (A a0 + b + E h + adj(W) k) / det,   a = (a0 - W b + adj(A) h - F k) / det,   det = 1 + tr(A W) + E F

On the way back to the base forces alone lose the acceleration of a light link between heavy ones, accelerations alone lose it
where links are in line. Taken are f_x and the outer end's acceleration t, with p = tau + (lambda - 1) t_y:

    (D + (lambda - 1)^2 Y) a_y = N - W_xy f_x - Y p,   g_y = p + (lambda - 1)^2 a_y,   a_x = t_x + w^2
    D g_x = f_x + lambda^2 a0_x - lambda w^2 - lambda^2 W_xy g_y

and g_y as one fraction, too. A large couple on a light link whose neighbours are heavy is balanced by f_x; there kappa times

    (W_xx + (lambda - 1)^2 F) a_y = h_y + W_xy a_x - F p

is added, the same statement of the accelerations alone, with kappa the mass of the next link in this one's units: Y gains
kappa F, D gains kappa W_xx. Carried are lambda^2 F and lambda h.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.articulated import Outer, Sweep
from phichain.lowering.planar.base_side import steps, weight
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene


@dataclass(frozen=True)
class _Inner:
    """The chain between the base and a joint: mobility W, lambda^2 F, acceleration a0 and lambda h without the chain beyond."""

    xx: Expr
    xy: Expr
    yy: Expr
    determinant: Expr
    drift_x: Expr
    drift_y: Expr
    minor_x: Expr
    minor_y: Expr

    def carried(self, loop: Loop) -> _Inner:
        """The same as scalars that a loop carries."""
        named = {field.name: getattr(self, field.name) for field in fields(_Inner)}
        return _Inner(**{name: loop.carry(f"mobility_{name}", value) for name, value in named.items()})


@dataclass(frozen=True)
class _Met:
    """Force and acceleration at the outer end of a link, in its frame and units."""

    x_force: Expr
    y_force: Expr
    x: Expr
    y: Expr


def accelerations(
    builder: Builder,
    scene: Scene,
    parameters: Parameters,
    state: PlanarState,
    u: ArrayRef | None,
    a: ArrayRef,
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    sweep = Sweep(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
    middle = (scene.links - 1) // 2
    base = _BaseSide(sweep, middle)
    force = push_on_cart(scene, parameters, u, state.speed)
    inner = base.eliminate(base.turned(base.beginning(force), 0), 0)
    outer = sweep.beyond(2 * middle - 1)
    with builder.loop("i", 0, middle - 1) as loop:
        outer = sweep.carried(loop, outer)
        after = sweep.eliminate(outer, 2 * middle - 2 - loop.index)
        sweep.followed(loop, outer, after)
        inner = inner.carried(loop)
        grown = base.eliminate(base.turned(inner, loop.index + 1), loop.index + 1)
        for name in (field.name for field in fields(_Inner)):
            loop.follow(getattr(inner, name), getattr(grown, name))
    alpha = builder.array("acceleration", scene.links)
    cart = base.substitute(_met(sweep, inner, outer, middle), alpha, force)
    if scene.has_cart:
        a[0] = cart * parameters.units.length
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


def _met(sweep: Sweep, inner: _Inner, outer: Outer, k: int) -> _Met:
    """What the two sides do where they meet, below link k; worked out in its units, stated in those of the link before."""
    let, units = sweep.builder.let, sweep.units
    mass, length = units.mass[k], units.length[k]
    leverage, shortening = units.leverage[k], units.shortening[k]
    of_mass, of_length = 1 / mass, units.outward[k]
    of_force, minor = of_mass * of_length, of_mass * of_mass * (shortening * units.leverage[k - 1])
    xx, xy, yy = (value * of_mass for value in (outer.xx, outer.xy, outer.yy))
    shrunk = outer.determinant * minor
    force_x, force_y = (value * of_force for value in (outer.force_x, outer.force_y))
    minor_x, minor_y = (value * (minor * of_length) for value in (outer.minor_x, outer.minor_y))
    trace = xx * inner.xx + 2 * (xy * inner.xy) + yy * inner.yy
    inverse = let("inverse_meeting", 1 / (1 + trace + shrunk * inner.determinant * shortening))
    adjugate_x = leverage * (inner.yy * minor_x - inner.xy * minor_y)
    adjugate_y = leverage * (inner.xx * minor_y - inner.xy * minor_x)
    met_x = xx * inner.drift_x + xy * inner.drift_y + force_x + shrunk * inner.minor_x + adjugate_x
    met_y = xy * inner.drift_x + yy * inner.drift_y + force_y + shrunk * inner.minor_y + adjugate_y
    still_x = (yy * inner.minor_x - xy * inner.minor_y - inner.determinant * minor_x) * shortening
    still_y = (xx * inner.minor_y - xy * inner.minor_x - inner.determinant * minor_y) * shortening
    x = inner.drift_x - inner.xx * force_x - inner.xy * force_y + still_x
    y = inner.drift_y - inner.xy * force_x - inner.yy * force_y + still_y
    unit = mass * length * inverse
    scale = length * inverse
    return _Met(
        let("met_force_x", unit * met_x), unit * met_y, let("met_x", scale * x), let("met_y", scale * y)
    )


class _BaseSide:
    """The links from the base to the middle: elimination outwards, and back; work arrays carry one to the other."""

    def __init__(self, sweep: Sweep, links: int) -> None:
        self.sweep, self.links, self.builder, self.units = sweep, links, sweep.builder, sweep.units
        self.steps = steps(sweep, links)
        self.weight = weight(sweep, links)
        names = ("yield", "reach", "coupling_skew", "rest", "rest_force", "rest_across", "rest_push", "drive")
        self.kept = {name: self.builder.array(f"base_{name}", links) for name in names}

    def beginning(self, force: Expr) -> _Inner:
        """What carries link 0: a wall, which may be given an acceleration, or a cart that yields to the side."""
        parameters, zero = self.sweep.parameters, self.builder.lift(0)
        inverse = 1 / parameters.length[0]
        wall = _Inner(*(zero for _ in fields(_Inner)))
        wall = replace(wall, drift_x=-parameters.fall[1] * inverse, drift_y=-parameters.fall[0] * inverse)
        if not self.sweep.scene.has_cart:
            return wall
        yielding = self.units.mass_unit[0] / parameters.base_mass
        return replace(
            wall, yy=yielding, drift_y=force * inverse / parameters.base_mass,
            minor_x=self.units.leverage[0] * yielding * wall.drift_x,
        )  # fmt: skip

    def turned(self, inner: _Inner, k: Index) -> _Inner:
        """The same in the frame of link k; determinants do not change."""
        let, sine, cosine = self.builder.let, self.sweep.sine[k], self.sweep.cosine[k]
        shear = let("yield_shear", sine * (inner.yy - inner.xx) + cosine * (inner.xy + inner.xy))
        lean = let("yield_lean", sine * shear)
        return replace(
            inner, xx=let("yield_xx", inner.xx + lean), xy=let("yield_xy", cosine * shear - inner.xy),
            yy=let("yield_yy", inner.yy - lean),
            drift_x=let("drift_x", cosine * inner.drift_x + sine * inner.drift_y),
            drift_y=let("drift_y", cosine * inner.drift_y - sine * inner.drift_x),
            minor_x=let("drift_minor_x", cosine * inner.minor_x + sine * inner.minor_y),
            minor_y=let("drift_minor_y", cosine * inner.minor_y - sine * inner.minor_x),
        )  # fmt: skip

    def eliminate(self, inner: _Inner, k: Index) -> _Inner:
        """Link k and all before it, in its frame and the next link's units."""
        let, sweep, steps = self.builder.let, self.sweep, self.steps
        leverage, overhang = self.units.leverage[k], self.units.overhang[k]
        rate_squared = let("rate_squared", sweep.state.rate[k] * sweep.state.rate[k])
        sweep.rate_squared[k] = rate_squared
        drive = self.builder.lift(0)
        if sweep.couple is not None:
            drive = let("drive", sweep.couple[k] * self.units.inverse_torque[k])
            self.kept["drive"][k] = drive
        along = let("yield_along", steps.leverage_squared[k] * inner.xx)
        inverse = let("inverse_yield", 1 / (1 + along))
        across = let("yield_across", inner.yy + inner.determinant)
        swing = let("yield_swing", rate_squared * inner.xy)
        free = let("drift_free", inner.drift_y + leverage * (inner.minor_y + swing))
        skew = let("yield_skew", inner.xy * inverse)
        self._keep(inner, k, (along, inverse, across, free, skew, rate_squared))
        slack = let("yield_slack", inner.xx * inverse)
        end_x = inner.drift_x * inverse - rate_squared * (inverse + steps.lever[k] * slack)
        end_x = let("end_x", end_x - leverage * drive * skew)
        end_y = drive - overhang * ((free - leverage * drive * across) * inverse)
        minor_x = inner.minor_x - rate_squared * (overhang * across + inner.yy)
        minor_x = (
            leverage * end_x
            + steps.overhang_squared[k] * (minor_x * inverse)
            + steps.lever[k] * (drive * skew)
        )
        minor_y = overhang * (inner.minor_y + leverage * swing - drive * inner.determinant)
        minor_y = (drive * (leverage * inner.xx) - minor_y) * inverse
        determinant = (along + steps.overhang_squared[k] * inner.determinant) * inverse
        return _Inner(
            xx=let("mobility_xx", steps.mass[k] * slack), xy=let("mobility_xy", -(steps.skew[k] * skew)),
            yy=let("mobility_yy", steps.mass[k] + steps.levered[k] * (across * inverse)),
            determinant=let("mobility_determinant", steps.determinant[k] * determinant),
            drift_x=steps.length[k] * end_x, drift_y=let("end_y", steps.length[k] * end_y),
            minor_x=let("mobility_minor_x", steps.minor[k] * minor_x),
            minor_y=let("mobility_minor_y", steps.minor[k] * minor_y),
        )  # fmt: skip

    def _keep(self, inner: _Inner, k: Index, found: tuple[Expr, ...]) -> None:
        """What the way back needs of link k."""
        let, kept, leverage = self.builder.let, self.kept, self.units.leverage[k]
        along, inverse, across, free, skew, rate_squared = found
        pivot, push = 1 + along, free
        if self.weight is not None:
            pivot = pivot + self.weight.own[k] * inner.xx
            push = push + self.weight.minor[k] * inner.minor_y
            across = across + self.weight.determinant[k] * inner.determinant
        rest = let("inverse_rest", 1 / (pivot + self.steps.overhang_squared[k] * across))
        kept["rest"][k], kept["rest_push"][k] = rest * inner.xy, rest * push
        kept["rest_across"][k], kept["rest_force"][k] = rest * across, rest * pivot
        kept["yield"][k], kept["coupling_skew"][k] = inverse, self.steps.leverage_squared[k] * skew
        kept["reach"][k] = leverage * (leverage * inner.drift_x - rate_squared) * inverse

    def substitute(self, met: _Met, alpha: ArrayRef, force: Expr) -> Expr:
        """Write the angular accelerations of all links; returns the acceleration of the base across the vertical."""
        sweep, links, scene = self.sweep, self.links, self.sweep.scene
        with self.builder.loop("i", 0, links) as loop:
            outer = sweep.outwards(alpha, loop, (met.x, met.y), loop.index + links)
            inner = _Met(
                loop.carry("force_x", met.x_force),
                met.y_force,
                loop.carry("end_x", met.x),
                loop.carry("end_y", met.y),
            )
            if scene.has_cart:
                inner = replace(inner, y_force=loop.carry("force_y", met.y_force))
            before = self._back(inner, alpha, links - 1 - loop.index)
            for name in ("x_force", "x", "y", *(["y_force"] if scene.has_cart else [])):
                loop.follow(getattr(inner, name), getattr(before, name))
        for k in range(2 * links, scene.links):
            outer = sweep.outer_end(alpha, outer, k)
        if not scene.has_cart:
            return self.builder.lift(0)
        unit, parameters = self.units.mass_unit[0], sweep.parameters
        # With u - f_y = m_c x'' goes x'' = t_y, weighed by the heavier of what a light cart carries.
        weight = unit if self.weight is None else unit * (1 + self.weight.own[0])
        push = force + parameters.length[0] * (weight * inner.y - unit * inner.y_force)
        return self.builder.let("cart_acceleration", push / (parameters.base_mass + weight))

    def _back(self, end: _Met, alpha: ArrayRef, k: Index) -> _Met:
        """Write the angular acceleration of link k; returns what the outer end of the link before does."""
        let, sweep, steps = self.builder.let, self.sweep, self.steps
        kept = {name: cells[k] for name, cells in self.kept.items()}
        push = self.units.overhang[k] * end.y
        if sweep.couple is not None:
            push = kept["drive"] + push
        joint_x = let("inner_x", end.x + sweep.rate_squared[k])
        pull = end.x_force if self.weight is None else end.x_force - self.weight.own[k] * joint_x
        rest = let("rest", kept["rest_push"] - kept["rest"] * pull)
        joint_y = let("inner_y", rest - kept["rest_across"] * push)
        alpha[k] = end.y - joint_y
        force_y = let("inner_force_y", steps.overhang_squared[k] * rest + kept["rest_force"] * push)
        force_x = let(
            "inner_force_x", kept["yield"] * end.x_force + kept["reach"] - kept["coupling_skew"] * force_y
        )
        sine, cosine, length, unit = (
            sweep.sine[k],
            sweep.cosine[k],
            self.units.length[k],
            sweep.factors.force[k],
        )
        return _Met(
            let("end_force_x", unit * (cosine * force_x - sine * force_y)), unit * (sine * force_x + cosine * force_y),
            let("inner_end_x", length * (cosine * joint_x - sine * joint_y)),
            let("inner_end_y", length * (sine * joint_x + cosine * joint_y)),
        )  # fmt: skip
