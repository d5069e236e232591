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

from dataclasses import fields, replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.articulated import Sweep
from phichain.lowering.planar.both_ends.base_side import steps, weight
from phichain.lowering.planar.both_ends.meeting import Inner, Met, WayBack, beginning, met
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene


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
    inner = base.eliminate(base.turned(beginning(builder, scene, parameters, sweep.units, force), 0), 0)
    outer = sweep.beyond(2 * middle - 1)
    with builder.loop("i", 0, middle - 1) as loop:
        outer = sweep.carried(loop, outer)
        after = sweep.eliminate(outer, 2 * middle - 2 - loop.index)
        sweep.followed(loop, outer, after)
        inner = inner.carried(loop)
        grown = base.eliminate(base.turned(inner, loop.index + 1), loop.index + 1)
        for name in (field.name for field in fields(Inner)):
            loop.follow(getattr(inner, name), getattr(grown, name))
    alpha = builder.array("acceleration", scene.links)
    cart = base.substitute(met(builder, sweep.units, inner, outer, middle), alpha, force)
    if scene.has_cart:
        a[0] = cart * parameters.units.length
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


class _BaseSide:
    """The links from the base to the middle: elimination outwards, and back; work arrays carry one to the other."""

    def __init__(self, sweep: Sweep, links: int) -> None:
        self.sweep, self.links, self.builder, self.units = sweep, links, sweep.builder, sweep.units
        self.steps = steps(sweep.parameters, sweep.units, links)
        self.weight = weight(sweep.scene, sweep.parameters, sweep.units, links)
        names = ("yield", "reach", "coupling_skew", "rest", "rest_force", "rest_across", "rest_push", "drive")
        self.kept = {name: self.builder.array(f"base_{name}", links) for name in names}
        kept = self.kept if sweep.couple is not None else {name: cells for name, cells in self.kept.items() if name != "drive"}
        self.way_back = WayBack(
            self.builder, sweep.scene, sweep.parameters, self.units, self.weight, sweep.sine, sweep.cosine,
            sweep.rate_squared, self.steps.overhang_squared, sweep.factors.force, kept,
        )  # fmt: skip

    def turned(self, inner: Inner, k: Index) -> Inner:
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

    def eliminate(self, inner: Inner, k: Index) -> Inner:
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
        return Inner(
            xx=let("mobility_xx", steps.mass[k] * slack), xy=let("mobility_xy", -(steps.skew[k] * skew)),
            yy=let("mobility_yy", steps.mass[k] + steps.levered[k] * (across * inverse)),
            determinant=let("mobility_determinant", steps.determinant[k] * determinant),
            drift_x=steps.length[k] * end_x, drift_y=let("end_y", steps.length[k] * end_y),
            minor_x=let("mobility_minor_x", steps.minor[k] * minor_x),
            minor_y=let("mobility_minor_y", steps.minor[k] * minor_y),
        )  # fmt: skip

    def _keep(self, inner: Inner, k: Index, found: tuple[Expr, ...]) -> None:
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

    def substitute(self, meeting: Met, alpha: ArrayRef, force: Expr) -> Expr:
        """Write the angular accelerations of all links; returns the acceleration of the base across the vertical."""
        sweep, links, scene = self.sweep, self.links, self.sweep.scene
        with self.builder.loop("i", 0, links) as loop:
            outer = sweep.outwards(alpha, loop, (meeting.x, meeting.y), loop.index + links)
            inner = Met(
                loop.carry("force_x", meeting.x_force),
                meeting.y_force,
                loop.carry("end_x", meeting.x),
                loop.carry("end_y", meeting.y),
            )
            if scene.has_cart:
                inner = replace(inner, y_force=loop.carry("force_y", meeting.y_force))
            before = self.way_back.step(inner, alpha, links - 1 - loop.index)
            for name in ("x_force", "x", "y", *(["y_force"] if scene.has_cart else [])):
                loop.follow(getattr(inner, name), getattr(before, name))
        for k in range(2 * links, scene.links):
            outer = sweep.outer_end(alpha, outer, k)
        return self.way_back.cart_acceleration(inner, force)
