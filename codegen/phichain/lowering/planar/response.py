"""How the planar chain answers small forces and jumps, in link frames: what Jacobians are made of (docs/theory.md, section 5).

After the articulated sweep every perturbation of the chain is linear in the joint accelerations X (two numbers a joint, in the
frame of the link beyond, in units of its length), and a link passes X on outwards by one 2 x 2 matrix:

    alpha_k = phi - rho_k.X - gain_x d_x,     X_{k+1} = T (X + (d_x, 0)) + (phi + d_y) n,     rho = (gain_x, 1 + gain_y)

for a jump d of the acceleration beyond the link's tip and a free turn phi. Forces come in as their moments about one length of
the link, N m, and go inwards by T^T. The mobility of the joint, all of the chain on both its sides included, is
Omega_{k+1} = T Omega T^T + n n^T / D. With L the inertia beyond the joint, before it is turned by the joint's angle,

    T = (1 / D) [[c (1 + L_yy) + s L_xy,  -s (lambda - 1)],  [-(s (1 + L_xx) + c L_xy),  -c (lambda - 1)]]

which is R^T times the elimination's [[1, 0], [-gain_x, -gain_y]] without its differences: where much heavier links are beyond,
c - s gain_x cancels. On a cart joint 0 has a link before it that cannot turn but slide, whose D is that of the cart.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_text
from phichain.lowering.planar.articulated import Outer, Pivot, Sweep
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene

Pair = tuple[Expr, Expr]


class Recalled(Sweep):
    """The articulated sweep that keeps what derivatives need."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None
    ) -> None:
        super().__init__(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
        kept = ("inverse", "level", "axial", "pull", "link_xx", "tip_x", "tip_y", "tip_force_x", "tip_force_y", "link_xy", "link_yy")
        left_out = {"link_xy", "link_yy"} if scene.tip_masses else set()
        left_out |= {"link_xx", "link_xy"} if saves_text(scene) else set()
        names = [name for name in kept if name not in left_out]
        self.kept = {name: builder.array(f"{name}_of", scene.links) for name in names}

    def pivot(self, outer: Outer, k: Index) -> Pivot:
        """As the sweep, and keep 1 / D, A_yy / D, (A_xx + E) / D and (b_x + k_x + tau A_xy) / D."""
        pivot = super().pivot(outer, k)
        self.kept["inverse"][k] = pivot.inverse
        self.kept["level"][k] = outer.yy * pivot.inverse
        self.kept["axial"][k] = self.axial(outer, k) * pivot.inverse
        self.kept["pull"][k] = self.pulled(outer, pivot.drive, k) * pivot.inverse
        return pivot

    def _turned(self, link: Outer, k: Index) -> Outer:
        for name in ("xx", "xy", "yy"):
            if f"link_{name}" in self.kept:
                self.kept[f"link_{name}"][k] = getattr(link, name)
        return super()._turned(link, k)

    def inertia(self, k: Index) -> tuple[Expr, Expr, Expr]:
        """Link k and all beyond it in its frame, in units of the link before: what is kept of it, or made again of what is kept anyway."""
        kept, factors, nothing = self.kept, self.factors, self.builder.lift(0)
        xx = kept["link_xx"][k] if "link_xx" in kept else factors.axial[k] + factors.mass[k] * kept["axial"][k]
        if self.scene.tip_masses:
            return xx, nothing, nothing
        return xx, kept["link_xy"][k] if "link_xy" in kept else -(factors.skew[k] * self.gain_x[k]), kept["link_yy"][k]

    def moved(self, k: Index, joint_y: Expr, tip: Pair) -> None:
        """Keep the acceleration of a link's tip and the force that it gives to what is beyond, in the link's units."""
        kept, overhang = self.kept, self.units.overhang[k]
        kept["tip_x"][k], kept["tip_y"][k] = tip
        drive = self.builder.lift(0) if self.couple is None else self.couple[k] * self.units.inverse_torque[k]
        kept["tip_force_x"][k] = kept["axial"][k] * tip[0] + kept["pull"][k] - overhang * self.gain_x[k] * joint_y
        kept["tip_force_y"][k] = drive - overhang * joint_y - tip[1]


@dataclass(frozen=True)
class Base:
    """What stands before joint 0, in units of link 0.

    Attributes:
        tip: its acceleration less gravity.
        zeta: what turning joint 0 takes away of the cart's acceleration.
        gain: A_xy / D; structurally zero on a fixed base, as all but `tip`.
        mobile: 1 / D as the acceleration, in lengths of link 0, of a moment about one such length.
    """

    tip: Pair
    zeta: Expr
    gain: Expr
    mobile: Expr


class Response:
    """T, n, rho, sigma and omega of every joint, and how columns go over a link.

    sigma.X is what joint k's own acceleration makes of X at joint k - 1: rho_{k-1} - T^T rho_k in relative angles, -T^T rho_k in
    others, whose rows are those of absolute angles; omega n that of a couple on the joint.
    """

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, sweep: Recalled) -> None:
        self.builder, self.scene, self.sweep, self.units = builder, scene, sweep, sweep.units
        self.nothing = builder.lift(0)
        links, kept = scene.links, sweep.kept
        self.torque_unit = sweep.units.torque_unit
        names: tuple[str, ...] = ("pass_xx", "pass_yx", "turn_x", "turn_y", "link_mobility", "joint_gain")
        names += () if scene.tip_masses else ("pass_xy", "pass_yy")
        names += ("link_row_x", "link_row_y", "joint_row_x", "joint_row_y")
        self.arrays = {name: builder.array(name, links + 1) for name in names}
        for name in ("pass_xx", "pass_xy", "pass_yx", "pass_yy", "turn_x", "turn_y"):
            if name in self.arrays:
                self.arrays[name][links] = self.nothing
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            self.arrays["link_mobility"][k] = kept["inverse"][k] * self.units.inverse_torque[k]
        with builder.loop("k", 1, links) as loop:
            self._joint(loop.index)

    def _joint(self, k: Index) -> None:
        let, arrays, kept, sweep = self.builder.let, self.arrays, self.sweep.kept, self.sweep
        sine, cosine, overhang = sweep.sine[k], sweep.cosine[k], self.units.overhang[k - 1]
        step = let("pass_step", self.units.outward[k] * kept["inverse"][k - 1])
        xx, xy, yy = sweep.inertia(k)
        arrays["pass_xx"][k] = step * (cosine * (1 + yy) + sine * xy)
        arrays["pass_yx"][k] = -(step * (sine * (1 + xx) + cosine * xy))
        if "pass_xy" in arrays:
            lever = let("pass_lever", step * overhang)
            arrays["pass_xy"][k], arrays["pass_yy"][k] = -(lever * sine), -(lever * cosine)
        turn = self.units.outward[k] * sine, self.units.outward[k] * cosine
        arrays["turn_x"][k], arrays["turn_y"][k] = turn
        rho = self.rho(k)
        arrays["joint_gain"][k] = dot(turn, rho)
        before, back = self.rho(k - 1), self.inwards(k, rho)
        arrays["link_row_x"][k], arrays["link_row_y"][k] = -back[0], -back[1]
        arrays["joint_row_x"][k], arrays["joint_row_y"][k] = before[0] - back[0], before[1] - back[1]

    def on_wall(self, fall: tuple[Expr, ...], length: Expr) -> Base:
        """A base that stands still, or is given its acceleration."""
        turn = self.sweep.sine[0], self.sweep.cosine[0]
        self.arrays["turn_x"][0], self.arrays["turn_y"][0] = turn
        return Base((-fall[1] / length, -fall[0] / length), self.nothing, self.nothing, self.nothing)

    def on_cart(self, parameters: Parameters, outer: Outer, acceleration: Expr, force: Expr) -> Base:
        """The cart, which slides where a link turns."""
        let, arrays, units, sweep = self.builder.let, self.arrays, self.units, self.sweep
        unit, length = units.mass_unit[0], parameters.length[0]
        leverage = self.builder.lift(1) if units.is_rigid else units.leverage[0]
        mass = let("cart_mass_ratio", parameters.base_mass / unit)
        inverse = let("inverse_cart_pivot", 1 / (mass + outer.yy))
        tip = let("cart_tip_x", -parameters.gravity / length), let("cart_tip_y", acceleration / length)
        axial = outer.xx * mass + leverage * outer.determinant
        push = force / (unit * length)
        pull = axial * tip[0] + outer.xy * push + (outer.force_x * mass + leverage * outer.minor_x)
        xx, xy, yy = sweep.inertia(0)
        sine, cosine = sweep.sine[0], sweep.cosine[0]
        arrays["pass_xx"][0] = inverse * (cosine * (mass + yy) + sine * xy)
        arrays["pass_yx"][0] = -(inverse * (sine * (mass + xx) + cosine * xy))
        if "pass_xy" in arrays:
            arrays["pass_xy"][0] = arrays["pass_yy"][0] = self.nothing
        arrays["turn_x"][0], arrays["turn_y"][0] = sine, cosine
        arrays["joint_gain"][0] = dot((sine, cosine), self.rho(0))
        zeta = inverse * (pull * inverse - outer.yy * tip[0])
        return Base(tip, zeta, outer.xy * inverse, inverse * units.inverse_torque[0])

    def rho(self, k: Index) -> Pair:
        """(gain_x, 1 + gain_y): -alpha per joint acceleration, and per couple what the joint before it has to bear."""
        rho_y = self.sweep.rho_y
        return self.sweep.gain_x[k], 1 + self.sweep.gain_y[k] if rho_y is None else rho_y[k]

    def matrix(self, k: Index) -> tuple[Expr, Expr, Expr, Expr]:
        """T of joint k, row by row."""
        cell = self.arrays
        xy, yy = (cell[name][k] if name in cell else self.nothing for name in ("pass_xy", "pass_yy"))
        return cell["pass_xx"][k], xy, cell["pass_yx"][k], yy

    def rows(self, k: Index) -> tuple[Pair, Pair]:
        """T of joint k as two rows."""
        a, b, c, d = self.matrix(k)
        return (a, b), (c, d)

    def outwards(self, k: Index, x: Pair) -> Pair:
        """T x."""
        a, b, c, d = self.matrix(k)
        return a * x[0] + b * x[1], c * x[0] + d * x[1]

    def inwards(self, k: Index, force: Pair) -> Pair:
        """T^T force."""
        a, b, c, d = self.matrix(k)
        return a * force[0] + c * force[1], b * force[0] + d * force[1]

    def turn(self, k: Index) -> Pair:
        """n of joint k."""
        return self.arrays["turn_x"][k], self.arrays["turn_y"][k]

    def row(self, k: Index, of_joint: bool) -> Pair:
        """sigma of the joint's own angle, or of the link's absolute one."""
        name = "joint_row" if of_joint else "link_row"
        return self.arrays[f"{name}_x"][k], self.arrays[f"{name}_y"][k]


