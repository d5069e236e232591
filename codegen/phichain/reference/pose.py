"""Numbers and poses of one evaluation, as mpf: where the links point, how they turn, about which axes.

Units are SI; angles in rad, unit vectors without unit. All numbers are `mpmath.mpf` at the precision that is
current when a function is called.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, zip_longest
from typing import Any

from mpmath import fdot, mp, mpf

from phichain.errors import ArrayError, SceneError
from phichain.reference.algebra import Matrix, Vector, cross, tangent_axes, unit
from phichain.reference.nudge import Nudge
from phichain.scene import Scene


@dataclass(frozen=True)
class Parameters:
    """The numbers of a scene: masses (kg), lengths and centres (m), gravity (m/s^2), joints, rotors and the cart's brakes (0 if absent),
    inertias (kg m^2).
    """

    mass: Vector
    length: Vector
    com: Vector
    cart_mass: Any
    gravity: Any
    damping: Vector
    stiffness: Vector
    rest_angle: Vector
    friction: Vector
    friction_speed: Any
    cart_damping: Any
    cart_friction: Any
    cart_friction_speed: Any
    armature: Vector
    inertia: Vector = field(default_factory=list)

    def moments(self, power: int) -> Vector:
        """Return sum_a m_a lever_ak^power for every link k, lever_ak the weight of q_k in r_a: l_k inside, com_a at the mass.

        The second ones hold the link's own inertia.
        """
        beyond, found = mpf(0), []
        for mass, length, com in zip(self.mass[::-1], self.length[::-1], self.com[::-1], strict=True):
            found.append(mass * com**power + beyond * length**power)
            beyond += mass
        own = self.inertia if power == 2 else []
        return [a + b for a, b in zip_longest(found[::-1], own, fillvalue=mpf(0))]

    def decades(self) -> int:
        """Return over how many powers of ten masses, lengths and joints spread, to choose guard digits by."""
        groups = [
            [*self.mass, self.cart_mass or 0],
            [*self.length, *self.com],
            [*self.damping, *self.stiffness, *self.friction, self.cart_damping, self.cart_friction, 1],
            [*self.inertia, 1],
            [*self.armature, 1],
        ]
        sizes = [[abs(entry) for entry in group if entry] for group in groups]
        return sum(int(mp.ceil(mp.log10(max(group) / min(group)))) for group in sizes)

    def nudged(self, nudge: Nudge) -> Parameters:
        """Return all numbers moved; masses at the ends of their links stay there."""
        length = nudge("length", self.length)
        return Parameters(
            mass=nudge("mass", self.mass),
            length=length,
            com=length if self.com is self.length else nudge("com", self.com),
            cart_mass=None if self.cart_mass is None else nudge("cart_mass", [self.cart_mass])[0],
            gravity=nudge("gravity", [self.gravity])[0],
            damping=nudge("damping", self.damping),
            stiffness=nudge("stiffness", self.stiffness),
            inertia=nudge("inertia", self.inertia),
            armature=nudge("armature", self.armature),
            rest_angle=nudge("rest_angle", self.rest_angle),
            friction=nudge("friction", self.friction),
            friction_speed=nudge("friction_speed", [self.friction_speed])[0],
            cart_damping=nudge("cart_damping", [self.cart_damping])[0],
            cart_friction=nudge("cart_friction", [self.cart_friction])[0],
            cart_friction_speed=nudge("cart_friction_speed", [self.cart_friction_speed])[0],
        )


@dataclass(frozen=True)
class Pose:
    """Where the links point and how they turn.

    Attributes:
        direction: q_k, unit vectors in R^d.
        rate: q_k' in 1/s.
        spin: Angular velocities in rad/s: [phi_k'] in the plane, omega_k in space.
        bend: Joint deflections: [relative angle] in the plane, q_{k-1} x q_k in space.
        axes: The axes of each link's own rates: [[1]] in the plane, two or three vectors in space.
        turning: The derivatives of q_k' by those rates: (cos phi, -sin phi), or axis x q_k.
        cart_position: x in m, empty on a fixed base.
        cart_rate: x' in m/s, empty on a fixed base.
    """

    direction: Matrix
    rate: Matrix
    spin: Matrix
    bend: Matrix
    axes: list[Matrix]
    turning: list[Matrix]
    cart_position: Vector
    cart_rate: Vector


def exact(number: Any) -> Any:
    """Return a number of any type (float, NumPy scalar, mpf) as mpf, with exactly its value."""
    return mpf(number) if isinstance(number, mpf) else mpf(float(number))


def parameters(scene: Scene, values: Mapping[str, Any] | None = None) -> Parameters:
    """Return the scene's numbers as mpf, runtime ones taken from `values`.

    Raises:
        SceneError: A runtime parameter has no value.
    """

    def read(name: str) -> Any:
        value = getattr(scene, name)
        if not isinstance(value, str):
            return value
        if values is None or name not in values:
            raise SceneError(name, None, "is a runtime parameter without a value", "pass it in params")
        return values[name]

    def per_link(name: str) -> Vector:
        value = read(name)
        return [mpf(0)] * scene.links if value is None else [exact(entry) for entry in value]

    def single(name: str, absent: int) -> Any:
        value = read(name)
        return mpf(absent) if value is None else exact(value)

    length, cart = per_link("length"), read("cart_mass")
    return Parameters(
        mass=per_link("mass"),
        length=length,
        com=length if scene.com is None else per_link("com"),
        cart_mass=exact(cart or 0.0) if scene.has_cart else None,
        gravity=exact(read("gravity")),
        damping=per_link("damping"),
        stiffness=per_link("stiffness"),
        inertia=[] if scene.inertia is None else per_link("inertia"),
        armature=per_link("armature"),
        rest_angle=per_link("rest_angle"),
        friction=per_link("friction"),
        friction_speed=single("friction_speed", 1),
        cart_damping=single("cart_damping", 0),
        cart_friction=single("cart_friction", 0),
        cart_friction_speed=single("cart_friction_speed", 1),
    )


def cart_axes(scene: Scene) -> int:
    """Return the number of directions the cart is free in: d - 1, none on a fixed base."""
    return (1 if scene.is_planar else 2) if scene.has_cart else 0


def absolute(scene: Scene, theta: Vector) -> Vector:
    """Return phi = S theta (theory section 2): the links' angles from the vertical, of the scene's own; rates alike."""
    match str(scene.angles):
        case "relative":
            return list(accumulate(theta))
        case "adjacent":
            return [own + inner for own, inner in zip(theta, [mpf(0), *theta], strict=False)]
    return list(theta)


def scene_angles(scene: Scene, phi: Vector) -> Vector:
    """Return S^-1 phi."""
    match str(scene.angles):
        case "relative":
            return [own - inner for own, inner in zip(phi, [mpf(0), *phi], strict=False)]
        case "adjacent":
            return list(accumulate(phi, lambda inner, own: own - inner))
    return list(phi)


def pulled_back(scene: Scene, force: Vector) -> Vector:
    """Return S^T force: forces conjugate to phi (N m) as those conjugate to theta."""
    match str(scene.angles):
        case "relative":
            return list(accumulate(reversed(force)))[::-1]
        case "adjacent":
            return [own + outer for own, outer in zip(force, [*force[1:], mpf(0)], strict=True)]
    return list(force)


def pushed_forward(scene: Scene, force: Vector) -> Vector:
    """Return S^-T force: forces conjugate to theta (N m) as those conjugate to phi."""
    match str(scene.angles):
        case "relative":
            return [own - outer for own, outer in zip(force, [*force[1:], mpf(0)], strict=True)]
        case "adjacent":
            return list(accumulate(reversed(force), lambda outer, own: own - outer))[::-1]
    return list(force)


def planar_pose(scene: Scene, q: Vector, v: Vector) -> Pose:
    """Return the pose of a planar chain from q = [x, theta_k] and v = [x', theta_k']."""
    carts = cart_axes(scene)
    phi, spin = (absolute(scene, state[carts:]) for state in (q, v))
    links = [list(mp.cos_sin(angle))[::-1] for angle in phi]
    bend = [[angle - inner] for angle, inner in zip(phi, [mpf(0), *phi], strict=False)]
    return _planar(links, spin, bend, q[:carts], v[:carts])


def spatial_pose(scene: Scene, q: Vector, v: Vector, ambient: bool = False) -> Pose:
    """Return the pose of a spatial chain from q = [x, q_k] and v = [x', omega_k].

    The nearest unit vectors and the tangent parts of the rates are taken, so that a state in floating point
    stands for exactly one consistent state. A link's own rates are the components of omega_k along two
    orthonormal axes of the tangent plane, or along e_1, e_2, e_3 when `ambient`, the form of (16).
    """
    carts = cart_axes(scene)
    q, v = project(scene, q, v)
    links, spin = ([state[k : k + 3] for k in range(carts, len(state), 3)] for state in (q, v))
    return Pose(
        direction=links,
        rate=[cross(omega, link) for omega, link in zip(spin, links, strict=True)],
        spin=spin,
        bend=[cross(inner, link) for inner, link in zip([unit(3, 2), *links], links, strict=False)],
        axes=(axes := [[unit(3, i) for i in range(3)] if ambient else tangent_axes(link) for link in links]),
        turning=[[cross(axis, link) for axis in own] for own, link in zip(axes, links, strict=True)],
        cart_position=q[:carts],
        cart_rate=v[:carts],
    )


def straight_pose(scene: Scene, signs: Sequence[int]) -> Pose:
    """Return the equilibrium q_k = s_k e_d at rest; in space the rates turn about e_1 and e_2 (19)."""
    still = [mpf(0)] * cart_axes(scene)
    if scene.is_planar:
        zero = [mpf(0)] * scene.links
        return _planar([[mpf(0), mpf(s)] for s in signs], zero, [[angle] for angle in zero], still, still)
    links = [[mpf(0), mpf(0), mpf(s)] for s in signs]
    zeros = [[mpf(0)] * 3 for _ in signs]
    axes = [unit(3, 0), unit(3, 1)]
    turning = [[cross(axis, link) for axis in axes] for link in links]
    return Pose(links, zeros, zeros, zeros, [axes] * scene.links, turning, still, still)


def project(scene: Scene, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Return the nearest consistent state: q_k / |q_k|, and omega_k without its part along q_k.

    Raises:
        ArrayError: A link's vector is zero.
    """
    carts = cart_axes(scene)
    q_out, v_out = q[:carts], v[:carts]
    for k in range(carts, len(q), 3):
        size = mp.sqrt(fdot(q[k : k + 3], q[k : k + 3]))
        if not size:
            raise ArrayError(
                "q", q, f"link {1 + (k - carts) // 3} has length 0", "pass vectors that have a direction"
            )
        link = [entry / size for entry in q[k : k + 3]]
        along = fdot(v[k : k + 3], link)
        q_out = q_out + link
        v_out = v_out + [entry - along * part for entry, part in zip(v[k : k + 3], link, strict=True)]
    return q_out, v_out


def _planar(links: Matrix, spin: Vector, bend: Matrix, cart_position: Vector, cart_rate: Vector) -> Pose:
    """Assemble the pose of links q = (sin phi, cos phi), for which dq/dphi = (cos phi, -sin phi)."""
    turning = [[cosine, -sine] for sine, cosine in links]
    return Pose(
        direction=links,
        rate=[[w * entry for entry in turn] for w, turn in zip(spin, turning, strict=True)],
        spin=[[w] for w in spin],
        bend=bend,
        axes=[[unit(1, 0)]] * len(spin),
        turning=[[turn] for turn in turning],
        cart_position=cart_position,
        cart_rate=cart_rate,
    )
