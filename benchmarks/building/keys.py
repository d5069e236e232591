"""What each key of a scene costs: the same chain with it and without."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks import plan, table
from benchmarks.building.measured import SMALL, measure

LINKS: Mapping[str, Any] = {"mass": (1.0, 1.2, 1.4, 1.6), "length": (0.4, 0.5, 0.6, 0.7)}
FUNCTIONS = {
    "planar": ("forward_dynamics", "inverse_dynamics", "mass_matrix", "energy", "positions"),
    "spatial": ("forward_dynamics", "direction_dynamics", "mass_matrix", "energy", "positions"),
}
FRICTION = {"friction": 0.1, "friction_speed": 0.05}
CART_FRICTION = {"cart_friction": 0.4, "cart_friction_speed": 0.02}
CART = {"base": "cart", "cart_mass": 2.0}
PLANAR: Mapping[str, Mapping[str, Any]] = {
    "com": {"com": (0.2, 0.25, 0.3, 0.35)},
    "inertia, com": {"inertia": (0.01, 0.02, 0.03, 0.04), "com": (0.2, 0.25, 0.3, 0.35)},
    "armature": {"armature": (0.0, 0.01, 0.02, 0.03)},
    "armature, inertia, com": {
        "armature": (0.0, 0.01, 0.02, 0.03),
        "inertia": (0.01, 0.02, 0.03, 0.04),
        "com": (0.2, 0.25, 0.3, 0.35),
    },
    "damping": {"damping": 0.05},
    "friction, friction_speed": FRICTION,
    "stiffness": {"stiffness": 1.5},
    "stiffness, rest_angle": {"stiffness": 1.5, "rest_angle": (0.1, 0.2, 0.3, 0.4)},
    "base = moving": {"base": "moving"},
    "base = cart": CART,
    "base = cart, cart_damping": {**CART, "cart_damping": 0.3},
    "base = cart, cart_friction, cart_friction_speed": {**CART, **CART_FRICTION},
    "base = cart, drive = acceleration": {"base": "cart", "drive": "acceleration"},
}
SPATIAL: Mapping[str, Mapping[str, Any]] = {
    "com": {"com": (0.2, 0.25, 0.3, 0.35)},
    "inertia, com": {"inertia": (0.01, 0.02, 0.03, 0.04), "com": (0.2, 0.25, 0.3, 0.35)},
    "damping": {"damping": 0.05},
    "friction, friction_speed": FRICTION,
    "stiffness": {"stiffness": 1.5},
    "base = moving": {"base": "moving"},
    "base = cart": CART,
    "base = cart, cart_damping": {**CART, "cart_damping": 0.3},
    "base = cart, cart_friction, cart_friction_speed": {**CART, **CART_FRICTION},
    "base = cart, drive = acceleration": {"base": "cart", "drive": "acceleration"},
}
NOTE = (
    "Four links of known masses and lengths; operations as the manifest counts them,"
    + f" `.text` of these functions together, compiled with `{' '.join(SMALL)}`. No key, no operation:"
    + " the first row is a chain that names none of them."
)


def tables(run: plan.Plan) -> list[table.Table]:
    """One table of planar chains, one of spatial ones."""
    from phichain import Scene

    made = []
    for space, keys in (("planar", PLANAR), ("spatial", SPATIAL)):
        rows = []
        for name, given in {"none": {}, **dict(run.few([*keys.items()]))}.items():
            scene = Scene("keys", 4, space=space, want=FUNCTIONS[space], **LINKS, **given)
            found = measure(scene)
            rows.append((name, *(str(found.operations[each]) for each in FUNCTIONS[space]), str(found.text)))
        made.append(
            table.Table(
                f"Key by key, {space} N = 4",
                ("keys", *map("`{}`".format, FUNCTIONS[space]), ".text bytes"),
                tuple(rows),
                (NOTE,),
            )
        )
    return made