class Outwards:
    """X of every joint by the T that takes columns outwards, link by link in a loop that others may share.

        X_{k+1} = T X_k + free n - w^2 (n_y, -n_x)

    waits for one product where the sweep waits for an elimination and a turn after it; and T holds none of their differences. The
    accelerations of the tips and of the links follow from all X at once.
    """

    def __init__(self, builder: Builder, scene: Scene, response: Response, base: Base) -> None:
        self.builder, self.scene, self.response = builder, scene, response
        self.joint_x, self.joint_y = builder.array("joint_x_of", scene.links), builder.array("joint_y_of", scene.links)
        turn = response.turn(0)
        self.first = turn[1] * base.tip[0] + turn[0] * base.tip[1], turn[1] * base.tip[1] - turn[0] * base.tip[0]
        self.joint_x[0], self.joint_y[0] = self.first

    def step(self, loop: Loop) -> None:
        """From joint k - 1 to joint k, for k from 1 on."""
        k, let, response, sweep = loop.index, self.builder.let, self.response, self.response.sweep
        before = loop.carry("before_x", self.first[0]), loop.carry("before_y", self.first[1])
        turn, free, swung = response.turn(k), sweep.free[k - 1], sweep.rate_squared[k - 1]
        row_x, row_y = response.rows(k)
        self.joint_x[k] = x = let("joint_x", dot(row_x, before) + (free * turn[0] - swung * turn[1]))
        self.joint_y[k] = y = let("joint_y", dot(row_y, before) + (free * turn[1] + swung * turn[0]))
        loop.follow(before[0], x)
        loop.follow(before[1], y)

    def finish(self, theta_ddot: ArrayRef) -> None:
        """What is kept of the tips, and the accelerations of the scene's angles."""
        alpha = self.builder.array("acceleration", self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            self.response.sweep.tip_of(alpha, (self.joint_x[loop.index], self.joint_y[loop.index]), loop.index)
        from_absolute(self.builder, self.scene, alpha, theta_ddot)


def dot(a: Pair, b: Pair) -> Expr:
    """a.b"""
    return a[0] * b[0] + a[1] * b[1]
