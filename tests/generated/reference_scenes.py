"""The three small scenes whose generated folders are committed under generated/reference/."""

from __future__ import annotations

from pathlib import Path

from phichain.scene import Scene, standard_scene
from phichain.contract.functions import SPATIAL_FUNCTIONS

FOLDER = Path(__file__).parents[2] / "generated" / "reference"

REFERENCE = {
    scene.name: scene
    for scene in (
        standard_scene(2),
        Scene(
            "spatial2_cart", 2, space="spatial", base="cart", mass=[0.2, 0.1], length=[0.3, 0.2], cart_mass=0.5,
            want=SPATIAL_FUNCTIONS, code="loops",
        ),
        Scene(
            "cart1_float", 1, base="cart", mass="runtime", length="runtime", com="runtime", cart_mass="runtime",
            gravity="runtime", damping="runtime", stiffness="runtime", real="float", code="unrolled",
            want=["forward_dynamics", "energy", "linearization", "state_jacobian", "step"],
        ),
    )
}  # fmt: skip
"""Paper A's double pendulum with every function, straight-line code; a spatial chain on a cart with loops; and for a
microcontroller: one link on a cart in single precision, spring, damper and every number open until run time."""
