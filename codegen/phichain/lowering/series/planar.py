"""Taylor recurrences of planar chains: link frames at rest in the directions that the links have at the step's start.

With psi the angle of a link counted from its direction there, C and S its cosine and sine, w its rate, (a_x, a_y) the
acceleration of its joint less gravity, A = [X Z; Z Y] and p the articulated inertia and force of the chain beyond, all in
scaled time, the coefficients of order n obey

    S''_n = (n + 1) (w_{n+1} + sum_{j=0..n} C_{j+1} w_{n-j}),        C''_n = -(n + 1) sum_{j=0..n} S_{j+1} w_{n-j}
    Hy_n + sum_{j=0..n-1} (C_{j+1} Hy_{n-1-j} - S_{j+1} Hx_{n-1-j}) = tau_n,      H = m r (a + r (C'', S'')) + l F

F the force at the link's tip. That is the sweep of `lowering.planar.articulated` with C''_n for -w^2 and constant matrices: with
s, c sine and cosine of the joint's angle, X, Z, E = X Y - Z^2 of the chain beyond in its own frame, e = X s + Z c,

    D = m r^2 + l^2 A_yy,   A_yy = (e^2 + c^2 E) / X,   kappa = m r (l - r) / D,   U_x = l A_xy,   U_y = m r + l A_yy
    Q = [(c m r^2 + l^2 (e Z + c E) / X) / D, -(s m r^2 + l^2 e) / D; -kappa s, -kappa c]
    p' = Q p + (m r + l (X' - m), -kappa U_x) C''_n + (U_x, U_y) y / D,                  y = tau_n - (the sum above)
    a_beyond = Q^T (a + (l C''_n, 0)) + l z (s, c),    z = (y - l (s p_x + c p_y)) / D,   S''_n = z - (l U_x C''_n + U.a) / D

Q holds what turning and eliminating do to a force, multiplied out so that nothing cancels (docs/theory.md). A cart is the
same with m r^2 -> m_c, l -> 1 and the vertical for the link's direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.parameters import Parameters
from phichain.lowering.planar.joints import absolute, difference, input_couples
from phichain.lowering.series.series import COEFFICIENT, HELD, LEAD, LEFT, NEXT, NOW, RIGHT, SCALE, SUMS, Series
from phichain.mechanics import Model
from phichain.scene import Scene

_PER_LINK = (
    "q_xx", "q_xy", "q_yx", "q_yy",  # Q
    "axial", "skew",  # what C'' adds to p'
    "gain_x", "gain_y",  # U / D
    "inverse", "arm_x", "arm_y",  # 1 / D, l s / D, l c / D
    "xx", "xy", "yy",  # inertia of the link and all beyond, in its own frame
    "sine", "cosine",  # of the joint at the link's base
)  # fmt: skip
"""What is kept of each link; Q, arms and so on belong to the link and the joint at its tip."""


@dataclass(frozen=True)
class _Inertia:
    """A chain from a joint on, in the frame of its first link: A = [xx xy; xy yy], E = det A; all zero beyond the tip."""

    xx: Expr
    xy: Expr
    yy: Expr
    determinant: Expr


@dataclass(frozen=True)
class _Turned:
    """The same seen along and across another direction: the joint's tangent and axis in the first link's frame."""

    across: Expr  # e = X s + Z c
    mixed: Expr  # c Y + s Z
    xx: Expr
    xy: Expr
    yy: Expr


class _Layout:
    """Where each number sits in `held`; what a scene does not need has no place."""

    def __init__(self, scene: Scene) -> None:
        links = scene.links
        names = [name for name in _PER_LINK if not (scene.tip_masses and name in ("q_yx", "q_yy", "skew", "xy", "yy"))]
        self.offsets = {name: links * i for i, name in enumerate(names)}
        self.size = links * len(names)
        for name, present, count in (
            ("base", True, 2), ("base_arm", scene.has_cart, 2), ("drive", bool(scene.actuated_joints), links),
            ("push", scene.has_force, 1), ("stiffness", scene.stiffness is not None, links),
            ("damping", scene.damping is not None, links),
        ):  # fmt: skip
            if present:
                self.offsets[name] = self.size
                self.size += count

    def of(self, held: ArrayRef, name: str) -> ArrayRef | None:
        """Where a quantity's numbers begin, or None."""
        return held.shifted(self.offsets[name]) if name in self.offsets else None


