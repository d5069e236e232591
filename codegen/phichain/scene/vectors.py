"""What the entries of q, v and u of a chain are, in order: their number and their names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from phichain.contract.bases import BaseLaw, axes_of, law_of


class Vectors:
    """The sizes and names of a scene's vectors, by what its base is and where its inputs act."""

    if TYPE_CHECKING:
        links: int
        space: str
        base: str
        com: object
        inertia: object
        drive: str | None
        actuated: str | tuple[int, ...]

    @property
    def is_planar(self) -> bool:
        """Whether the chain moves in a plane, described by angles."""
        return self.space == "planar"

    @property
    def dimensions(self) -> int:
        """d, the components of a vector of the chain's space; the last is along gravity."""
        return 2 if self.is_planar else 3

    @property
    def base_law(self) -> BaseLaw:
        """What carries the chain."""
        return law_of(self.base, self.drive)

    @property
    def has_cart(self) -> bool:
        """Whether the base is a cart: it has coordinates."""
        return self.base_law.is_placed

    @property
    def is_moving(self) -> bool:
        """Whether the base is moved and has no coordinates: accelerations of it are inputs."""
        return self.base_law.is_told and not self.has_cart

    @property
    def has_force(self) -> bool:
        """Whether u holds what drives the cart: the horizontal force on it, or its acceleration (`is_driven`)."""
        return self.has_cart and self.actuated != "none"

    @property
    def is_driven(self) -> bool:
        """Whether the cart is driven by its acceleration, which u then holds, instead of by a force."""
        return self.base_law.is_told and self.has_cart

    @property
    def told_axes(self) -> tuple[int, ...]:
        """The axes, counted from 0, along which entries of u, the first ones, are the base's acceleration."""
        law = self.base_law
        return axes_of(law.told, self.dimensions) if self.is_moving or self.has_force else ()

    @property
    def tip_masses(self) -> bool:
        """Whether links are points at their ends (r_k = l_k without inertia), structurally."""
        return self.com is None and self.inertia is None

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
        """Length of u: what drives the base, then the generalised forces of the joints."""
        return self.base_inputs + len(self.actuated_joints)

    @property
    def base_inputs(self) -> int:
        """How many entries of u, the first ones, drive the base."""
        return len(self.told_axes) or self._cart_size * self.has_force

    @property
    def base_accelerations(self) -> int:
        """How many entries of u, the first ones, are accelerations of the base; all others are generalised forces."""
        return len(self.told_axes)

    @property
    def has_free_cart(self) -> bool:
        """Whether the base is a cart that forces move, so that it has an equation of motion of its own."""
        return self.has_cart and not self.is_driven

    @property
    def driven(self) -> tuple[int, ...]:
        """Which entries of v the forces in u act on, in their order: that on the cart, the torques on their angles."""
        cart = self._cart_size
        forces = cart * (self.has_force and not self.is_driven)
        return (*range(forces), *(cart + joint - 1 for joint in self.actuated_joints))

    @property
    def _cart_size(self) -> int:
        """Number of the cart's directions d - 1; zero on a fixed base."""
        return len(axes_of(self.base_law.placed, self.dimensions))

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
        """Names of the entries of u, in order: what drives the base, then torque_k of actuated joints.

        force or force_1, force_2 on a cart; acceleration or acceleration_1, acceleration_2 where it is driven by that;
        base_acceleration_1 to base_acceleration_d of a moving base, the last one down.
        """
        stem = self.base_law.input
        base = self._cart_names(stem) if self.has_force else ()
        if self.is_moving:
            base = tuple(f"{stem}_{axis + 1}" for axis in self.told_axes)
        return base + tuple(f"torque_{k}" for k in self.actuated_joints)

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
