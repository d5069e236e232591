"""What numerics may know of a chain besides its callables: its numbers, its joints, and what its inputs push."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError

Angles = Literal["relative", "absolute", "adjacent"]
ANGLES: Final[tuple[Angles, ...]] = get_args(Angles)
"""The kinds of planar angles (docs/theory.md, 2)."""

Runtime = Literal["runtime"]
RUNTIME: Final[Runtime] = "runtime"
PerLink = tuple[float, ...] | Runtime


class _Given:
    """Numbers of a chain, one per link or one for all, each brought into the one form that is kept."""

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            object.__setattr__(self, field.name, _kept(field.name, getattr(self, field.name)))


def _kept(name: str, value: Any) -> Any:
    if value is None or isinstance(value, str) and value == RUNTIME:
        return value
    try:
        given: NDArray[np.float64] = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        given = np.full((1, 1), np.nan)
    if given.ndim > 1 or not np.all(np.isfinite(given)):
        raise ArrayError(name, value, "is no number, nor one per link", f'give finite numbers, or "{RUNTIME}"')
    return float(given) if given.ndim == 0 else tuple(given.tolist())


@dataclass(frozen=True)
class Numbers(_Given):
    """Sizes of a chain, as its scene has them: numbers, "runtime", or None where they are not known.

    Attributes:
        mass: m_k of every link, kg.
        length: l_k of every link, m.
        com: r_k, the distance of the mass from its joint, m; None where every mass sits at its link's end.
        cart_mass: m_0, kg; None on a fixed base.
        gravity: g, m/s^2.
        inertia: J_k of every link about its centre of mass, kg m^2, or None for point masses.
        cart_damping: d_0 of the cart, N s/m, or None.
        cart_friction: dry friction F_0 tanh(x' / v_0) of the cart, N, or None.
        cart_friction_speed: its v_0, m/s.

    Raises:
        ArrayError: A value is no number.
    """

    mass: PerLink | None = None
    length: PerLink | None = None
    com: PerLink | None = None
    cart_mass: float | Runtime | None = None
    gravity: float | Runtime | None = None
    inertia: PerLink | None = None
    cart_damping: float | Runtime | None = None
    cart_friction: float | Runtime | None = None
    cart_friction_speed: float | None = None

    @property
    def brakes_cart(self) -> bool:
        """True where something resists the cart's speed."""
        return self.cart_damping is not None or self.cart_friction is not None


@dataclass(frozen=True)
class Joints(_Given):
    """What acts between links; nothing unless said.

    Attributes:
        stiffness: k_k of every joint, N m/rad, or None for a chain without springs.
        damping: d_k of every joint, N m s/rad, or None for a chain without dampers.
        armature: A_k of the rotor at every joint, kg m^2, or None for a chain without rotors.
        rest_angle: angles of the joints at which their springs rest, rad, or None where all rest at zero.
        friction: dry friction F_k tanh(theta_k' / v_0) of every joint, N m, or None.
        friction_speed: its v_0, rad/s.

    Raises:
        ArrayError: A value is no number.
    """

    stiffness: PerLink | None = None
    damping: PerLink | None = None
    armature: PerLink | None = None
    rest_angle: PerLink | None = None
    friction: PerLink | None = None
    friction_speed: float | None = None

    @property
    def is_free(self) -> bool:
        """True without springs, dampers and dry friction."""
        return self.stiffness is None and not self.resists

    @property
    def resists(self) -> bool:
        """True where something resists the joints' rates."""
        return self.damping is not None or self.friction is not None


@dataclass(frozen=True)
class Drive:
    """What the inputs do: the first ones may give the base its acceleration, every other is the generalised force of an entry of v.

    Attributes:
        coordinates: Which one, counted from 0, for every force in u; a System takes none said as the first ones.
        accelerations: How many entries of u, the first ones, are accelerations of the base.
        axes: Along which axes these are, counted from 0; the first ones unless said.
    """

    coordinates: tuple[int, ...] = ()
    accelerations: int = 0
    axes: tuple[int, ...] = ()

    def forces(self, u: ArrayLike, nv: int) -> NDArray[np.float64]:
        """The generalised forces (..., nv) of inputs (..., nu)."""
        given = np.asarray(u, dtype=float)[..., self.accelerations :]
        pushed = np.zeros((*given.shape[:-1], nv))
        pushed[..., list(self.coordinates)] = given
        return pushed


def drive_of(drive: Drive, nu: int, nv: int) -> Drive:
    """A drive that fits the sizes: the first coordinates unless said.

    Raises:
        ArrayError: Not one coordinate per force, or one that there is not, or one twice.
    """
    forces = nu - drive.accelerations
    axes = tuple(int(k) for k in drive.axes or range(drive.accelerations))
    made = Drive(tuple(int(k) for k in drive.coordinates or range(forces)), drive.accelerations, axes)
    known = set(made.coordinates) <= set(range(nv)) and len(set(made.coordinates)) == len(made.coordinates)
    if not known or len(made.coordinates) != forces:
        raise ArrayError(
            "drive.coordinates", made.coordinates, f"must hold {forces} different numbers below {nv}", "name one entry of v per force"
        )  # fmt: skip
    return made


def angles_of(angles: str | None, is_planar: bool) -> Angles | None:
    """The kind of a planar chain's angles, "relative" unless said; None in space.

    Raises:
        ArrayError: No such kind, or one in space.
    """
    if not is_planar:
        if angles is not None:
            raise ArrayError("angles", angles, "belongs to a planar chain", "leave it out for a spatial one")
        return None
    kind = next((known for known in ANGLES if known == (angles or "relative")), None)
    if kind is None:
        raise ArrayError("angles", angles, "is no kind of angles", f"use {', '.join(ANGLES)}")
    return kind