def planar_series(model: Model) -> Series:
    """The recurrences of a planar scene."""
    scene, layout = model.scene, _Layout(model.scene)
    return Series(
        factor=_factor(model, layout),
        order=_order(model, layout),
        columns=_columns(scene, layout) if scene.variational else None,
        lanes=2 * scene.links,
        rights=2,
        squares=0,
        held=layout.size,
    )


def _factor(model: Model, layout: _Layout) -> Program:
    """Everything that is constant over a step, and rows 0."""
    scene = model.scene
    builder = Builder("flow_factor", "Factor the mass matrix at the start of a step.")
    parameters = Parameters(builder, model, own_units=True)
    q, v = builder.input("q", (scene.nq,), "configuration"), builder.input("v", (scene.nv,), "rates in scaled time")
    u = builder.input("u", (scene.nu,), "inputs") if scene.nu else None
    scale = builder.input(SCALE, (2,), "unit of time and its square")
    held = builder.output(HELD, (layout.size,), "constants of the step")
    left = builder.output(LEFT, (2 * scene.links,), "coefficients 1 of the links' cosines and sines")
    right = builder.output(RIGHT, (4 * scene.links,), "the links' rates, twice, and zeros")
    _Factor(builder, scene, parameters, layout, held, scale).write(q, u)
    rate = absolute(builder, scene, "rate", v.shifted(int(scene.has_cart)))
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        left[k], left[k + scene.links] = builder.lift(0), rate[k]
        right[k], right[k + scene.links] = rate[k], rate[k]
        right[k + 2 * scene.links], right[k + 3 * scene.links] = builder.lift(0), builder.lift(0)
    return prune(builder.finish())


