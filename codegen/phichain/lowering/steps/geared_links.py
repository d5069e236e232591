"""The system of `link_multipliers` in the plane, where rotors at the joints resist that links turn against each other.

Link k's vector is accelerated by q'' = c + beta n, with n = (cos, -sin) of its normal and c = along normal / |normal|^2, and rotor k takes
the couple A_k (beta_k + e_k - beta_{k-1} - e_{k-1}): what rotors see of a step is the angle that a link turns by, which is more by e than
its vector says. The chain beyond a joint asks there for the force and moment K (a, beta_before) + p, with a the joint's acceleration less
gravity and beta_before that of the link before. In the frame of link k, x along q_k and y along its tangent t_k,

    H = L (K + own) R,   D = H_33 + A,   K' = [(H_ij H_33 - H_i3 H_3j + A H_ij) / D,  A H_i3 / D;  A H_3j / D,  A H_33 / D]

carries everything that is at the joint to (a, beta): L by t, R by n, which differ where the step ends elsewhere than it begins. H is no
symmetric matrix, but one with adjugate and determinant carried along (`algebra.compound`), of which K' takes the numerators.
With o = l - r, P = p - m o c and s = p_3 - (tau - (m o^2 + J) c_y), what does not hang on a is

    p'_x = P_x - H_13 (l P_y + s + A e) / D,   p'_y = (P_y (A + H_33 - l H_23) - H_23 (s + A e)) / D,   p'_3 = A (l P_y + s - H_33 e) / D

for a taken at the end of l c, so that K' l c comes to it, e short for e_k - e_{k-1}; outwards

    beta = (A (beta_before - e) - l P_y - s - (H_31, H_32).(a + l c)) / D.

*Proof.* The row of link k is t.(first moment a + second moment q'' + l f) + n_3 + A (beta + e - beta_before) = tau with the force and
moment f, n_3 of the chain beyond at a + l q'', beta. In a + l c the link's own mass is o c behind: -m o c is its force and
(J - m r o) c_y its moment, which is l (-m o c_y) + (m o^2 + J) c_y. Elimination of beta leaves minors of the bordered matrix. ∎
H_33 - l H_23 = K_33 + l (K_31, K_32).n - (m r o - J) n_y holds none of the forces beyond.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import Expr, Index
from phichain.lowering.algebra.compound import Compound
from phichain.lowering.algebra.vector import Vector, add, dot, load, multiple, named, store, sub
from phichain.lowering.steps.ambient import tangent
from phichain.lowering.steps.articulated_links import moved_base
from phichain.lowering.steps.link_multipliers import Links

_NAMES = (
    *(f"beyond_{i}{j}" for i in "xyz" for j in "xyz"), *(f"adjugate_{i}{j}" for i in "xyz" for j in "xyz"), "determinant",
)  # fmt: skip


def geared_sweep(links: Links) -> None:
    """Accelerations of a planar chain whose joints carry rotors."""
    _Geared(links).run()


@dataclass(frozen=True)
class _Seen:
    """A link in its own frame: c, n, and sine and cosine of its angle against the one before."""

    held: Vector
    column: Vector
    sine: Expr
    cosine: Expr


class _Geared:
    """The sweep, both ways."""

    def __init__(self, links: Links) -> None:
        self.links, self.builder, self.count = links, links.builder, links.scene.links
        sizes = {"held": 2, "column": 2, "row": 2, "turned_from": 2, "loose": 1, "share": 1, "inverse": 1}
        self.kept = {name: self.builder.array(f"{name}_of", size * self.count) for name, size in sizes.items()}

    def run(self) -> None:
        """Inwards, at the base, outwards."""
        builder = self.builder
        self._frames()
        with builder.loop("k", self.count - 1, -1, -1) as loop:
            carried = Compound.from_flat([loop.carry(name, 0) for name in _NAMES])
            asked = tuple(loop.carry(f"asked_{axis}", 0) for axis in "xyz")
            following, force = self._inwards(loop.index, carried, asked)
            for before, after in zip([*carried.flat(), *asked], [*following.flat(), *force], strict=True):
                loop.follow(before, after)
        (down, across), (mixed, sideways) = (row[:2] for row in carried.matrix[:2])
        seen_from_base = ((sideways, mixed), (across, down)), (asked[1], asked[0])
        base = moved_base(self.links, *seen_from_base, self.links.parameters.cart_mass)
        self._outwards((base[1], base[0]))

    def _frames(self) -> None:
        """c, n and the joints' angles."""
        links, builder, kept = self.links, self.builder, self.kept
        with builder.loop("k", 0, self.count) as loop:
            k = loop.index
            q, normal = links.at(links.q, k), links.at(links.normal, k)
            t, turning = tangent(q), tangent(normal)
            before = loop.carry("before_sine", 0), loop.carry("before_cosine", 1)
            store(kept["turned_from"], k, (dot(tangent(before), q), dot(before, q)))
            scale = builder.let("over_length", links.along[k] / dot(normal, normal))
            store(kept["held"], k, (scale * dot(q, normal), scale * dot(t, normal)))
            store(kept["column"], k, (dot(q, turning), dot(t, turning)))
            for carry, value in zip(before, q, strict=True):
                loop.follow(carry, value)

    def _seen(self, k: Index) -> _Seen:
        sine, cosine = load(self.kept["turned_from"], k, 2)
        return _Seen(load(self.kept["held"], k, 2), load(self.kept["column"], k, 2), sine, cosine)

    def _inwards(self, k: Index, beyond: Compound, asked: Vector) -> tuple[Compound, Vector]:
        """Link k and all beyond it, in the frame of the link before: K' and p'."""
        links, kept, let = self.links, self.kept, self.builder.let
        parameters, seen = links.parameters, self._seen(k)
        assert parameters.armature is not None and links.lead is not None
        mass, length, com, rotor = (table[k] for table in (parameters.mass, parameters.length, parameters.com, parameters.armature))
        column = seen.column[0], seen.column[1]
        overhang = self.builder.lift(0) if links.scene.tip_masses else length - com
        body = beyond if links.scene.tip_masses else beyond.shifted(overhang, column)
        body = body.with_mass(mass)
        own, lever = mass * overhang * overhang, mass * com * overhang
        if parameters.inertia is not None:
            body = body.stiffened(parameters.inertia[k] * column[1])
            own, lever = own + parameters.inertia[k], lever - parameters.inertia[k]
        whole = body.shifted(com, column)
        pivot = let("pivot", whole.matrix[2][2])
        inverse = let("inverse_pivot", 1 / (pivot + rotor))
        share = let("rotor_share", rotor * inverse)
        behind = whole.released(rotor, inverse)
        lean, m = links.lead[k], beyond.matrix
        # What a force at the far end does to the link, and how much of one across it reaches the joint.
        pull = named(self.builder, "end", sub(asked[:2], multiple(mass * overhang, seen.held)))
        rest = asked[2] + own * seen.held[1]
        if links.couple is not None:
            rest = rest - dot(tangent(links.at(links.q, k)), load(links.couple, k, 2))
        rest = let("rest", rest)
        loaded = let("loaded", length * pull[1] + rest)
        passed = rotor + m[2][2] + length * (m[2][0] * column[0] + m[2][1] * column[1]) - lever * column[1]
        led = rest + rotor * lean
        bent = multiple(length, seen.held)
        force_x = pull[0] + dot(behind.matrix[0][:2], bent) - inverse * whole.matrix[0][2] * (loaded + rotor * lean)
        force_y = dot(behind.matrix[1][:2], bent) + inverse * (pull[1] * passed - whole.matrix[1][2] * led)
        moment = dot(behind.matrix[2][:2], bent) + share * (loaded - pivot * lean)
        store(kept["row"], k, whole.matrix[2][:2])
        kept["share"][k], kept["inverse"][k] = share, inverse
        kept["loose"][k] = -(inverse * loaded) - share * lean
        force = named(self.builder, "force", (force_x, force_y))
        turned = (seen.cosine * force[0] - seen.sine * force[1], seen.sine * force[0] + seen.cosine * force[1])
        return behind.turned(seen.sine, seen.cosine), (*turned, moment)

    def _outwards(self, base: Vector) -> None:
        """The accelerations, from that of the base less gravity (down, sideways)."""
        links, kept, let = self.links, self.kept, self.builder.let
        with self.builder.loop("k", 0, self.count) as loop:
            k = loop.index
            x, y = (loop.carry(f"joint_{axis}", value) for axis, value in zip("xy", base, strict=True))
            before = loop.carry("turning_before", 0)
            seen, length = self._seen(k), links.parameters.length[k]
            joint = (seen.cosine * x + seen.sine * y, seen.cosine * y - seen.sine * x)
            far = named(self.builder, "far", add(joint, multiple(length, seen.held)))
            drawn = dot(load(kept["row"], k, 2), far)
            beta = let("turning", kept["loose"][k] + kept["share"][k] * before - kept["inverse"][k] * drawn)
            value = add(seen.held, multiple(beta, seen.column))
            q = links.at(links.q, k)
            links.write(k, add(multiple(value[0], q), multiple(value[1], tangent(q))))
            end = add(far, multiple(length * beta, seen.column))
            for carry, after in zip((x, y, before), (*end, beta), strict=True):
                loop.follow(carry, after)

