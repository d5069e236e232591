"""The elimination of a planar link whose joints carry rotors, in link frames and free of cancellation (theory, section 5).

A rotor of inertia A_k at joint k takes the couple A_k (alpha_k - alpha_{k-1}). So the chain from joint k on, as link k - 1 sees it,
asks for a force and a moment at the joint that are linear in its acceleration a less gravity and in the turning alpha of link k - 1:

    (f, n) = K (a, alpha) + p,    K = X kappa kappa^T + [0; S],    kappa = (1, z, h),    S = [E F; F G],    delta = det S

with axes along link k, along its tangent, and its angle; X, kappa and S >= 0 stand for K because the entries of K itself cancel where
much heavier links are beyond. With s, c sine and cosine of the joint at the tip of a link, e = s + z c and b = c - z s,

    g = l e + h,   sigma = l c E + F,   rho = l c F + G,   t_n = X g h + rho
    t_x = X g b - s sigma,   t_y = X g e + c sigma,   P = m r^2 + X g^2 + l c sigma + rho,   D = P + A_k

are what one unit of the link's own turning asks for: (t_x, m r + t_y) at its joint, t_n at its tip. With the chain beyond turned into
the frame of the link, T_xx = X b^2 + s^2 E, T_xy = X b e - s c E, T_yy = X e^2 + c^2 E, h_x = X b h - s F, and with

    u = (l + s h, b),   v = (-c h, e),   U_xx = X u.S u + s^2 delta,   U_xy = X v.S u - s c delta,   U_yy = X v.S v + c^2 delta

which are the minors of T bordered by the turning, the link and all beyond it have

    X' = m + (T_xx (m r^2 + A) + U_xx) / D,    X' z' = ((A - m r (l - r)) T_xy - m r h_x + U_xy) / D,    X' h' = A t_x / D
    d = X delta + m (delta + X (u_o.S u_o + v.S v)) + m^2 (X (o e + h)^2 + (o c)^2 E + 2 o c F + G),   o = l - r
    E' = (d + A (m^2 + m (X + X z^2 + E) + X E)) / (D X'),   delta' = A d / (D X')
    F' = A (m (m r + t_y) + m r T_xx + X u.(E, F)) / (D X'),     G' = A (m P + m r^2 T_xx + U_xx) / (D X')

u_o is u with o for l. A rigid link is the point mass m at r that moves like it (`chain.body`); where that may be nowhere m o and m o^2
stand for themselves. Forces and moments p of the chain beyond go over the link by Q, accelerations outwards by its transpose; what
bending C'' and rising (S'' beyond the turning) of the link's direction add to p goes by `axial`, `skew` and `lift_x`, `lift_y`. No
sum has terms that must cancel because masses or rotors differ much:

    Q_xx = (c (m r^2 + A + rho) + X g (l z + c h) + l sigma) / D,     Q_xy = -(s (m r^2 + A + rho) + X g (l + s h)) / D
    Q_y. = (s, c) (A - m r (l - r) + t_n) / D,    Q_.n = -(t_x, m r + t_y) / D,    Q_n. = A (l s, l c, 1) / D
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.body import Bodies
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.planar_links import PlanarLinks
from phichain.scene import Scene

PER_LINK = (
    "q_xx", "q_xy", "q_yx", "q_yy",  # Q between forces
    "gain_x", "gain_y", "inverse",  # -Q_.n, 1 / D
    "share", "slack",  # A / D, P / D
    "axial", "skew",  # what C'' adds to the force
    "lift_x", "lift_y", "lag",  # what the rest of S'' adds to the force, and takes from the turning
    "arm_x", "arm_y",  # l s / D, l c / D
    "pull_x", "pull_y", "pull_n",  # force along the link before for an acceleration of the joint, and for a turning of that link
    "sine", "cosine",  # of the joint at the link's base
)  # fmt: skip
"""What is kept of each link; Q, arms and so on belong to the link and the joint at its tip, pulls to the joint at its base."""

BASE = {"base": 2, "base_arm": 2}
"""What is kept of the base: its acceleration less gravity in the first link's frame, and a cart's mobility and own acceleration."""

Keep = Callable[[str, Index, Expr], None]


@dataclass(frozen=True)
class Beyond:
    """A chain from a joint on, as the link before sees it: X, z, h, E, F, G and delta."""

    inertia: Expr
    skew: Expr
    reach: Expr
    across: Expr
    mixed: Expr
    turning: Expr
    determinant: Expr

    def named(self) -> dict[str, Expr]:
        """Its numbers by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


