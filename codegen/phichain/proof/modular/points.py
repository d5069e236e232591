"""Random points of a scene in the field: states on the manifold, inputs, runtime parameters, and one value for each Bessel function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from phichain.contract.chain import LEAST_SQUARE
from phichain.ir.nodes import Array
from phichain.proof.modular.compiled import Circle, Given
from phichain.proof.modular.field import HALF, PRIME, Source, Vector, exact, inverse, root
from phichain.scene import Scene

POINTS: Final = 3
"""How many random points every identity is held at."""


@dataclass(eq=False)
class Point:
    """One random point of a scene, the same for every function.

    Attributes:
        scene: the chain.
        number: which one, counted from 1.
        params: fields of the scene's runtime parameters.
    """

    scene: Scene
    number: int
    params: tuple[Array, ...]

    def source(self, purpose: str) -> Source:
        """Random elements for a purpose: seeded by the scene's digest, so nobody chooses them."""
        return Source(self._digest, self.number, purpose)

    @cached_property
    def _digest(self) -> str:
        return self.scene.digest

    @property
    def carts(self) -> int:
        """Number of the cart's coordinates."""
        return (1 if self.scene.is_planar else 2) * self.scene.has_cart

    @cached_property
    def parameters(self) -> dict[str, Vector]:
        """Values of the runtime parameters."""
        source = self.source("parameters")
        return {array.name: source.vector(array.size) for array in self.params}

    @cached_property
    def circles(self) -> list[Circle]:
        """The points of the circle of the scene's angles; that of a cart's position serves nothing."""
        source = self.source("circles")
        return [source.circle() for _ in range(self.scene.nq)]

    @cached_property
    def links(self) -> list[Vector]:
        """Unit vectors q_k of a spatial chain."""
        source = self.source("links")
        return [source.sphere() for _ in range(self.scene.links)]

    @cached_property
    def q(self) -> Vector:
        """Configuration: angles by value, or unit vectors, the cart's place before them."""
        source = self.source("q")
        if self.scene.is_planar:
            return source.vector(self.scene.nq)
        return [*source.vector(self.carts), *(entry for link in self.links for entry in link)]

    @cached_property
    def v(self) -> Vector:
        """Rates; angular velocities are orthogonal to their links."""
        return self.tangent("v")

    @cached_property
    def u(self) -> Vector:
        """Inputs."""
        return self.source("u").vector(self.scene.nu)

    def tangent(self, purpose: str) -> Vector:
        """A random vector of rates: free in the plane and for the cart, orthogonal to the links in space."""
        source = self.source(purpose)
        if self.scene.is_planar:
            return source.vector(self.scene.nv)
        turns = (source.across(link) for link in self.links)
        return [*source.vector(self.carts), *(entry for turn in turns for entry in turn)]

    def free(self, purpose: str, size: int | None = None) -> Vector:
        """A random vector without any constraint, of the size of v where none is given."""
        return self.source(purpose).vector(self.scene.nv if size is None else size)

    def given(self, **values: Sequence[int]) -> Given:
        """Arguments of a Program: the named ones, this point's state where none is named, and the runtime parameters."""
        state = {"q": self.q, "v": self.v, "u": self.u}
        return Given(self.parameters | state | dict(values), {"q": self.circles} if self.scene.is_planar else {})

    @cached_property
    def long_links(self) -> tuple[Vector, Vector]:
        """(lengths, vectors q of such lengths): the lengths are squares, so that roots of squares are they themselves."""
        source = self.source("lengths")
        lengths = [source.element() ** 2 % PRIME for _ in self.links]
        whole = [size * entry % PRIME for size, link in zip(lengths, self.links, strict=True) for entry in link]
        return lengths, [*source.vector(self.carts), *whole]

    @cached_property
    def bessel(self) -> Bessel:
        """J_n(x) by n."""
        return Bessel(self.source("bessel"))

    def atom(self, x: int) -> Circle:
        """A point of the circle for an x that is no sum of angles: one for each value, that of -x its mirror image."""
        even = min(x, PRIME - x)
        if even not in self._atoms:
            self._atoms[even] = self.source(f"atom {even}").circle() if even else (1, 0)
        c, s = self._atoms[even]
        return (c, s) if x == even else (c, -s % PRIME)

    def root(self, x: int) -> int:
        """The root of a square that is a square itself; for what has no root in the field, an element of its own."""
        found = root(x)
        return found if found * found % PRIME == x else self.source(f"root {x}").element()

    def tanh(self, x: int) -> int:
        """tanh(x): an element of its own for every value, that of -x its opposite, zero at zero; x itself where a vector is at rest."""
        even = min(x, PRIME - x)
        value = self.source(f"tanh {even}").element() if even else 0
        if even * even % PRIME == exact(LEAST_SQUARE):
            value = even
        return value if x == even else -value % PRIME

    def log_cosh(self, x: int) -> int:
        """ln cosh(x): an element of its own for every value and its opposite, zero at zero."""
        even = min(x, PRIME - x)
        return self.source(f"log cosh {even}").element() if even else 0

    @cached_property
    def _atoms(self) -> dict[int, Circle]:
        return {}


class Bessel:
    """The values of J_n(x) as independent elements that obey what the functions obey.

    J_1 = x z and J_2 = x^2 y with random z and y for every x^2, the rest by J_{n+1} = 2 n / x J_n - J_{n-1}: then J_n(-x) is
    (-1)^n J_n(x), and at zero J_0 = 1 and the others vanish.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._shapes: dict[int, tuple[int, int]] = {0: (HALF, inverse(8))}
        self._orders: dict[int, Orders] = {}

    def shape(self, x: int) -> tuple[int, int]:
        """z = J_1 / x and y = J_2 / x^2, even functions of x."""
        even = x if x <= HALF else PRIME - x
        found = self._shapes.get(even)
        if found is None:
            found = self._shapes[even] = (self._source.element(), self._source.element())
        return found

    def __call__(self, x: int) -> Orders:
        """J_n(x) by order."""
        found = self._orders.get(x)
        if found is None:
            z, y = self.shape(x)
            square = x * x % PRIME
            found = self._orders[x] = Orders(
                {0: (2 * z - square * y) % PRIME, 1: x * z % PRIME, 2: square * y % PRIME, 3: x * (4 * y - z) % PRIME}
            )
            found.x = x
        return found


class Orders(dict[int, int]):
    """J_0(x) to J_3(x), which take no division, and higher orders when they are asked for."""

    x: int

    def __missing__(self, order: int) -> int:
        # At zero all but J_0 vanish.
        over = 2 * (order - 1) * inverse(self.x) if self.x else 0
        self[order] = (over * self[order - 1] - self[order - 2]) % PRIME
        return self[order]
