"""The scene: which chain, with which parameters, and which functions of it are wanted.

A `Scene` is immutable, has every default filled in and every value checked, and two scenes that mean the same
are equal and have the same digest, however they were written. Everything else is derived from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from phichain.contract.functions import Sample
from phichain.contract.wanted import wanted
from phichain.scene.digest import digest_of
from phichain.scene.keys import PARAMETERS, PER_LINK, TABLES
from phichain.scene.name import scene_name
from phichain.scene.sketch import sketch
from phichain.scene.toml import write_toml
from phichain.scene.validate import (
    ANY,
    POSITIVE,
    Runtime,
    actuation,
    angle_kind,
    cart_mass_of,
    centre_of_mass,
    check_inertia,
    choice,
    joint_law,
    link_count,
    per_link,
    scalar,
    variational_equations,
)

PerLink = float | Sequence[float] | Runtime


@dataclass(frozen=True, init=False)
class Scene:
    """A chain of N links on a fixed base or a cart, and what is wanted of it.

    Units are the user's, as long as they are consistent (kg, m, s, N throughout the documentation).

    Attributes:
        name: Prefix of every emitted symbol and file.
        links: Number of links N, 1 to 4096.
        space: `"planar"` (d = 2, angles) or `"spatial"` (d = 3, unit vectors).
        base: `"fixed"`, or `"cart"` free in the d - 1 horizontal directions.
        mass: m_k of every link [kg], or `"runtime"`.
        length: l_k of every link [m], or `"runtime"`.
        com: r_k, the distance of the mass from its joint [m], 0 < r_k <= l_k; None when every mass sits at
            its link's end, which a default `com` and one equal to `length` both mean.
        cart_mass: m_0 [kg], or `"runtime"`; None exactly on a fixed base.
        gravity: g [m/s^2] along the last axis, or `"runtime"`.
        angles: `"relative"`, `"absolute"` or `"adjacent"` (docs/theory.md, section 2); None exactly
            on a spatial scene.
        damping: d_k of every joint [N m s/rad], `"runtime"`, or None for a chain without dampers.
        stiffness: k_k of every joint [N m/rad], `"runtime"`, or None for a chain without springs.
        actuated: `"none"`, `"all"`, `"cart"`, or the joints with a torque, counted from 1.
        want: The wanted functions, in the contract's order.
        variational: Whether `propagate` carries the variational equations along.
        real: `"double"` or `"float"`, the type of the emitted C.
        code: `"unrolled"`, `"loops"`, or `"auto"` (by operation count).
    """

    name: str
    links: int
    space: Literal["planar", "spatial"]
    base: Literal["fixed", "cart"]
    mass: tuple[float, ...] | Runtime
    length: tuple[float, ...] | Runtime
    com: tuple[float, ...] | Runtime | None
    cart_mass: float | Runtime | None
    gravity: float | Runtime
    angles: Literal["relative", "absolute", "adjacent"] | None
    damping: tuple[float, ...] | Runtime | None
    stiffness: tuple[float, ...] | Runtime | None
    actuated: Literal["none", "all", "cart"] | tuple[int, ...]
    want: tuple[str, ...]
    variational: bool
    real: Literal["double", "float"]
    code: Literal["auto", "unrolled", "loops"]

    def __init__(
        self,
        name: str,
        links: int,
        space: str = "planar",
        base: str = "fixed",
        *,
        mass: PerLink,
        length: PerLink,
        com: PerLink | None = None,
        cart_mass: float | Runtime | None = None,
        gravity: float | Runtime = 9.81,
        angles: str | None = None,
        damping: PerLink | None = None,
        stiffness: PerLink | None = None,
        actuated: str | Sequence[int] | None = None,
        want: Sequence[str] = ("forward_dynamics",),
        variational: bool = False,
        real: str = "double",
        code: str = "auto",
    ) -> None:
        """Check every value, fill in the defaults and bring all into the one form the attributes describe.

        Raises:
            SceneError: A value is not valid; the message names the key, the value and the remedy.
            UnsupportedError: A wanted function does not exist for such a scene.
        """
        name, links = scene_name(name), link_count(links)
        space = choice("space", space, ("planar", "spatial"))
        base = choice("base", base, ("fixed", "cart"))
        real = choice("real", real, ("double", "float"))
        angles = angle_kind(angles, space)
        mass = per_link("mass", mass, links, POSITIVE, real)
        length = per_link("length", length, links, POSITIVE, real)
        com = None if com is None else centre_of_mass(per_link("com", com, links, POSITIVE, real), length)
        check_inertia(mass, length, com, real)
        damping = joint_law("damping", damping, links, real)
        numbers = (mass, length, com, cart_mass, gravity, damping, stiffness)
        runtime = tuple(value for value in numbers if isinstance(value, str))
        want = wanted(want, Sample(space == "planar", damping, runtime))
        values = {
            "name": name,
            "links": links,
            "space": space,
            "base": base,
            "mass": mass,
            "length": length,
            "com": com,
            "cart_mass": cart_mass_of(cart_mass, base, real),
            "gravity": scalar("gravity", gravity, ANY, real),
            "angles": angles,
            "damping": damping,
            "stiffness": joint_law("stiffness", stiffness, links, real),
            "actuated": actuation(actuated, space, base, links, angles),
            "want": want,
            "variational": variational_equations(variational, want),
            "real": real,
            "code": choice("code", code, ("auto", "unrolled", "loops")),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def is_planar(self) -> bool:
        """Whether the chain moves in a plane, described by angles."""
        return self.space == "planar"

    @property
    def has_cart(self) -> bool:
        """Whether the base is a cart."""
        return self.base == "cart"

    @property
    def has_force(self) -> bool:
        """Whether u holds the horizontal force on the cart."""
        return self.has_cart and self.actuated != "none"

    @property
    def tip_masses(self) -> bool:
        """Whether every mass sits at its link's end (r_k = l_k), structurally."""
        return self.com is None

    @property
    def actuated_joints(self) -> tuple[int, ...]:
        """The joints (angles, unless relative) whose generalised force is part of u, counted from 1."""
        if isinstance(self.actuated, tuple):
            return self.actuated
        return tuple(range(1, self.links + 1)) if self.actuated == "all" else ()

    @property
    def nq(self) -> int:
        """Length of q: the cart's position, then an angle (planar) or a unit vector (spatial) per link."""
        return self._cart_size + self.links * (1 if self.is_planar else 3)

    @property
    def nv(self) -> int:
        """Length of v and a: the cart's velocity, then a rate or an angular velocity per link."""
        return self.nq

    @property
    def nu(self) -> int:
        """Length of u: the force on the cart, then the generalised forces of the joints."""
        return self._cart_size * self.has_force + len(self.actuated_joints)

    @property
    def driven(self) -> tuple[int, ...]:
        """Which entries of v the entries of u act on, in their order: the force the cart, the torques their angles."""
        cart = self._cart_size
        return (*range(cart * self.has_force), *(cart + joint - 1 for joint in self.actuated_joints))

    @property
    def _cart_size(self) -> int:
        """Number of the cart's directions d - 1; zero on a fixed base."""
        return (1 if self.is_planar else 2) * self.has_cart

    @property
    def q_names(self) -> tuple[str, ...]:
        """Names of the entries of q, in order: x, theta_1, ... or x_1, x_2, q_1_1, q_1_2, q_1_3, ..."""
        return self._cart_names("x") + self._link_names("theta", "q")

    @property
    def v_names(self) -> tuple[str, ...]:
        """Names of the entries of v, in order: x_dot, theta_dot_1, ... or x_dot_1, x_dot_2, omega_1_1, ..."""
        return self._cart_names("x_dot") + self._link_names("theta_dot", "omega")

    @property
    def u_names(self) -> tuple[str, ...]:
        """Names of the entries of u, in order: force or force_1, force_2; then torque_k of actuated joints."""
        force = self._cart_names("force") if self.has_force else ()
        return force + tuple(f"torque_{k}" for k in self.actuated_joints)

    def _cart_names(self, stem: str) -> tuple[str, ...]:
        """Name a quantity in the cart's horizontal directions; nothing on a fixed base."""
        if not self.has_cart:
            return ()
        return (stem,) if self.is_planar else (f"{stem}_1", f"{stem}_2")

    def _link_names(self, planar: str, spatial: str) -> tuple[str, ...]:
        """Name a quantity of every link: one scalar each in the plane, three components in space."""
        links = range(1, self.links + 1)
        if self.is_planar:
            return tuple(f"{planar}_{k}" for k in links)
        return tuple(f"{spatial}_{k}_{i}" for k in links for i in (1, 2, 3))

    @property
    def runtime(self) -> tuple[str, ...]:
        """Names of the parameters left to run time, in the order of the emitted `NAME_params`."""
        return tuple(key for key in PARAMETERS if getattr(self, key) == "runtime")

    @property
    def runtime_shapes(self) -> dict[str, tuple[int, ...]]:
        """Shape of every run-time parameter: (N,) per link, () for the whole chain."""
        return {key: (self.links,) if key in PER_LINK else () for key in self.runtime}

    @property
    def digest(self) -> str:
        """SHA-256 (hex) of what the scene says, defaults filled in; equal scenes have equal digests."""
        return digest_of(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as plain nested tables, as a TOML file holds them; absent values are left out."""
        tables = {table: self._table(keys) for table, keys in TABLES.items()}
        return {"name": self.name} | {table: entries for table, entries in tables.items() if entries}

    def _table(self, keys: Sequence[str]) -> dict[str, Any]:
        """Return the present ones of some keys, tuples as the lists that TOML and JSON know.

        What a scene does not ask for is left out, so that it has the digest of one that does not know the key.
        """
        values = {key: getattr(self, key) for key in keys}
        return {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in values.items()
            if value is not None and value is not False
        }

    def to_toml(self) -> str:
        """Return the text of a scene file that loads as this very scene."""
        return write_toml(self.to_dict())

    def __str__(self) -> str:
        """Return the chain as a sketch, with its numbers."""
        return sketch(self)
