"""Where the links of a System are in space, for drawing: joints as points, from a state and the scene's lengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.records import Held
from phichain.system import System, unit_vectors
from phichain.system.angles import absolute_angles

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outline(Held):
    """What drawing asks of a System, of a motion whose System is gone.

    Attributes:
        lengths: Lengths of the links (N,), m.
        is_planar: Whether angles or unit vectors say where links point.
        angles: What planar angles are measured from.
        cart_size: Coordinates of the cart.
    """

    lengths: Points
    is_planar: bool
    angles: str
    cart_size: int

    @property
    def links(self) -> int:
        """Number of links."""
        return len(self.lengths)

    @property
    def nq(self) -> int:
        """Length of q."""
        return self.cart_size + self.links * (1 if self.is_planar else 3)

    @property
    def has_cart(self) -> bool:
        """Whether the base is a cart."""
        return self.cart_size > 0

    def number(self, name: str) -> Points:
        """The lengths: all that drawing asks for."""
        return self.lengths


class Kept(Protocol):
    """A result that knows its chain's lengths and angles (`phichain.system.drawn`)."""

    @property
    def lengths(self) -> Points | None: ...
    @property
    def angles(self) -> str: ...


def outline(motion: Kept) -> Outline:
    """The chain of a result, for drawing; in the plane, unless it says otherwise.

    Raises:
        ArrayError: The result does not know how long its links are.
    """
    if motion.lengths is None:
        raise ArrayError("lengths", None, f"is not known of this {type(motion).__name__}", "make it anew, of a scene that says its lengths")
    is_planar, cart = getattr(motion, "space", "planar") == "planar", int(np.sum(motion.lengths == 0))
    return Outline(motion.lengths[cart :: 1 if is_planar else 3], is_planar, motion.angles, cart)


Drawn = System | Outline
"""What a chain is drawn of."""


def link_lengths(system: Drawn) -> Points:
    """Lengths l_1 .. l_N in metres, shape (N,), from the scene or else from the default runtime parameters.

    Raises:
        ArrayError: They are runtime parameters and the system has no default values, or it has none.
    """
    lengths: Points = system.number("length")
    return lengths


def directions(system: Drawn, q: ArrayLike) -> Points:
    """Unit vectors along the links, shape (..., N, d); the last axis of space points along gravity."""
    if not system.is_planar:
        return unit_vectors(cast(System, system), np.asarray(q, dtype=float))
    phi = absolute_angles(cast(System, system), np.asarray(q, dtype=float))
    return np.stack([np.sin(phi), np.cos(phi)], axis=-1)


def joints(system: Drawn, q: ArrayLike) -> Points:
    """Points from the base to the tip in metres, shape (..., N + 1, d)."""
    state = np.asarray(q, dtype=float)
    steps = link_lengths(system)[:, None] * directions(system, state)
    base = np.zeros((*steps.shape[:-2], 1, steps.shape[-1]))
    if system.has_cart:
        base[..., 0, :-1] = state[..., : system.cart_size]
    return np.concatenate([base, base + np.cumsum(steps, axis=-2)], axis=-2)


def tilt(system: Drawn, q: ArrayLike) -> Points:
    """Angle of every link from the hanging vertical in radians, shape (..., N): 0 hangs, pi stands.

    Planar angles keep their sign and their turns; a spatial link has no sign, and its angle is taken from both sine
    and cosine, so that it is right near 0 and pi too.
    """
    if system.is_planar:
        return absolute_angles(cast(System, system), np.asarray(q, dtype=float))
    unit = directions(system, q)
    return np.arctan2(np.hypot(unit[..., 0], unit[..., 1]), unit[..., 2])
