"""The numbers of a scene inside a Program: exact constants where they are known, cells of the params struct where not."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from phichain.program.builder import ArrayRef, Builder, Expr, Index
from phichain.scene import Scene

_PER_LINK = ("mass", "length", "com", "damping", "stiffness")

_DOC = {
    "mass": "point mass of each link, kg",
    "length": "length of each link, m",
    "com": "distance of each point mass from its base joint, m",
    "cart_mass": "mass of the cart, kg",
    "gravity": "gravitational acceleration, m/s^2",
    "damping": "damping of each joint, N m s/rad",
    "stiffness": "stiffness of each joint, N m/rad",
}


class Parameters:
    """Per-link parameters and the sums of design section 1.1 that lowering needs, each made on first use.

    Links are counted from 0. ``outer_mass[k]`` is the mass beyond link k, ``mu[k] = m_k r_k + l_k outer_mass[k]``,
    ``c_diagonal[k] = m_k r_k^2 + l_k^2 outer_mass[k]``; for i != j ``c_ij = length[min(i, j)] * mu[max(i, j)]``.
    """

    def __init__(self, builder: Builder, scene: Scene) -> None:
        self._builder, self._scene = builder, scene
        self._made: dict[str, ArrayRef] = {}
        self.links = scene.links
        for name in scene.runtime:
            shape = (scene.links,) if name in _PER_LINK else ()
            self._made[name] = builder.param(name, shape, _DOC[name])
        self.mass = self._given("mass")
        self.length = self._given("length")
        self.com = self.length if scene.com is None else self._given("com")

    @property
    def damping(self) -> ArrayRef | None:
        """Joint damping, or None on an undamped scene."""
        return None if self._scene.damping is None else self._given("damping")

    @property
    def stiffness(self) -> ArrayRef | None:
        """Joint stiffness, or None on a scene without springs."""
        return None if self._scene.stiffness is None else self._given("stiffness")

    @property
    def gravity(self) -> Expr:
        """Gravitational acceleration."""
        return self._scalar("gravity")

    @property
    def cart_mass(self) -> Expr:
        """Mass of the cart."""
        return self._scalar("cart_mass")

    @property
    def outer_mass(self) -> ArrayRef:
        """The mass beyond each link, sum of m_a over a > k."""
        return self._once("outer_mass", self._outer_mass)

    @property
    def total_mass(self) -> Expr:
        """M_00 = m_0 + sum of all m_a."""
        chain = self.outer_mass[0] + self.mass[0]
        return chain + self.cart_mass if self._scene.has_cart else chain

    @property
    def mu(self) -> ArrayRef:
        """First moments mu_k."""
        return self.derived("mu", lambda k: self.mass[k] * self.com[k] + self.length[k] * self.outer_mass[k])

    @property
    def c_diagonal(self) -> ArrayRef:
        """Second moments c_kk."""
        length, com = self.length, self.com
        return self.derived(
            "c_diagonal", lambda k: self.mass[k] * com[k] * com[k] + length[k] * length[k] * self.outer_mass[k]
        )

    @property
    def mass_ratio(self) -> ArrayRef:
        """rho_k = m_k / m_{k-1} for k = 1..N; the last, beyond the tip (where the tension is zero), repeats its neighbour."""
        return self._between("mass_ratio", lambda k: self.mass[k + 1] / self.mass[k])

    @property
    def inverse_mass_ratio(self) -> ArrayRef:
        """1 / rho_k = m_{k-1} / m_k for k = 1..N, padded likewise."""
        return self._between("inverse_mass_ratio", lambda k: self.mass[k] / self.mass[k + 1])

    def derived(self, name: str, entry: Callable[[Index], Expr], count: int | None = None) -> ArrayRef:
        """A table of per-link values made once per Program."""
        return self._once(name, lambda: self._builder.table(name, count or self.links, entry))

    def _between(self, name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        """entry(k - 1) for the neighbours k - 1 and k, k = 1..N-1, and a repeated entry for k = N."""
        last = self.links - 1
        if last == 0:
            return self.derived(name, lambda k: self._builder.lift(1)).shifted(-1)
        if self._scene.mass != "runtime":
            return self.derived(name, lambda k: entry(min(k, last - 1))).shifted(-1)  # type: ignore[type-var]
        return self._once(name, lambda: self._padded(name, entry)).shifted(-1)

    def _padded(self, name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        builder, last = self._builder, self.links - 1
        cells = builder.array(name, self.links)
        with builder.loop("k", 0, last) as loop:
            cells[loop.index] = entry(loop.index)
        cells[last] = builder.lift(1)
        return cells

    def _outer_mass(self) -> ArrayRef:
        builder, links = self._builder, self.links
        if self._scene.mass != "runtime":
            mass = self._scene.mass
            return builder.table("outer_mass", links, lambda k: sum(map(Fraction, mass[k + 1 :]), Fraction(0)))  # type: ignore[operator,misc]
        outer = builder.array("outer_mass", links)
        outer[links - 1] = builder.lift(0)
        with builder.loop("k", links - 1, 0, -1) as loop:
            k = loop.index
            beyond = loop.carry("beyond", 0)
            following = beyond + self.mass[k]
            outer[k - 1] = following
            loop.follow(beyond, following)
        return outer

    def _given(self, name: str) -> ArrayRef:
        values = getattr(self._scene, name)
        return self._once(name, lambda: self._builder.table(name, self.links, lambda k: values[k]))

    def _scalar(self, name: str) -> Expr:
        if name in self._made:
            return self._made[name][0]
        return self._builder.lift(getattr(self._scene, name))

    def _once(self, name: str, make: Callable[[], ArrayRef]) -> ArrayRef:
        if name not in self._made:
            with self._builder.first_of_all():
                self._made[name] = make()
        return self._made[name]