class _Factor:
    """The elimination from the tip to the base."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, layout: _Layout, held: ArrayRef, scale: ArrayRef
    ) -> None:
        self.builder, self.scene, self.parameters, self.layout = builder, scene, parameters, layout
        self.held, self.rho, self.square = held, scale[0], scale[1]

    def keep(self, name: str, k: Index, value: Expr) -> None:
        """Store a number of link k where the scene has a place for it."""
        cells = self.layout.of(self.held, name)
        if cells is not None:
            cells[k] = value

    def write(self, q: ArrayRef, u: ArrayRef | None) -> None:
        """All numbers of `held`."""
        builder, scene, links = self.builder, self.scene, self.scene.links
        angle = difference(builder, scene, "joint_angle", q.shifted(int(scene.has_cart)))
        self.sine, self.cosine = builder.sincos(angle, links)
        inertia = self.tip(links - 1)
        if links > 1:
            with builder.loop("k", links - 2, -1, -1) as loop:
                parts = {"xx": inertia.xx, "xy": inertia.xy, "determinant": inertia.determinant}
                moving = {"xx"} if scene.tip_masses else set(parts)
                carried = {name: loop.carry(f"beyond_{name}", parts[name]) for name in parts if name in moving}
                known = {name: carried.get(name, value) for name, value in parts.items()}
                after = self.link(_Inertia(**known, yy=builder.lift(0)), loop.index)
                for name, value in carried.items():
                    loop.follow(value, getattr(after, name))
            inertia = _Inertia(**known, yy=builder.lift(0))
        self.base(inertia)
        self.inputs(u)

    def turned(self, beyond: _Inertia, k: Index) -> _Turned:
        """The chain from joint k on, in the frame of the link before."""
        let, s, c = self.builder.let, self.sine[k], self.cosine[k]
        if self.scene.tip_masses:
            across, along = let("across", beyond.xx * s), let("along", beyond.xx * c)
            return _Turned(across, self.builder.lift(0), along * c, along * s, across * s)
        inverse = let("inverse_axial", 1 / beyond.xx)
        across, along = let("across", beyond.xx * s + beyond.xy * c), let("along", beyond.xx * c - beyond.xy * s)
        rest_s, rest_c = let("rest_s", s * beyond.determinant), let("rest_c", c * beyond.determinant)
        return _Turned(
            across=across,
            mixed=let("mixed", (across * beyond.xy + rest_c) * inverse),
            xx=let("turned_xx", (along * along + s * rest_s) * inverse),
            xy=let("turned_xy", (across * along - s * rest_c) * inverse),
            yy=let("turned_yy", (across * across + c * rest_c) * inverse),
        )

    def tip(self, k: Index) -> _Inertia:
        """The last link: a point mass beyond which there is nothing."""
        mass, com, zero = self.parameters.mass[k], self.parameters.com[k], self.builder.lift(0)
        self.keep("sine", k, self.sine[k])
        self.keep("cosine", k, self.cosine[k])
        self.keep("inverse", k, 1 / (mass * com * com))
        self.keep("axial", k, mass * com)
        self.keep("gain_y", k, 1 / com)
        self.keep("xx", k, mass)
        for name in ("skew", "gain_x", "xy", "yy", "q_xx", "q_xy", "q_yx", "q_yy", "arm_x", "arm_y"):
            self.keep(name, k, zero)
        return _Inertia(mass, zero, zero, zero)

    def link(self, beyond: _Inertia, k: Index) -> _Inertia:
        """Eliminate the rotation of link k; the chain from its joint on."""
        let, parameters, scene = self.builder.let, self.parameters, self.scene
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        s, c, outer = self.sine[k + 1], self.cosine[k + 1], self.turned(beyond, k + 1)
        own = self.number("own_inertia", lambda k: parameters.mass[k] * parameters.com[k] * parameters.com[k])[k]
        moment = self.number("moment", lambda k: parameters.mass[k] * parameters.com[k])[k]
        square = self.number("length_square", lambda k: parameters.length[k] * parameters.length[k])[k]
        inverse = let("inverse_pivot", 1 / (own + square * outer.yy))
        shift = let("shift", (own * outer.xx + square * beyond.determinant) * inverse)
        gain_x = let("gain_x", length * outer.xy * inverse)
        for name, value in (
            ("q_xx", (own * c + square * outer.mixed) * inverse),
            ("q_xy", -((own * s + square * outer.across) * inverse)),
            ("axial", moment + length * shift), ("gain_x", gain_x), ("gain_y", (moment + length * outer.yy) * inverse),
            ("inverse", inverse), ("arm_x", length * s * inverse), ("arm_y", length * c * inverse),
            ("sine", self.sine[k]), ("cosine", self.cosine[k]),
        ):  # fmt: skip
            self.keep(name, k, value)
        xx = let("link_xx", mass + shift)
        self.keep("xx", k, xx)
        if scene.tip_masses:
            zero = self.builder.lift(0)
            return _Inertia(xx, zero, zero, zero)
        lever = self.number("lever", lambda k: moment_of(parameters, k) * (parameters.length[k] - parameters.com[k]))[k]
        kappa = let("kappa", lever * inverse)
        overhang = self.number("overhang", lambda k: (parameters.length[k] - parameters.com[k]) / parameters.com[k])[k]
        xy, yy = let("link_xy", -(kappa * outer.xy)), let("link_yy", kappa * (overhang * outer.yy))
        self.keep("q_yx", k, -(kappa * s))
        self.keep("q_yy", k, -(kappa * c))
        self.keep("skew", k, kappa * (length * outer.xy))
        self.keep("xy", k, xy)
        self.keep("yy", k, yy)
        determinant = kappa * (overhang * (mass * outer.yy + beyond.determinant))
        return _Inertia(xx, xy, yy, let("link_determinant", determinant))

    def number(self, name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        """A table of per-link numbers."""
        return self.parameters.derived(name, entry)

    def base(self, inertia: _Inertia) -> None:
        """Gravity and, on a cart, its mobility."""
        weight = -(self.square * self.parameters.gravity)
        s, c = self.sine[0], self.cosine[0]
        if not self.scene.has_cart:
            self.keep("base", 0, weight * c)
            self.keep("base", 1, -(weight * s))
            return
        mass, outer = self.parameters.cart_mass, self.turned(inertia, 0)
        inverse = self.builder.let("mobility", 1 / (mass + outer.yy))
        scaled = weight * inverse
        self.keep("base", 0, scaled * (mass * c + outer.mixed))
        self.keep("base", 1, -(scaled * (mass * s + outer.across)))
        self.keep("base_arm", 0, inverse)
        self.keep("base_arm", 1, -(scaled * outer.xy))

    def inputs(self, u: ArrayRef | None) -> None:
        """Inputs, springs and dampers in scaled time."""
        builder, scene, parameters = self.builder, self.scene, self.parameters
        if scene.has_force and u is not None:
            self.keep("push", 0, self.square * (u[0] / parameters.units.force))
        couple = input_couples(builder, scene, parameters, u)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            if couple is not None:
                self.keep("drive", k, self.square * couple[k])
            if parameters.stiffness is not None:
                self.keep("stiffness", k, self.square * parameters.stiffness[k])
            if parameters.damping is not None:
                self.keep("damping", k, self.rho * parameters.damping[k])


def moment_of(parameters: Parameters, k: Index) -> Expr:
    """m_k r_k."""
    return parameters.mass[k] * parameters.com[k]


def _order(model: Model, layout: _Layout) -> Program:
    """Solve for the coefficients of order n + 1."""
    scene = model.scene
    builder = Builder("flow_order", "Solve for the coefficients of order n + 1 of the Taylor series.")
    parameters = Parameters(builder, model, own_units=True)
    held = builder.input(HELD, (layout.size,), "constants of the step")
    sums = builder.input(SUMS, (4 * scene.links,), "sums of products of known coefficients")
    coefficient = builder.input(COEFFICIENT, (scene.nq + scene.nv,), "coefficients of order n of the state")
    now = builder.input(NOW, (4,), "n + 1, 1 / (n + 1), 1 / ((n + 1) (n + 2)), and whether n = 0")
    left = builder.output(LEFT, (2 * scene.links,), "coefficients n + 2 of the links' cosines and sines")
    right = builder.output(RIGHT, (4 * scene.links,), "the links' rates, twice, and moments of force")
    following = builder.output(NEXT, (scene.nq + scene.nv,), "coefficients of order n + 1 of the state")
    _Order(builder, scene, parameters, layout, held, now).write(sums, coefficient, left, right, following)
    return prune(builder.finish())


class _Order:
    """The back substitution: beside the chain first, along it inwards, beside it, outwards, and beside it again."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, layout: _Layout, held: ArrayRef, now: ArrayRef
    ) -> None:
        self.builder, self.scene, self.parameters, self.layout, self.now = builder, scene, parameters, layout, now
        self.held = held

    def of(self, name: str) -> ArrayRef:
        """Where a quantity's numbers begin; zero everywhere where the scene has none."""
        cells = self.layout.of(self.held, name)
        return cells if cells is not None else self.builder.constants(name, [Fraction(0)] * self.scene.links)

    def write(self, sums: ArrayRef, coefficient: ArrayRef, left: ArrayRef, right: ArrayRef, following: ArrayRef) -> None:
        """All cells of the results."""
        builder, scene, links, now = self.builder, self.scene, self.scene.links, self.now
        length, com = self.parameters.length, self.parameters.com
        names = ("bend", "torque", "push_x", "push_y", "force_x", "force_y", "free", "joint_x", "joint_y", "turn")
        work = {name: builder.array(name, links) for name in names}
        couple = self.couple(coefficient)
        bend, torque, joint_x, joint_y = work["bend"], work["torque"], work["joint_x"], work["joint_y"]
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            bend[k] = bent = -(now[0] * sums[k + links])
            known = sums[k + 2 * links] + sums[k + 3 * links]
            torque[k] = moment = builder.let("moment", -known if couple is None else couple[k] - known)
            work["push_x"][k] = self.of("axial")[k] * bent + self.of("gain_x")[k] * moment
            work["push_y"][k] = self.of("gain_y")[k] * moment - self.of("skew")[k] * bent
        self.inwards(work)
        self.outwards(work, following)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            swing = builder.let(
                "swing", work["free"][k] - self.of("gain_x")[k] * joint_x[k] - self.of("gain_y")[k] * joint_y[k]
            )
            work["turn"][k] = rate = builder.let("rate", now[1] * swing - sums[k])
            left[k], left[k + links] = now[2] * bend[k], now[2] * swing
            right[k], right[k + links], right[k + 2 * links] = rate, rate, torque[k]
        moment_of_mass = self.parameters.derived("moment", lambda k: moment_of(self.parameters, k))

        def radial(k: Index) -> Expr:
            """Acceleration of the joint of link k along the link, and with `com` of its mass."""
            return joint_x[k] - length[k] * bend[k]

        for start, stop, is_tip in ((0, links - 1, False), (links - 1, links, True)):
            if start == stop:
                continue
            with builder.loop("k", start, stop) as loop:
                k = loop.index
                own = moment_of_mass[k] * (radial(k) + com[k] * bend[k] if not scene.tip_masses else joint_x[k])
                if not is_tip:
                    own = own + length[k] * self.tip_force(work, radial(k + 1), k + 1)
                right[k + 3 * links] = -own
        self.state(coefficient, work["turn"], following)

    def tip_force(self, work: dict[str, ArrayRef], joint_x: Expr, k: Index) -> Expr:
        """The force at joint k along the link before."""
        joint_y = work["joint_y"][k]
        force_x = self.of("xx")[k] * joint_x + self.of("xy")[k] * joint_y + work["force_x"][k]
        force_y = self.of("xy")[k] * joint_x + self.of("yy")[k] * joint_y + work["force_y"][k]
        return self.of("cosine")[k] * force_x - self.of("sine")[k] * force_y

    def couple(self, coefficient: ArrayRef) -> ArrayRef | None:
        """Torques on the links of order n: inputs, springs and dampers; None where there are none."""
        builder, scene, links = self.builder, self.scene, self.scene.links
        stiffness, damping, drive = (self.layout.of(self.held, name) for name in ("stiffness", "damping", "drive"))
        if stiffness is None and damping is None and drive is None:
            return None
        angles, rates = coefficient.shifted(int(scene.has_cart)), coefficient.shifted(scene.nq + int(scene.has_cart))
        pull = builder.array("pull", links)
        angle = difference(builder, scene, "joint_angle", angles) if stiffness is not None else angles
        rate = difference(builder, scene, "joint_rate", rates) if damping is not None else rates
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            total = builder.lift(0)
            if stiffness is not None:
                total = total - stiffness[k] * angle[k]
            if damping is not None:
                total = total - damping[k] * rate[k]
            pull[k] = total
        couple = builder.array("couple", links)

        def on(k: Index, beyond: Expr) -> Expr:
            total = pull[k] - beyond
            return total if drive is None else total + self.now[3] * drive[k]

        with builder.loop("k", 0, links - 1) as loop:
            couple[loop.index] = on(loop.index, pull[loop.index + 1])
        couple[links - 1] = on(links - 1, builder.lift(0))
        return couple

    def inwards(self, work: dict[str, ArrayRef]) -> None:
        """Forces of order n that the chain beyond each joint asks for, and the links' free angular accelerations."""
        builder, links = self.builder, self.scene.links
        force_x, force_y, push_x, push_y = (work[name] for name in ("force_x", "force_y", "push_x", "push_y"))
        first, last = (0 if self.scene.has_cart else 1), links - 1
        force_x[last], force_y[last] = push_x[last], push_y[last]
        if last > first - 1 and last - 1 >= first:
            with builder.loop("k", last - 1, first - 1, -1) as loop:
                k = loop.index
                x, y = loop.carry("carried_x", push_x[last]), loop.carry("carried_y", push_y[last])
                inner_x = (push_x[k] + self.of("q_xx")[k] * x) + self.of("q_xy")[k] * y
                inner_y = (push_y[k] + self.of("q_yx")[k] * x) + self.of("q_yy")[k] * y
                force_x[k], force_y[k] = inner_x, inner_y
                loop.follow(x, inner_x)
                loop.follow(y, inner_y)
        free, torque = work["free"], work["torque"]
        with builder.loop("k", 0, last) as loop:
            k = loop.index
            arms = self.of("arm_x")[k] * force_x[k + 1] + self.of("arm_y")[k] * force_y[k + 1]
            free[k] = self.of("inverse")[k] * torque[k] - arms
        free[last] = self.of("inverse")[last] * torque[last]

    def outwards(self, work: dict[str, ArrayRef], following: ArrayRef) -> None:
        """Accelerations of the joints in the links' frames; joint_x holds l C'' as well."""
        builder, links, length = self.builder, self.scene.links, self.parameters.length
        joint_x, joint_y, bend, free = (work[name] for name in ("joint_x", "joint_y", "bend", "free"))
        base_x, base_y = self.base(work, following)
        lift_x, lift_y = builder.array("lift_x", links), builder.array("lift_y", links)
        with builder.loop("k", 0, links - 1) as loop:
            k = loop.index
            tip = length[k] * free[k]
            lift_x[k] = self.of("sine")[k + 1] * tip + length[k + 1] * bend[k + 1]
            lift_y[k] = self.of("cosine")[k + 1] * tip
        start = base_x + length[0] * bend[0]
        joint_x[0], joint_y[0] = start, base_y
        if links == 1:
            return
        with builder.loop("k", 0, links - 1) as loop:
            k = loop.index
            x, y = loop.carry("carried_x", start), loop.carry("carried_y", base_y)
            outer_x = (lift_x[k] + self.of("q_yx")[k] * y) + self.of("q_xx")[k] * x
            outer_y = (lift_y[k] + self.of("q_yy")[k] * y) + self.of("q_xy")[k] * x
            joint_x[k + 1], joint_y[k + 1] = outer_x, outer_y
            loop.follow(x, outer_x)
            loop.follow(y, outer_y)

    def base(self, work: dict[str, ArrayRef], following: ArrayRef) -> tuple[Expr, Expr]:
        """Acceleration of the base less gravity in the first link's frame; a cart's goes into the results."""
        scene, now, base = self.scene, self.now, self.of("base")
        weight_x, weight_y = now[3] * base[0], now[3] * base[1]
        if not scene.has_cart:
            return weight_x, weight_y
        sine, cosine, arm = self.of("sine")[0], self.of("cosine")[0], self.of("base_arm")
        push = -(sine * work["force_x"][0] + cosine * work["force_y"][0])
        if scene.has_force:
            push = now[3] * self.of("push")[0] + push
        free = self.builder.let("cart_free", arm[0] * push)
        acceleration = now[1] * (free + now[3] * arm[1])
        following[scene.nq] = acceleration * self.parameters.units.length
        return weight_x + sine * free, weight_y + cosine * free

    def state(self, coefficient: ArrayRef, rate: ArrayRef, following: ArrayRef) -> None:
        """The state's coefficients of order n + 1."""
        builder, scene = self.builder, self.scene
        with builder.loop("i", 0, scene.nq) as loop:
            following[loop.index] = self.now[1] * coefficient[loop.index + scene.nq]
        own = from_links(builder, scene, "own_rate", rate)
        with builder.loop("k", 0, scene.links) as loop:
            following[loop.index + scene.nq + int(scene.has_cart)] = own[loop.index]


