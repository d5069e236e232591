"""The chains that the tables use, as numbers, as scenes and as random states.

P: planar, fixed base, relative angles, ``m = l = 1/N``, ``r = l/2``, with or without joint torques: paper A's.

S: spatial, on a cart of 0.5 kg, ``m_i = 0.1 kg``, ``l_i = r_i = 0.1 m``, driven by its force: paper B's.

The others are variations of these two, made with ``dataclasses.replace`` or by a function below.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.81


@dataclass(frozen=True)
class Chain:
    """A chain pendulum with numeric parameters.

    Attributes:
        space: "planar" or "spatial".
        mass: point masses, kg.
        length: link lengths, m.
        com: distances of the masses from the base joints of their links, m.
        cart_mass: kg, or None on a fixed base.
        forced: whether the chain takes an input ``u`` (fixed base: N joint torques; cart: the force on it).
        angles: of a planar chain, "relative" or "absolute".
        runtime: whether masses, lengths and centres are given at run time.
    """

    space: str
    mass: tuple[float, ...]
    length: tuple[float, ...]
    com: tuple[float, ...]
    cart_mass: float | None
    forced: bool
    angles: str = "relative"
    runtime: bool = False

    @property
    def links(self) -> int:
        return len(self.mass)

    @property
    def carts(self) -> int:
        """Coordinates of the cart."""
        if self.cart_mass is None:
            return 0
        return 1 if self.space == "planar" else 2

    @property
    def nq(self) -> int:
        return self.carts + (self.links if self.space == "planar" else 3 * self.links)

    @property
    def nv(self) -> int:
        return self.nq

    @property
    def nu(self) -> int:
        if not self.forced:
            return 0
        return self.carts or self.links

    @property
    def width(self) -> int:
        """Length of one state row (q, v, u)."""
        return self.nq + self.nv + self.nu

    @property
    def tip_masses(self) -> bool:
        """Whether every mass sits at its link's end."""
        return self.com == self.length

    @property
    def parameters(self) -> NDArray[np.float64]:
        """The runtime parameters in the order of the emitted struct; empty where none are."""
        return np.array([*self.mass, *self.length, *self.com]) if self.runtime else np.empty(0)

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


def tip_chain(links: int) -> Chain:
    """Chain P unforced with its masses at the links' ends."""
    chain = planar_chain(links, forced=False)
    return replace(chain, com=chain.length)


def absolute_chain(links: int) -> Chain:
    """Chain P unforced in absolute angles."""
    return replace(planar_chain(links, forced=False), angles="absolute")


def cart_chain(links: int) -> Chain:
    """Chain P on a cart of 0.5 kg that a force drives."""
    return replace(planar_chain(links), cart_mass=0.5)


def runtime_chain(links: int) -> Chain:
    """Chain P unforced, its masses, lengths and centres given at run time."""
    return replace(planar_chain(links, forced=False), runtime=True)


def spread_chain(links: int) -> Chain:
    """Chain P unforced, its masses from 1e4 down to 1e-4 kg."""
    mass = tuple(float(x) for x in np.logspace(4, -4, links)) if links > 1 else (1.0,)
    return replace(planar_chain(links, forced=False), mass=mass)


def inner_spatial_chain(links: int) -> Chain:
    """Chain S with its masses at 0.6 of the links' lengths."""
    chain = spatial_chain(links)
    return replace(chain, com=tuple(0.6 * x for x in chain.length))


def scene_table(chain: Chain, want: tuple[str, ...] = ("forward_dynamics",), code: str = "auto") -> dict[str, Any]:
    """The chain as the nested table of a phichain scene file."""
    planar = chain.space == "planar"
    body: dict[str, Any] = {
        "links": chain.links,
        "space": chain.space,
        "base": "fixed" if chain.cart_mass is None else "cart",
        "mass": "runtime" if chain.runtime else list(chain.mass),
        "length": "runtime" if chain.runtime else list(chain.length),
    }
    if chain.com != chain.length:
        body["com"] = "runtime" if chain.runtime else list(chain.com)
    if chain.cart_mass is not None:
        body["cart_mass"] = chain.cart_mass
    driven = "all" if chain.cart_mass is None else "cart"
    joints: dict[str, Any] = {"actuated": driven if chain.forced else "none"}
    if planar:
        joints["angles"] = chain.angles
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
    cart = generator.standard_normal((count, 2 * chain.carts))
    places, speeds = cart[:, : chain.carts], cart[:, chain.carts :]
    if chain.space == "planar":
        angles = generator.uniform(-np.pi, np.pi, (count, chain.links))
        rates = generator.standard_normal((count, chain.links))
        return np.ascontiguousarray(np.hstack([places, angles, speeds, rates, inputs]))
    direction = generator.standard_normal((count, chain.links, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    rate = generator.standard_normal((count, chain.links, 3))
    rate -= np.sum(rate * direction, axis=2, keepdims=True) * direction
    columns = [places, direction.reshape(count, -1), speeds, rate.reshape(count, -1), inputs]
    return np.ascontiguousarray(np.hstack(columns))
