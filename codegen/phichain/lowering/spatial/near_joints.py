"""(I - g J) k = r in O(N) for spatial chains without springs and dampers whose masses may sit near the joints.

The plain blocks of `spatial.implicit` take the determinant of a link's pivot from its entries, which loses (l / r)^2. Here the
chain beyond a joint is its Lambda, the adjugate K and the determinant E, in each link's own m and l, none a difference of
large numbers. Across and along q, with beta = r / l, s = 1 - g^2 w^2, b = g^2 alpha + 2 g q' (the leaning), R the pull,

    Lambda = [[L, h], [h~^T, a]],   K = [[C, y], [y~^T, c]],   N = s P - q b^T,   kappa = -g^2 R,   turned(S) = tr S - S
    e = beta^2 s + kappa,   zeta = beta (1 - beta) s - kappa,   eta = (1 - beta)^2 s + kappa
    M = e P + P Lambda N,   tau = s tr L - b.h,   f = s c + b.y,   D = det M = e (e + tau) + s f
    D M^-1 = (e + tau) P - P Lambda N,   D M^-1 P Lambda N = e P Lambda N + s f P
    D M^-1 P Lambda = e L + s c P + (q x b)(q x y)^T + (e h - s y) q^T

The shift to the other end of the link, P (beta + Lambda) N M^-1 = P + zeta M^-1, and y = -adj(L) h give, all in the same blocks,

    D Lambda': [[(kappa (e + tau) + eta f) P + zeta^2 L + zeta (y - beta h) b^T,  -zeta (e h - s y)],
                [-zeta (e h~ - s y~) + zeta (C - beta L)^T b
                     + (e (tr C + beta^2 + beta a) + s (E + beta c + beta^2 tr L)) b,   D + e^2 a + e s tr C + s^2 E + beta b.(e h - s y)]]
    D K': [[zeta^2 (C + turned(L)) + (s (eta (E + c) + kappa (tr C + tr L) + (1 - beta)^2 b.y)
                     + e (kappa (1 + a) - (1 - beta)^2 b.h)) P + zeta (1 - beta) (beta h - y) b^T,   -zeta (eta y - kappa h)],
           [-zeta (eta y~ - kappa h~) - zeta (1 - beta) (C + beta turned(L))^T b
                     - (eta (beta c + E) + kappa (beta tr L + tr C + beta (a + beta))) b,
            eta^2 c + kappa (eta tr L + kappa) + (1 - beta) b.(eta y - kappa h)]]
    D E' = eta^2 (E + c) + eta kappa (tr C + tr L) + kappa^2 (1 + a) + (1 - beta)^2 b.(eta y - kappa h).

For g = 0 every bracket is a sum of positive terms; kappa is the geometric stiffness, positive in a link under tension.
A cart adds m_c, and g times the slope of what resists its speed, to the horizontal block:
det = m_c (m_c + Lambda_xx + Lambda_yy) + K_zz.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    applied,
    flat,
    from_flat,
    minus,
    outer,
    plus,
    scalar,
    scaled,
    store_matrix,
    trace,
    transposed,
)
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import brakes_cart, cart_slope_cells, cart_slopes, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.units import SpatialUnits
from phichain.scene import Scene

#: Links whose mass sits within this part of their length from the joint leave the plain blocks.
NEAR = Fraction(1, 4)
#: s, kappa, zeta, w^2 and what P, the shift of the link, does to x, to the tip, to d', through T and to the pull.
COEFFICIENTS = 9
#: Arrays that the elimination hands to its solutions, and the entries a link has in each.
NEAR_JOINTS = {
    "unit": 3, "spin": 3, "moving": 3, "turning": 3, "pull": 1, "lean": 3, "inverse": 9, "reply": 9, "held": 9,
    "row": 3, "column": 3, "axial": 2, "turn": COEFFICIENTS,
}  # fmt: skip


CART_PIVOT, CART_LOAD = "cart_pivot", "cart_load"
#: Where something resists the cart's speed: its slope, or slopes xx, xy, yy, and the cart's mass, all over that of link 0.
CART_DRAG = "cart_drag"


def near_joints(scene: Scene) -> bool:
    """Whether some mass of a chain without springs and dampers is known to sit near its joint; what is not known stays cheap."""
    is_free = not ties_links(scene) and scene.inertia is None
    if scene.com is None or not is_free or isinstance(scene.com, str) or isinstance(scene.length, str):
        return False
    return any(r < NEAR * length for r, length in zip(scene.com, scene.length, strict=True))


def near_sizes(scene: Scene) -> dict[str, int]:
    """Names and sizes of what the elimination writes."""
    sizes = {name: size * scene.links for name, size in NEAR_JOINTS.items()}
    sizes |= {CART_PIVOT: 4, CART_LOAD: 6} if scene.has_free_cart else {}
    return sizes | ({CART_DRAG: 1 + cart_slope_cells(scene)} if brakes_cart(scene) else {})


@dataclass(frozen=True)
class Beyond:
    """Lambda, its adjugate and its determinant."""

    force: Matrix
    adjugate: Matrix
    determinant: Expr

    def flat(self) -> list[Expr]:
        """All scalars in a fixed order, for a loop to carry."""
        return [*flat(self.force), *flat(self.adjugate), self.determinant]

    @staticmethod
    def from_flat(values: list[Expr]) -> Beyond:
        """The inverse of `flat`."""
        return Beyond(from_flat(values[:9]), from_flat(values[9:18]), values[18])


class _Blocks:
    """A matrix in blocks along and across q: [[flat, column], [row, along]]."""

    def __init__(self, matrix: Matrix, q: Vector) -> None:
        column, row = applied(matrix, q), applied(transposed(matrix), q)
        self.along = dot(q, column)
        self.column, self.row = sub(column, scale(self.along, q)), sub(row, scale(self.along, q))
        self.flat = minus(minus(matrix, outer(column, q)), outer(q, self.row))
        self.trace = trace(matrix) - self.along


def _joined(q: Vector, flat_part: Matrix, column: Vector, row: Vector, along: Expr) -> Matrix:
    return plus(flat_part, outer(column, q), outer(q, add(row, scale(along, q))))


class NearJoints:
    """The elimination from the tip to the base of a chain without springs and dampers."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, cart_rate: ArrayRef, out: dict[str, ArrayRef]
    ) -> None:
        self.builder, self.scene, self.parameters, self.out = builder, scene, parameters, out
        self.cart_rate = cart_rate
        self.units, self.gain = SpatialUnits(builder, scene, parameters), gain
        self.squared, self.twice = (
            builder.let("gain_squared", gain * gain),
            builder.let("gain_twice", gain + gain),
        )

    def run(self) -> None:
        """Write all that `near_joints_solution` needs."""
        chain = self._inwards()
        if not self.scene.has_free_cart:
            return
        cart = self.parameters.base_mass / self.parameters.mass[0]
        first, mixed, second = cart, self.builder.lift(0), cart
        if brakes_cart(self.scene):
            first, mixed, second = self._held_cart(cart)
        (xx, xy, xz), (yx, yy, yz), _ = chain.force
        if mixed.is_zero:
            pivot = first * (first + xx + yy)
        else:
            pivot = (first * second - mixed * mixed) + (first * yy + second * xx - mixed * (xy + yx))
        inverse = self.builder.let("inverse_cart", 1 / (pivot + chain.adjugate[2][2]))
        for i, entry in enumerate((second + yy, -(mixed + xy), -(mixed + yx), first + xx)):
            self.out[CART_PIVOT][i] = entry * inverse
        for i, entry in enumerate((xx, xy, xz, yx, yy, yz)):
            self.out[CART_LOAD][i] = entry

    def _held_cart(self, cart: Expr) -> tuple[Expr, Expr, Expr]:
        """xx, xy, yy of the cart's mass and g times its slopes; mass and slopes are kept for the solutions."""
        let, drag, cells = self.builder.let, self.out[CART_DRAG], cart_slope_cells(self.scene)
        found = cart_slopes(self.scene, self.parameters, self.cart_rate)
        own, aside, other = (let("cart_slope", entry / self.parameters.mass[0]) for entry in found)
        for i, entry in enumerate((own, aside, other)[:cells]):
            drag[i] = entry
        drag[cells] = cart
        first = let("cart_held", cart + self.gain * own)
        return first, self.gain * aside, first if aside.is_zero else let("cart_held", cart + self.gain * other)

    def _inwards(self) -> Beyond:
        """The chain beyond the base, in units of link 0."""
        with self.builder.loop("k", self.scene.links - 1, -1, -1) as loop:
            carried = [loop.carry("beyond", 0) for _ in range(19)]
            after = self.eliminate(Beyond.from_flat(carried), loop.index)
            for before, following in zip(carried, after.flat(), strict=True):
                loop.follow(before, following)
        return Beyond.from_flat(carried)

    def eliminate(self, beyond: Beyond, k: Index) -> Beyond:
        """Link k and all beyond it, in units of the link before."""
        out, units, let = self.out, self.units, self.builder.let
        q, spin, moving, turning = (load(out[name], k) for name in ("unit", "spin", "moving", "turning"))
        lean = add(scale(self.squared, turning), scale(self.twice, moving))
        rate_squared = let("rate_squared", dot(spin, spin))
        pull = let("scaled_pull", units.inverse_torque[k] * out["pull"][k])
        s, kappa = let("s", 1 - self.squared * rate_squared), let("kappa", -(self.squared * pull))
        own, zeta = let("own", units.reach_squared[k] * s + kappa), let("zeta", units.lever[k] * s - kappa)
        eta = let("eta", units.overhang_squared[k] * s + kappa)
        beta, over, over2 = units.reach[k], units.overhang[k], units.overhang_squared[k]
        a, c = _Blocks(beyond.force, q), _Blocks(beyond.adjugate, q)
        det = beyond.determinant
        p = minus(scalar(self.builder.lift(1)), outer(q, q))
        lean_a, lean_c = dot(lean, a.column), dot(lean, c.column)
        across = s * a.trace - lean_a
        facing = s * c.along + lean_c
        d = own * (own + across) + s * facing
        inverse = let("inverse_pivot", 1 / d)
        bent = minus(scaled(s, a.flat), outer(a.column, lean))
        minv = scaled(inverse, minus(scaled(own + across, p), bent))
        column = sub(scale(own, a.column), scale(s, c.column))
        reply = plus(
            scaled(own, a.flat),
            scaled(s * c.along, p),
            outer(cross(q, lean), cross(q, c.column)),
            outer(column, q),
        )
        reply = scaled(inverse, reply)
        held = scaled(inverse, plus(scaled(own, bent), scaled(s * facing, p)))
        # Lambda'
        turned_a = minus(scaled(a.trace, p), a.flat)
        flat_part = plus(
            scaled(kappa * (own + across) + eta * facing, p),
            scaled(zeta * zeta, a.flat),
            outer(scale(zeta, sub(c.column, scale(beta, a.column))), lean),
        )
        through = sub(applied(transposed(c.flat), lean), scale(beta, applied(transposed(a.flat), lean)))
        row = add(
            scale(zeta, add(sub(through, scale(own, a.row)), scale(s, c.row))),
            scale(
                own * (c.trace + beta * (beta + a.along)) + s * (det + beta * (c.along + beta * a.trace)),
                lean,
            ),
        )
        along = (own * own * a.along + own * (s * c.trace) + s * (s * det)) + beta * dot(lean, column)
        added = let("added", along * inverse)
        axial = 1 + added
        mass = units.mass[k]
        passed = mass * inverse
        tilt = scale(-(zeta * inverse), column)
        force = _joined(q, scaled(passed, flat_part), scale(mass, tilt), scale(passed, row), mass * axial)
        # K'
        more = 1 + a.along
        flat_k = plus(
            scaled(zeta * zeta, plus(c.flat, turned_a)),
            scaled(
                s * (eta * (det + c.along) + kappa * (c.trace + a.trace) + over2 * lean_c)
                + own * (kappa * more - over2 * lean_a),
                p,
            ),
            outer(scale(zeta * over, sub(scale(beta, a.column), c.column)), lean),
        )
        column_k = sub(scale(eta, c.column), scale(kappa, a.column))
        leaning = (
            eta * (beta * c.along + det)
            + kappa * (beta * (a.trace + a.along + beta) + c.trace)
            + beta * (zeta * (over * a.trace))
        )
        row_k = sub(
            scale(-zeta, add(sub(scale(eta, c.row), scale(kappa, a.row)), scale(over, through))),
            scale(leaning, lean),
        )
        along_k = eta * (eta * c.along) + kappa * (eta * a.trace + kappa) + over * dot(lean, column_k)
        passed_k = mass * passed
        adjugate = scaled(passed_k, _joined(q, flat_k, scale(-zeta, column_k), row_k, along_k))
        whole = (
            eta * (eta * (det + c.along) + kappa * (c.trace + a.trace))
            + kappa * (kappa * more)
            + over2 * (eta * lean_c - kappa * lean_a)
        )
        inverse_axial = let("inverse_axial", 1 / axial)
        for name, value in (("inverse", minv), ("reply", reply), ("held", held)):
            store_matrix(out[name], k, value)
        store(out["row"], k, sub(scale(s, a.row), scale(a.along + beta, lean)))
        store(out["column"], k, scale(inverse, column))
        store(out["lean"], k, lean)
        over_squared = let("over_squared", over * rate_squared)
        coefficients = (
            s, kappa, zeta, rate_squared,
            -(units.reach_squared[k] * rate_squared + pull), s * pull - kappa * rate_squared,
            -(kappa * over_squared + beta * (s * pull)), -(over * over_squared + pull), beta * over_squared - pull,
        )  # fmt: skip
        for i, entry in enumerate(coefficients):
            out["turn"][COEFFICIENTS * k + i] = entry
        out["axial"][2 * k], out["axial"][2 * k + 1] = added, inverse_axial
        return Beyond(force, adjugate, mass * passed_k * whole)
