"""The scene: which chain, with which parameters, and which functions of it are wanted.

A `Scene` is immutable, has every default filled in and every value checked, and two scenes that mean the same
are equal and have the same digest, however they were written. Everything else is derived from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from html import escape
from typing import Any, Literal

from phichain.contract.bases import bases, drives
from phichain.contract.chain import Sample
from phichain.contract.wanted import wanted
from phichain.scene.checks.forcing import Forced, forcing_of
from phichain.scene.checks.name import scene_name
from phichain.scene.checks.physical import (
    armature_of,
    cart_law,
    cart_mass_of,
    check_inertia,
    com_of,
    drive_of,
    friction_speeds,
    inertia_of,
    joint_law,
    rest_angle_of,
)
from phichain.scene.checks.target import limit, trig_of
from phichain.scene.checks.validate import (
    ANY,
    POSITIVE,
    Runtime,
    actuation,
    angle_kind,
    choice,
    link_count,
    per_link,
    scalar,
    variational_equations,
)
from phichain.scene.digest import digest_of
from phichain.scene.keys import PARAMETERS, PER_LINK, TABLES
from phichain.scene.sketch import sketch
from phichain.scene.toml import write_toml
from phichain.scene.vectors import Vectors

PerLink = float | Sequence[float] | Runtime


@dataclass(frozen=True, init=False)
class Scene(Vectors):
    """A chain of N links on a fixed base or a cart, and what is wanted of it.

    Units are the user's, as long as they are consistent (kg, m, s, N throughout the documentation).

    Attributes:
        name: Prefix of every emitted symbol and file.
        links: Number of links N, 1 to 4096.
        space: `"planar"` (d = 2, angles) or `"spatial"` (d = 3, unit vectors).
        base: `"fixed"`, `"cart"` free in the d - 1 horizontal directions, or `"moving"`: its acceleration is an input.
        mass: m_k of every link [kg], or `"runtime"`.
        length: l_k of every link [m], or `"runtime"`.
        com: r_k, the distance of the mass from its joint [m], 0 < r_k <= l_k, and any r_k >= 0 of a link with
            inertia; None when every mass sits at its link's end, which a default `com` and one equal to `length` mean.
        inertia: J_k of every link about its centre of mass, the axis across the link [kg m^2], or `"runtime"`; None for
            point masses.
        cart_mass: m_0 [kg], or `"runtime"`; None without a cart, and where one driven by its acceleration is given none.
        cart_damping: d_0 of the cart [N s/m], `"runtime"`, or None.
        cart_friction: dry friction F_0 of the cart [N], F_0 tanh(x' / v_0), `"runtime"`, or None.
        cart_friction_speed: v_0 of the cart's friction [m/s]; None exactly without it.
        drive: `"force"`, or `"acceleration"` for a cart whose acceleration is the input; None exactly without a cart.
        gravity: g [m/s^2] along the last axis, or `"runtime"`.
        angles: `"relative"`, `"absolute"` or `"adjacent"` (docs/theory.md, section 2); None exactly
            on a spatial scene.
        damping: d_k of every joint [N m s/rad], `"runtime"`, or None for a chain without dampers.
        stiffness: k_k of every joint [N m/rad], `"runtime"`, or None for a chain without springs.
        rest_angle: the angle of every joint against the link before at which its spring rests [rad], `"runtime"`, or None
            where all rest at zero.
        friction: dry friction F_k of every joint [N m], F_k tanh(theta_k' / v_0) with the relative rate, `"runtime"`, or None.
        friction_speed: v_0 of the joints' friction [rad/s]; None exactly without it.
        armature: A_k, the inertia of a motor's rotor at every joint [kg m^2], A_k/2 theta_k'^2 with the relative rate,
            `"runtime"`, or None.
        actuated: `"none"`, `"all"`, `"cart"`, or the joints with a torque, counted from 1.
        want: The wanted functions, in the contract's order.
        variational: Whether `propagate` carries the variational equations along; where it carries derivatives by parameters, too,
            the names of all that they are by, `"state"` first, `"forcing"` last for amplitude and omega.
        forced: what A cos(omega t) drives, amplitude and omega being arguments of `propagate`: the torque at a joint, counted
            from 1, the force on the `"cart"` (or its acceleration, where that drives it), or the acceleration of a moving `"base"`;
            None without forcing.
        axis: along which axis a cart or a base is forced, counted from 1; None exactly where neither is.
        real: `"double"` or `"float"`, the type of the emitted C.
        code: `"unrolled"`, `"loops"`, or `"auto"` (by operation count).
        trig: who computes sines and cosines: `"libm"`, `"bundled"`, `"hook"`, or None for a kernel that vectorises and leaves
            large angles to the C library.
        trig_hook: name of the user's function; None exactly without a hook.
        stack_max: bytes of stack that no function may exceed on a Cortex-M4F, or None.
        flash_max: the same of code and constants.
    """

    name: str
    links: int
    space: Literal["planar", "spatial"]
    base: str
    mass: tuple[float, ...] | Runtime
    length: tuple[float, ...] | Runtime
    com: tuple[float, ...] | Runtime | None
    inertia: tuple[float, ...] | Runtime | None
    cart_mass: float | Runtime | None
    cart_damping: float | Runtime | None
    cart_friction: float | Runtime | None
    cart_friction_speed: float | None
    drive: str | None
    gravity: float | Runtime
    angles: Literal["relative", "absolute", "adjacent"] | None
    damping: tuple[float, ...] | Runtime | None
    stiffness: tuple[float, ...] | Runtime | None
    rest_angle: tuple[float, ...] | Runtime | None
    friction: tuple[float, ...] | Runtime | None
    friction_speed: float | None
    armature: tuple[float, ...] | Runtime | None
    actuated: Literal["none", "all", "cart"] | tuple[int, ...]
    want: tuple[str, ...]
    variational: bool | tuple[str, ...]
    forced: Forced | None
    axis: int | None
    real: Literal["double", "float"]
    code: Literal["auto", "unrolled", "loops"]
    trig: Literal["libm", "bundled", "hook"] | None
    trig_hook: str | None
    stack_max: int | None
    flash_max: int | None

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
        inertia: PerLink | None = None,
        cart_mass: float | Runtime | None = None,
        cart_damping: float | Runtime | None = None,
        cart_friction: float | Runtime | None = None,
        cart_friction_speed: float | None = None,
        drive: str | None = None,
        gravity: float | Runtime = 9.81,
        angles: str | None = None,
        damping: PerLink | None = None,
        stiffness: PerLink | None = None,
        rest_angle: PerLink | None = None,
        friction: PerLink | None = None,
        friction_speed: float | None = None,
        armature: PerLink | None = None,
        actuated: str | Sequence[int] | None = None,
        want: Sequence[str] = ("forward_dynamics",),
        variational: bool | Sequence[str] = False,
        forced: int | str | None = None,
        axis: int | None = None,
        real: str = "double",
        code: str = "auto",
        trig: str | None = None,
        trig_hook: str | None = None,
        stack_max: int | None = None,
        flash_max: int | None = None,
    ) -> None:
        """Check every value, fill in the defaults and bring all into the one form the attributes describe.

        Raises:
            SceneError: A value is not valid; the message names the key, the value and the remedy.
            UnsupportedError: A wanted function does not exist for such a scene.
        """
        name, links = scene_name(name), link_count(links)
        space = choice("space", space, ("planar", "spatial"))
        base = choice("base", base, bases())
        real = choice("real", real, ("double", "float"))
        angles = angle_kind(angles, space)
        actuated = actuation(actuated, space, base, links, angles)
        drive = drive_of(drive, base, actuated)
        physical: dict[str, Any] = {
            "mass": per_link("mass", mass, links, POSITIVE, real),
            "length": per_link("length", length, links, POSITIVE, real),
            "inertia": inertia_of(inertia, links, real),
            "cart_mass": cart_mass_of(cart_mass, base, drive, real),
            "cart_damping": cart_law("cart_damping", cart_damping, base, real),
            "cart_friction": cart_law("cart_friction", cart_friction, base, real),
            "gravity": scalar("gravity", gravity, ANY, real),
            "damping": joint_law("damping", damping, links, base, real),
            "stiffness": joint_law("stiffness", stiffness, links, base, real),
            "friction": joint_law("friction", friction, links, base, real),
            "armature": armature_of(armature, space, links, real),
        }
        bodies = physical["mass"], physical["length"], com_of(com, physical["length"], physical["inertia"], links, real)
        check_inertia(*bodies, physical["inertia"], real)
        rest_angle = rest_angle_of(rest_angle, physical["stiffness"], space, links, real)
        physical |= {"com": bodies[-1], "rest_angle": rest_angle}
        runtime = tuple(key for key in PARAMETERS if physical[key] == "runtime")
        kind = {field.name: physical[field.name] for field in fields(Sample) if field.name in physical}
        want = wanted(want, Sample(is_planar=space == "planar", base=base, drive=drive, runtime=runtime, **kind))
        place, along = forcing_of(forced, axis, space, base, links, want)
        speeds = friction_speeds(
            physical["friction"], physical["cart_friction"], friction_speed, cart_friction_speed, real, (friction, cart_friction)
        )
        trig, trig_hook = trig_of(trig, trig_hook, want, name)
        values = physical | {
            "name": name,
            "links": links,
            "space": space,
            "base": base,
            "drive": drive,
            "friction_speed": speeds[0],
            "cart_friction_speed": speeds[1],
            "angles": angles,
            "actuated": actuated,
            "want": want,
            "variational": variational_equations(variational, want, runtime, place is not None),
            "forced": place,
            "axis": along,
            "real": real,
            "code": choice("code", code, ("auto", "unrolled", "loops")),
            "trig": trig,
            "trig_hook": trig_hook,
            "stack_max": limit("stack_max", stack_max),
            "flash_max": limit("flash_max", flash_max),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def runtime(self) -> tuple[str, ...]:
        """Names of the parameters left to run time, in the order of the emitted `NAME_params`."""
        return tuple(key for key in PARAMETERS if getattr(self, key) == "runtime")

    @property
    def runtime_shapes(self) -> dict[str, tuple[int, ...]]:
        """Shape of every run-time parameter: (N,) per link, () for the whole chain."""
        return {key: (self.links,) if key in PER_LINK else () for key in self.runtime}

    @property
    def varied(self) -> dict[str, int]:
        """What beside the state the flow carries derivatives by, and how many numbers each is, in their order in C."""
        names = self.variational if isinstance(self.variational, tuple) else ()
        sizes = {name: self.links if name in PER_LINK else 1 for name in names if name not in ("state", "forcing")}
        return sizes | (dict.fromkeys(("amplitude", "omega"), 1) if "forcing" in names else {})

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
        values, usual = {key: getattr(self, key) for key in keys}, next(iter(drives(self.base)), None)
        return {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in values.items()
            if value is not None and value is not False and (key, value) != ("drive", usual)
        }

    def to_toml(self) -> str:
        """Return the text of a scene file that loads as this very scene."""
        return write_toml(self.to_dict())

    def __str__(self) -> str:
        """Return the chain as a sketch, with its numbers."""
        return sketch(self)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"