def from_links(builder: Builder, scene: Scene, name: str, rate: ArrayRef) -> ArrayRef:
    """theta' = S^-1 phi'."""
    if scene.angles == "absolute":
        return rate
    own = builder.array(name, scene.links)
    own[0] = rate[0]
    with builder.loop("k", 1, scene.links) as loop:
        if scene.angles == "relative":
            own[loop.index] = rate[loop.index] - rate[loop.index - 1]
            return own
        before = loop.carry("before", rate[0])
        value = rate[loop.index] - before
        own[loop.index] = value
        loop.follow(before, value)
    return own


def _columns(scene: Scene, layout: _Layout) -> Program:
    """Variations of rows 0: psi_k varies with the link's angle, and its cosine and sine of order 0 with it."""
    links, offset = scene.links, int(scene.has_cart)
    builder = Builder("flow_columns", "Derivatives of rows 0 along a variation of the state.")
    right = builder.input(RIGHT, (4 * links,), "the links' rates")
    dq, dv = builder.input("dq", (scene.nq,), "variation"), builder.input("dv", (scene.nv,), "variation, scaled time")
    lead = builder.output(LEAD, (2 * links,), "of the links' cosines and sines themselves")
    d_left = builder.output(f"d_{LEFT}", (2 * links,), "of row 0")
    d_right = builder.output(f"d_{RIGHT}", (4 * links,), "of row 0")
    angle = absolute(builder, scene, "angle", dq.shifted(offset))
    rate = absolute(builder, scene, "rate", dv.shifted(offset))
    zero = builder.lift(0)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        lead[k], lead[k + links] = zero, angle[k]
        d_left[k], d_left[k + links] = -(angle[k] * right[k]), rate[k]
        d_right[k], d_right[k + links] = rate[k], rate[k]
        d_right[k + 2 * links], d_right[k + 3 * links] = zero, zero
    return prune(builder.finish())
