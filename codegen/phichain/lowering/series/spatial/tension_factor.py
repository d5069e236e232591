"""The factorisation of `tension`: one tridiagonal matrix from both ends, free of cancellation, and what a step holds of it."""

from __future__ import annotations

from typing import Final

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.algebra.vector import cross, dot, load, scale, store
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.series.held import Layout
from phichain.lowering.series.spatial.rows import Factoring, Number, joint_runs
from phichain.lowering.spatial.links import neighbours
from phichain.scene import Scene

LENGTH: Final = Number("link_length", frozenset({"length"}), lambda p, k: p.length[k])
INVERSE_LENGTH: Final = Number("inverse_length", frozenset({"length"}), lambda p, k: 1 / p.length[k])
PAIR_UNIT: Final = Number(
    "pair_unit", frozenset({"mass", "length"}), lambda p, k: 1 / (p.mass[k] * p.length[k])
)
RATIO: Final = "ratio"
"""rho_k for k = 1..N, the last one of no meaning."""


def numbers(scene: Scene) -> tuple[Number, ...]:
    return (LENGTH, INVERSE_LENGTH, *((PAIR_UNIT,) if ties_links(scene) else ()))


def layout(scene: Scene) -> Layout:
    links, cart = scene.links, scene.has_free_cart
    return Layout(
        [
            ("direction", 3 * links), ("outer", 3 * links), ("inner", 3 * links),  # q_k, rho_{k+1} P_k q_{k+1}, P_k q_{k-1}
            ("passed", links), ("particular", links), ("coupling", links),
            ("gravity", 3 if scene.base_accelerations else 1), ("push", 2 * scene.has_force),
            ("cart_damping", int(cart and scene.cart_damping is not None)),
            ("cart", 6 * cart), ("cart_ratio", int(cart)),
            *joint_runs(scene), *(number.run(scene) for number in numbers(scene)),
            (RATIO, links * (scene.mass == "runtime")),
        ]
    )  # fmt: skip


def middle_link(links: int) -> tuple[int, int]:
    """The link where both fronts meet, and how many steps they take side by side."""
    return links // 2, links - 1 - links // 2


def factor(step: Factoring) -> None:
    """The directions, what neighbours pull by, the pivots, the base."""
    builder, scene, parameters, direction = step.builder, step.scene, step.parameters, step.direction
    links = scene.links
    cosine, crosses = neighbours(builder, direction, links)
    ratio = parameters.mass_ratio
    nothing = builder.lift(0)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        here = load(direction, k)
        store(step.keep("direction"), k, here)
        store(step.keep("outer"), k, scale(ratio[k + 1], cross(here, load(crosses, k + 1))))
    store(step.keep("inner"), 0, (nothing, nothing, nothing))
    squared = builder.array("sine_squared", links)
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        across = load(crosses, k)
        squared[k] = dot(across, across)
        store(step.keep("inner"), k, cross(across, load(direction, k)))
    for number in numbers(scene):
        step.keep_number(number)
    if RATIO in step.layout:
        with builder.loop("k", 0, links) as loop:
            step.keep(RATIO)[loop.index] = ratio[loop.index + 1]
    _Fronts(step, cosine, squared).run(_base(step, cosine))


def _base(step: Factoring, cosine: ArrayRef) -> Expr:
    """Hold gravity, the push and the cart's matrix; rho_0 s_0^2, zero on a fixed base."""
    builder, parameters = step.builder, step.parameters
    fall = parameters.fall if step.scene.base_accelerations else parameters.fall[-1:]
    for i, entry in enumerate(fall):
        step.keep("gravity")[i] = entry * step.square
    step.keep_driven()
    if step.u is not None and "push" in step.layout and step.scene.has_free_cart:
        for i in range(2):
            step.keep("push")[i] = (
                step.u[i] * (1 / (parameters.base_mass * parameters.units.force)) * step.square
            )
    if "cart_damping" in step.layout and parameters.cart_damping is not None:
        unit = parameters.cart_mass * parameters.units.length
        step.keep("cart_damping")[0] = step.rho * (parameters.cart_damping / unit)
    if not step.scene.has_free_cart:
        return builder.lift(0)
    step.keep_cart_friction(parameters.base_mass)
    (x, y, _), ratio = (
        load(step.direction, 0),
        builder.let("cart_ratio", parameters.mass[0] / parameters.base_mass),
    )
    slack = builder.let("base_slack", ratio * (x * x + y * y))
    inverse = builder.let("inverse_cart_pivot", 1 / (1 + slack))
    outer = parameters.mass_ratio[1] * cosine[1] if step.scene.links > 1 else builder.lift(0)
    scaled = builder.let("cart_share", ratio * inverse)
    entries = (
        inverse + scaled * y * y,
        -(scaled * x * y),
        inverse + scaled * x * x,
        scaled * x,
        scaled * y,
        outer,
    )
    for i, entry in enumerate(entries):
        step.keep("cart")[i] = entry
    step.keep("cart_ratio")[0] = ratio
    return slack


class _Fronts:
    """Elimination from the base and from the tip; the slacks t and Y are carried."""

    def __init__(self, step: Factoring, cosine: ArrayRef, squared: ArrayRef) -> None:
        self.builder, self.links, self.cosine, self.squared = step.builder, step.scene.links, cosine, squared
        self.ratio, self.inverse_ratio = step.parameters.mass_ratio, step.parameters.inverse_mass_ratio
        self.passed, self.particular, self.coupling = map(step.keep, ("passed", "particular", "coupling"))

    def run(self, base: Expr) -> None:
        """Hold what every link passes on, and what it makes of its load and of its inner neighbour's tension."""
        middle, paired = middle_link(self.links)
        tip = self.builder.lift(1)
        if paired:
            with self.builder.loop("i", 0, paired) as loop:
                base, tip = loop.carry("base_slack", base), loop.carry("tip_slack", tip)
                loop.follow(base, self.from_base(base, loop.index))
                loop.follow(tip, self.from_tip(tip, self.links - 1 - loop.index))
        if middle > paired:
            base = self.from_base(base, middle - 1)
        self.particular[middle] = 1 / (base + tip)
        self.passed[middle] = self.coupling[middle] = self.builder.lift(0)

    def from_base(self, slack: Expr, k: Index) -> Expr:
        """Eliminate link k: t_{k+1} = rho_{k+1} (s_{k+1}^2 + t_k) / (1 + t_k)."""
        inverse = self.builder.let("base_inverse_pivot", 1 / (1 + slack))
        self.particular[k] = inverse
        self.passed[k] = passed = self.builder.let("base_passed", self.cosine[k + 1] * inverse)
        self.coupling[k] = self.ratio[k + 1] * passed
        return self.ratio[k + 1] * ((self.squared[k + 1] + slack) * inverse)

    def from_tip(self, slack: Expr, k: Index) -> Expr:
        """Eliminate link k: Y_{k-1} = (s_k^2 + z_k) / (1 + z_k), z_k = Y_k / rho_k."""
        scaled = self.builder.let("scaled_slack", self.inverse_ratio[k] * slack)
        inverse = self.builder.let("tip_inverse_pivot", 1 / (1 + scaled))
        self.particular[k] = self.inverse_ratio[k] * inverse
        self.passed[k] = passed = self.builder.let("tip_passed", self.cosine[k] * inverse)
        self.coupling[k] = self.inverse_ratio[k] * passed
        return (self.squared[k] + scaled) * inverse
