"""What every key of a scene file holds: THE table that the scene reference and the JSON Schema are made from.

`keys` says which table of the file holds which key, `validate` and `physical` check the values; here stands what a reader and an
editor want to know of each. A key that has no row here fails a test.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from phichain.contract.bases import bases, drives, places
from phichain.scene.keys import NOT_NEGATIVE, PER_LINK, POSITIVE

Kind = Literal["name", "count", "choice", "parameter", "number", "joints", "place", "functions", "derivatives"]


@dataclass(frozen=True)
class Key:
    """One key of a scene file.

    Attributes:
        name: The key.
        kind: What it holds: the scene's "name", a "count", one word of a "choice", a physical "parameter" (a number, one per link where it
            is the links', or "runtime"), a plain "number", "joints" (a word or a list of them), a "place" (a word or one joint),
            "functions", or "derivatives" (true, false or a list of what they are by).
        text: What it is.
        unit: Its unit, where it has one.
        default: What stands where it is left out, in words; empty where it must be given.
        choices: The words that it may be.
        only: Which other key must be which word for it to be there at all.
        since: The version that had it first.
        most: The largest "count".
    """

    name: str
    kind: Kind
    text: str
    unit: str = ""
    default: str = ""
    choices: tuple[str, ...] = ()
    only: tuple[tuple[str, str], ...] = ()
    since: str = "0.1"
    most: int = 4096

    @property
    def is_per_link(self) -> bool:
        """Whether it holds one number per link."""
        return self.name in PER_LINK

    @property
    def sign(self) -> str:
        """Which numbers it admits: "above zero", "zero or more" or "any"."""
        if self.kind == "number" or self.name in POSITIVE:
            return "above zero"
        return "zero or more" if self.name in NOT_NEGATIVE else "any"

    @property
    def holds(self) -> str:
        """What may be written, in words."""
        if self.kind == "parameter":
            each = "a number for all links, a list of one per link" if self.is_per_link else "a number"
            return f'{each}, or "runtime"; {self.sign}'
        words: dict[str, str] = {
            "name": "a name of C: letters, digits and _, at most 40, no reserved word", "count": f"a whole number from 1 to {self.most}",
            "choice": " or ".join(f'"{word}"' for word in self.choices), "number": f"a number {self.sign}",
            "joints": f"{', '.join(chr(34) + word + chr(34) for word in self.choices)}, or a list of joints such as [1, 2]",
            "place": f"{' or '.join(chr(34) + word + chr(34) for word in self.choices)}, or the number of a joint",
            "functions": "a list of functions by name", "derivatives": 'true, false, or a list of "state", runtime parameters by name and "forcing"',
        }  # fmt: skip
        return words[self.kind]


_CART: Final = (("base", "cart"),)
_PLANAR: Final = (("space", "planar"),)

KEYS: Final[tuple[Key, ...]] = (
    Key("name", "name", "prefix of every emitted symbol and file"),
    Key("links", "count", "number of links N"),
    Key("space", "choice", "motion in the vertical plane, by angles, or in space, by unit vectors", default="planar", choices=("planar", "spatial")),
    Key(
        "base", "choice", "where the chain hangs: fixed, on a cart free to move horizontally, or moved, its acceleration an input",
        default="fixed", choices=bases(),
    ),
    Key("mass", "parameter", "mass of every link", "kg"),
    Key("length", "parameter", "length of every link, joint to joint", "m"),
    Key(
        "com", "parameter", "distance of the centre of mass from the joint; at most the length for a link without inertia", "m",
        default="the length: masses at the links' ends",
    ),
    Key("inertia", "parameter", "moment of inertia about the centre of mass, the axis across the link", "kg m^2", default="point masses"),
    Key("cart_mass", "parameter", "mass of the cart; may be left out where drive is acceleration", "kg", only=_CART),
    Key("cart_damping", "parameter", "damper of the cart", "N s/m", default="none", only=_CART),
    Key("cart_friction", "parameter", "dry friction F of the cart, F tanh(v / v_0)", "N", default="none", only=_CART),
    Key("cart_friction_speed", "number", "v_0 of the cart's friction; with friction only", "m/s", default="joints.friction_speed", only=_CART),
    Key(
        "drive", "choice", "what drives the cart: a force, or its acceleration, which is then the input", default="force",
        choices=drives("cart"), only=_CART,
    ),
    Key("gravity", "parameter", "gravity along the last axis", "m/s^2", default="9.81"),
    Key(
        "angles", "choice", "what the joint angles are measured from (docs/theory.md, section 2)", default="relative",
        choices=("relative", "absolute", "adjacent"), only=_PLANAR,
    ),
    Key("damping", "parameter", "damper of every joint", "N m s/rad", default="none"),
    Key("stiffness", "parameter", "spring of every joint", "N m/rad", default="none"),
    Key("rest_angle", "parameter", "angle against the link before at which the joint's spring rests; with stiffness only", "rad", default="0", only=_PLANAR),
    Key("friction", "parameter", "dry friction F of every joint, F tanh(v / v_0) with the relative rate", "N m", default="none"),
    Key("friction_speed", "number", "v_0 of the joints' friction; with friction only", "rad/s", default="none"),
    Key("armature", "parameter", "inertia of a motor's rotor at every joint, turning with the relative rate", "kg m^2", default="none", only=_PLANAR),
    Key(
        "actuated", "joints", "where inputs act: nowhere, at all joints, on the cart, or at the joints listed",
        default='"cart" on a cart, else "none"', choices=("none", "all", "cart"),
    ),
    Key("want", "functions", "the functions to derive, emit and compile; only these cost anything", default='["forward_dynamics"]'),
    Key("variational", "derivatives", "what propagate carries derivatives of the state by: the state, parameters, the forcing", default="false"),
    Key("forced", "place", "what A cos(omega t) drives, amplitude and omega being arguments of propagate", choices=places(), default="nothing", since="0.2"),
    Key("axis", "count", "along which axis a cart or a moving base is forced, counted from 1", default="1", since="0.2", most=3),
    Key("real", "choice", "type of the emitted C", default="double", choices=("double", "float")),
    Key("code", "choice", "straight code, loops, or by the number of operations", default="auto", choices=("auto", "unrolled", "loops")),
    Key(
        "trig", "choice", "who computes sines and cosines: the C library, code of our own, or a function of yours", since="0.2",
        default="a kernel that vectorises, the C library beyond its range", choices=("libm", "bundled", "hook"),
    ),
    Key("trig_hook", "name", "name of your function for sines and cosines; with trig = hook only", default="none", since="0.2", only=(("trig", "hook"),)),
    Key("stack_max", "count", "largest stack that a function may take; generation refuses beyond", "bytes", default="no limit", since="0.2", most=2**31 - 1),
    Key("flash_max", "count", "largest flash that the functions may take; generation refuses beyond", "bytes", default="no limit", since="0.2", most=2**31 - 1),
)  # fmt: skip
"""Every key, in the order of the file."""

BY_NAME: Final = {key.name: key for key in KEYS}
