"""The two chains every table uses, as numbers, as scenes and as random states.

P: planar, fixed base, relative angles, ``m = l = 1/N``, ``r = l/2``, with or without joint torques: paper A's.

S: spatial, on a cart of 0.5 kg, ``m_i = 0.1 kg``, ``l_i = r_i = 0.1 m``, driven by its force: paper B's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.81


@dataclass(frozen=True)
class Chain:
    """A chain pendulum with numeric parameters.

    Attributes:
        space: "planar" (fixed base, relative angles) or "spatial" (on a cart).
        mass: point masses, kg.
        length: link lengths, m.
        com: distances of the masses from the base joints of their links, m.
        cart_mass: kg, or None on a fixed base.
        forced: whether the chain takes an input ``u`` (planar: N joint torques, spatial: the force on the
            cart).
    """

    space: str
    mass: tuple[float, ...]
    length: tuple[float, ...]
    com: tuple[float, ...]
    cart_mass: float | None
    forced: bool

    @property
    def links(self) -> int:
        return len(self.mass)

    @property
    def nq(self) -> int:
        return self.links if self.space == "planar" else 3 * self.links + 2

    @property
    def nv(self) -> int:
        return self.nq

    @property
    def nu(self) -> int:
        if not self.forced:
            return 0
        return self.links if self.space == "planar" else 2

    @property
    def width(self) -> int:
        """Length of one state row (q, v, u)."""
        return self.nq + self.nv + self.nu

    @property
    def label(self) -> str:
        letter = "P" if self.space == "planar" else "S"
        return f"{letter}, N = {self.links}, {'forced' if self.forced else 'unforced'}"


def planar_chain(links: int, forced: bool = True) -> Chain:
    """Chain P."""
    part = (1.0 / links,) * links
    return Chain("planar", part, part, tuple(0.5 * x for x in part), None, forced)


def spatial_chain(links: int, forced: bool = True) -> Chain:
    """Chain S."""
    part = (0.1,) * links
    return Chain("spatial", part, part, part, 0.5, forced)


def chain_of(space: str, links: int, forced: bool = True) -> Chain:
    """Chain P or S by the name of its space."""
    return planar_chain(links, forced) if space == "planar" else spatial_chain(links, forced)


def scene_table(
    chain: Chain, want: tuple[str, ...] = ("forward_dynamics",), code: str = "auto"
) -> dict[str, Any]:
    """The chain as the nested table of a phichain scene file."""
    planar = chain.space == "planar"
    body: dict[str, Any] = {
        "links": chain.links,
        "space": chain.space,
        "base": "fixed" if planar else "cart",
        "mass": list(chain.mass),
        "length": list(chain.length),
    }
    if chain.com != chain.length:
        body["com"] = list(chain.com)
    if chain.cart_mass is not None:
        body["cart_mass"] = chain.cart_mass
    driven = "all" if planar else "cart"
    joints: dict[str, Any] = {"actuated": driven if chain.forced else "none"}
    if planar:
        joints["angles"] = "relative"
    return {
        "name": f"{chain.space}{chain.links}",
        "chain": body,
        "joints": joints,
        "functions": {"want": list(want)},
        "target": {"real": "double", "code": code},
    }


def random_states(chain: Chain, count: int, seed: int = 20261121) -> NDArray[np.float64]:
    """Random states, one row (q, v, u) each: angles over the whole circle, directions over the whole sphere.

    Directions have unit length and rates are tangent to them up to round-off, as the contract of the C asks.
    """
    generator = np.random.default_rng(seed)
    inputs = generator.standard_normal((count, chain.nu))
    if chain.space == "planar":
        angles = generator.uniform(-np.pi, np.pi, (count, chain.links))
        rates = generator.standard_normal((count, chain.links))
        return np.ascontiguousarray(np.hstack([angles, rates, inputs]))
    cart = generator.standard_normal((count, 4))
    direction = generator.standard_normal((count, chain.links, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    rate = generator.standard_normal((count, chain.links, 3))
    rate -= np.sum(rate * direction, axis=2, keepdims=True) * direction
    columns = [cart[:, :2], direction.reshape(count, -1), cart[:, 2:], rate.reshape(count, -1), inputs]
    return np.ascontiguousarray(np.hstack(columns))
