"""The chains whose Programs and Models are mutated: small ones of every kind."""

from __future__ import annotations

from functools import cache

from phichain.contract.functions import PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS
from phichain.lowering import Lowered, lower
from phichain.mechanics import derive
from phichain.scene import Scene

PLANAR = tuple(name for name in PLANAR_FUNCTIONS if name != "propagate") + ("momentum", "tensions")
SPATIAL = tuple(name for name in SPATIAL_FUNCTIONS if name != "propagate") + ("momentum", "tensions")
DAMPED = tuple(name for name in PLANAR if not name.startswith("phi"))
LIGHT = ("forward_dynamics", "inverse_dynamics", "energy", "momentum", "tensions")
TWO = {"mass": [0.3, 0.2], "length": [0.5, 0.4]}
DRY = {"stiffness": 1.0, "rest_angle": 0.3, "damping": 0.1, "friction": [0.1, 0.2], "friction_speed": 0.5}
THREE = {"mass": [0.3, 0.2, 0.1], "length": [0.5, 0.4, 0.3]}

SCENES = {
    scene.name: scene
    for scene in (
        Scene("tips", 2, **TWO, actuated="all", want=PLANAR),
        Scene("coms", 2, **TWO, com=[0.2, 0.3], actuated="all", want=PLANAR),
        Scene("carted", 2, base="cart", cart_mass=0.7, **TWO, com=[0.2, 0.3], stiffness=[1.5, 0.5], want=PLANAR),
        Scene("damped", 2, **TWO, com=[0.2, 0.3], stiffness=1.0, damping=[0.1, 0.2], want=DAMPED),
        Scene("adjacent", 3, **THREE, angles="adjacent", actuated="all", want=PLANAR),
        Scene("absolute", 3, **THREE, com=0.2, angles="absolute", actuated="all", want=PLANAR, code="loops"),
        Scene("runtime", 2, mass="runtime", length="runtime", com="runtime", gravity="runtime", want=PLANAR, code="loops"),
        Scene("spatial", 2, space="spatial", **TWO, want=SPATIAL),
        Scene("flying", 2, space="spatial", base="cart", cart_mass=0.7, **TWO, com=[0.2, 0.3], want=SPATIAL),
        Scene("stiff", 2, **TWO, com=[0.2, 0.3], stiffness=1.0, damping=0.2, want=("step_rosenbrock",)),
        Scene("stiff_flying", 2, space="spatial", base="cart", cart_mass=0.7, **TWO, damping=0.2, want=("step_rosenbrock",)),
        Scene("rods", 2, base="cart", cart_mass=0.7, **TWO, com=[0.2, 0.5], inertia=[0.01, 0.02], actuated="all", want=PLANAR),
        Scene("wheel", 2, **TWO, com=[0.2, 0.0], inertia="runtime", damping=[0.1, 0.2], want=DAMPED, code="loops"),
        Scene("bars", 2, space="spatial", **TWO, com=[0.2, 0.0], inertia=[0.01, 0.02], want=SPATIAL),
        Scene("lightly", 3, base="cart", cart_mass=0.7, mass=[0.01, 0.02, 50.0], length=[36.0, 56.0, 0.25], com=[21.0, 33.0, 0.125],
              actuated="all", want=LIGHT, code="loops"),
        Scene("lightly_walled", 3, mass=[0.01, 0.02, 50.0], length=[36.0, 56.0, 0.25], com=[21.0, 33.0, 0.125], want=LIGHT),
        Scene("geared", 2, **TWO, com=[0.2, 0.3], armature="runtime", actuated="all", want=PLANAR),
        Scene(
            "geared_cart", 3, base="cart", cart_mass=0.7, **THREE, armature=[0.1, 0.0, 0.3], angles="adjacent", want=PLANAR,
            code="loops",
        ),
        Scene("geared_stiff", 2, **TWO, com=[0.2, 0.3], armature=[0.1, 0.2], damping=0.2, want=("step_rosenbrock",)),
        Scene("braked", 2, base="cart", cart_mass=0.7, cart_damping=0.3, cart_friction=0.4, cart_friction_speed=0.5, **TWO, **DRY,
              actuated="all", want=DAMPED),
        Scene("stuck", 2, base="cart", cart_mass=0.7, cart_friction=0.4, cart_friction_speed=0.5, **TWO, **DRY, com=[0.2, 0.3],
              want=("step_rosenbrock",)),
        Scene("trolley", 2, space="spatial", base="cart", cart_mass=0.7, cart_damping=0.3, **TWO, want=SPATIAL),
        Scene("stiff_trolley", 2, space="spatial", base="cart", cart_mass=0.7, cart_damping=0.3, **TWO, stiffness=0.5, want=("step_rosenbrock",)),
        Scene("sprung", 2, space="spatial", **TWO, com=[0.2, 0.3], stiffness=1.0, damping=0.2, want=SPATIAL, code="loops"),
        Scene("shaken", 2, base="moving", **TWO, com=[0.2, 0.3], actuated="all", want=PLANAR),
        Scene("stepper", 2, base="cart", drive="acceleration", cart_mass=0.7, **TWO, actuated="all", want=DAMPED),
        Scene("shaken_space", 2, space="spatial", base="moving", **TWO, com=[0.2, 0.3], want=SPATIAL),
        Scene("stiff_shaken", 2, base="moving", **TWO, com=[0.2, 0.3], want=("step_rosenbrock",)),
        Scene("stiff_stepper", 2, space="spatial", base="cart", drive="acceleration", **TWO, want=("step_rosenbrock",)),
        Scene("stepper_space", 2, space="spatial", base="cart", drive="acceleration", **TWO, want=SPATIAL),
    )
}  # fmt: skip


@cache
def lowered(name: str) -> Lowered:
    return lower(derive(SCENES[name]))