class Elimination:
    """The elimination from the tip to the base; what the substitutions need is kept by name and link."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, joints: tuple[ArrayRef, ArrayRef], keep: Keep
    ) -> None:
        """Prepare the tables.

        Args:
            builder: where the Program is recorded.
            scene: the chain.
            parameters: its numbers.
            joints: sines and cosines of the joints' angles.
            keep: takes (name, link, value) of `PER_LINK` and `BASE`.
        """
        self.builder, self.scene, self.parameters, self.keep = builder, scene, parameters, keep
        self.sine, self.cosine = joints
        assert parameters.armature is not None
        self.armature = parameters.armature
        links = PlanarLinks(parameters)
        self.mass, self.first, self.own, self.lever = links.mass, links.moment, links.own, links.lever

    def run(self) -> Beyond:
        """Eliminate all links; the chain from the first joint on."""
        links = self.scene.links
        beyond = self.tip(links - 1)
        if links == 1:
            return beyond
        with self.builder.loop("k", links - 2, -1, -1) as loop:
            carried = {name: loop.carry(f"beyond_{name}", value) for name, value in beyond.named().items()}
            after = self.link(Beyond(**carried), loop.index)
            for name, value in after.named().items():
                loop.follow(carried[name], value)
        return Beyond(**carried)

    def tip(self, k: int) -> Beyond:
        """The last link: a point mass and a rotor beyond which there is nothing."""
        let, mass, zero = self.builder.let, self.mass[k], self.builder.lift(0)
        first, own, rotor = self.first[k], self.own[k], self.armature[k]
        inverse = let("inverse_turning", 1 / (own + rotor))
        share = let("share", rotor * inverse)
        kept = {
            "gain_x": zero, "gain_y": first * inverse, "inverse": inverse, "share": share, "slack": own * inverse,
            "axial": first, "skew": zero, "lift_x": zero, "lift_y": first, "lag": zero,
            "sine": self.sine[k], "cosine": self.cosine[k],
        }  # fmt: skip
        for name in PER_LINK:
            if not name.startswith("pull"):
                self.keep(name, k, kept.get(name, zero))
        return Beyond(mass, zero, zero, share * mass, share * first, share * own, zero)

    def link(self, beyond: Beyond, k: Index) -> Beyond:
        """Eliminate the turning of link k; the chain from its joint on."""
        let, parameters = self.builder.let, self.parameters
        mass, length, rotor = self.mass[k], parameters.length[k], self.armature[k]
        first, own, lever = self.first[k], self.own[k], self.lever[k]
        s, c, seen = self.sine[k + 1], self.cosine[k + 1], self._seen(beyond, k + 1)
        reach = let("reach", length * seen.across + beyond.reach)
        pull = let("pull_of_turning", beyond.inertia * reach)
        arm = let("arm", length * c)
        sigma = let("sigma", arm * beyond.across + beyond.mixed)
        rho = let("rho", arm * beyond.mixed + beyond.turning)
        t_x = let("turning_x", pull * seen.along - s * sigma)
        t_y = let("turning_y", pull * seen.across + c * sigma)
        t_n = let("turning_moment", pull * beyond.reach + rho)
        pivot = let("pivot", own + (pull * reach + (arm * sigma + rho)))
        inverse = let("inverse_turning", 1 / (pivot + rotor))
        held = let("own_with_rotor", own + rotor)
        forward = length + s * beyond.reach, seen.along
        sideways = -(c * beyond.reach), seen.across
        bent = self._product("bent", beyond, forward)
        minor_xx = let("minor_xx", beyond.inertia * _dot(forward, bent) + s * s * beyond.determinant)
        minor_xy = let("minor_xy", beyond.inertia * _dot(sideways, bent) - s * c * beyond.determinant)
        aside = let("sideways", _dot(sideways, self._product("leaned", beyond, sideways)))
        minor_yy = beyond.inertia * aside + c * c * beyond.determinant
        shift = let("shift", (seen.xx * held + minor_xx) * inverse)
        skew = let("link_skew", ((rotor - lever) * seen.xy + (minor_xy - first * seen.moment)) * inverse)
        inwards = let("inwards", (rotor - lever + t_n) * inverse)
        share = let("share", rotor * inverse)
        gain_y = let("side", first + t_y)
        for name, value in (
            ("q_xx", (c * (held + rho) + (pull * (length * beyond.skew + c * beyond.reach) + length * sigma)) * inverse),
            ("q_xy", -((s * (held + rho) + pull * forward[0]) * inverse)),
            ("q_yx", s * inwards), ("q_yy", c * inwards), ("gain_x", t_x * inverse), ("gain_y", gain_y * inverse),
            ("inverse", inverse), ("share", share), ("slack", pivot * inverse),
            ("axial", first + length * shift), ("skew", length * skew),
            ("lift_x", length * ((seen.xy * held + minor_xy) * inverse)),
            ("lift_y", ((first + length * seen.yy) * held + (first * t_n + length * minor_yy)) * inverse),
            ("lag", length * t_y * inverse), ("arm_x", length * s * inverse), ("arm_y", arm * inverse),
            ("sine", self.sine[k]), ("cosine", self.cosine[k]),
        ):  # fmt: skip
            self.keep(name, k, value)
        inertia = let("held_inertia", mass + shift)
        over = let("over_held_inertia", 1 / inertia)
        whole = let("whole", self._whole(beyond, seen, k, aside))
        sides = mass * (beyond.inertia + beyond.inertia * (beyond.skew * beyond.skew) + beyond.across)
        freed = let("freed", mass * mass + sides + beyond.inertia * beyond.across)
        shared = let("shared", share * over)
        return Beyond(
            inertia=inertia, skew=let("held_skew", skew * over), reach=let("held_reach", shared * t_x),
            across=let("held_across", (whole + rotor * freed) * (inverse * over)),
            mixed=let("held_mixed", shared * (mass * gain_y + (first * seen.xx + beyond.inertia * bent[0]))),
            turning=let("held_turning", shared * (mass * pivot + (own * seen.xx + minor_xx))),
            determinant=let("held_determinant", shared * whole),
        )  # fmt: skip

    def base(self, beyond: Beyond, fall: Sequence[Expr]) -> None:
        """Gravity and, on a cart, its mobility.

        Args:
            beyond: the chain from the first joint on.
            fall: what all falls with, aside and down: gravity, seen from a base at rest. Aside is nothing where a cart is free.
        """
        aside, weight = -fall[0], -fall[1]
        s, c = self.sine[0], self.cosine[0]
        if not self.scene.has_free_cart:
            self.keep("base", 0, weight * c + aside * s)
            self.keep("base", 1, aside * c - weight * s)
            for name in ("pull_x", "pull_y", "pull_n"):
                self.keep(name, 0, self.builder.lift(0))
            return
        mass, seen = self.parameters.base_mass, self._seen(beyond, 0)
        inverse = self.builder.let("mobility", 1 / (mass + seen.yy))
        scaled = weight * inverse
        across = beyond.inertia * seen.across
        self.keep("base", 0, scaled * (mass * c + (across * beyond.skew + c * beyond.across)))
        self.keep("base", 1, -(scaled * (mass * s + across)))
        self.keep("base_arm", 0, inverse)
        self.keep("base_arm", 1, -(scaled * seen.xy))

    def _seen(self, beyond: Beyond, k: Index) -> _Seen:
        """The chain from joint k on, in the frame of the link before."""
        let, s, c = self.builder.let, self.sine[k], self.cosine[k]
        across, along = let("across", s + beyond.skew * c), let("along", c - beyond.skew * s)
        pull, rest_s = let("pull_along", beyond.inertia * along), let("rest_s", s * beyond.across)
        moment = let("seen_moment", pull * beyond.reach - s * beyond.mixed)
        self.keep("pull_x", k, pull)
        self.keep("pull_y", k, pull * beyond.skew - rest_s)
        self.keep("pull_n", k, moment)
        return _Seen(
            across=across, along=along, xx=let("seen_xx", pull * along + s * rest_s),
            xy=let("seen_xy", pull * across - c * rest_s),
            yy=let("seen_yy", beyond.inertia * (across * across) + c * c * beyond.across), moment=moment,
        )  # fmt: skip

    def _product(self, name: str, beyond: Beyond, pair: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
        """S times two numbers."""
        let = self.builder.let
        return (
            let(f"{name}_across", beyond.across * pair[0] + beyond.mixed * pair[1]),
            let(f"{name}_turning", beyond.mixed * pair[0] + beyond.turning * pair[1]),
        )

    def _whole(self, beyond: Beyond, seen: _Seen, k: Index, aside: Expr) -> Expr:
        """d, the determinant of the link and all beyond it before its joint yields."""
        mass, delta, bodies = self.mass[k], beyond.determinant, self.parameters.bodies
        s, c = self.sine[k + 1], self.cosine[k + 1]
        if bodies is not None:
            return self._whole_of_bodies(bodies, beyond, seen, k, aside)
        overhang = self.builder.lift(0)
        if not self.scene.tip_masses:
            length, com = self.parameters.length, self.parameters.com
            overhang = self.parameters.derived("length_beyond", lambda k: length[k] - com[k])[k]
        lean = overhang + s * beyond.reach, seen.along
        forward = _dot(lean, self._product("swung", beyond, lean))
        reach, arm = overhang * seen.across + beyond.reach, overhang * c
        swung = beyond.inertia * (reach * reach) + arm * (arm * beyond.across + (beyond.mixed + beyond.mixed)) + beyond.turning
        return beyond.inertia * delta + mass * (delta + beyond.inertia * (forward + aside) + mass * swung)


    def _whole_of_bodies(self, bodies: Bodies, beyond: Beyond, seen: _Seen, k: Index, aside: Expr) -> Expr:
        """The same with m o and m o^2 of points that may be nowhere."""
        mass, delta, s, c = self.mass[k], beyond.determinant, self.sine[k + 1], self.cosine[k + 1]
        once, twice = bodies.first[k] * (bodies.lever[k] * bodies.over_second[k]), bodies.beyond[k]
        lean = s * beyond.reach, seen.along
        swung = self._product("swung", beyond, lean)
        forward = twice * beyond.across + (2 * once) * swung[0] + mass * _dot(lean, swung)
        reach = seen.across * (twice * seen.across + (2 * once) * beyond.reach) + mass * (beyond.reach * beyond.reach)
        still = c * (c * (twice * beyond.across) + (2 * once) * beyond.mixed) + mass * beyond.turning
        held = beyond.inertia * (forward + mass * aside) + mass * (beyond.inertia * reach + still)
        return beyond.inertia * delta + mass * delta + held


@dataclass(frozen=True)
class _Seen:
    """A chain beyond a joint in the frame of the link before: e, b, T and h_x."""

    across: Expr
    along: Expr
    xx: Expr
    xy: Expr
    yy: Expr
    moment: Expr


def _dot(a: tuple[Expr, Expr], b: tuple[Expr, Expr]) -> Expr:
    return a[0] * b[0] + a[1] * b[1]


def layout_of(scene: Scene) -> Iterable[tuple[str, int]]:
    """Names and numbers of cells of what is kept."""
    yield from ((name, scene.links) for name in PER_LINK)
    yield "base", BASE["base"]
    if scene.has_free_cart:
        yield "base_arm", BASE["base_arm"]


def kept_in(arrays: Mapping[str, ArrayRef]) -> Keep:
    """A `Keep` into arrays; what has none is dropped."""

    def keep(name: str, k: Index, value: Expr) -> None:
        if name in arrays:
            arrays[name][k] = value

    return keep
