"""The committed rigs hold the numbers that `rigs` makes of their data sheets, and the Acrobot moves as published."""

from __future__ import annotations

import numpy as np

from phichain import rigs
from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene.library import find_scene


def test_the_cart_pole_is_its_data_sheet() -> None:
    scene = find_scene("rig_cart_pole")
    motor = rigs.Motor(torque_constant=0.00767, resistance=2.6, rotor_inertia=3.90e-7)
    cart = rigs.belt_cart(motor, 6.35e-3, 0.57 + 0.37, gear=3.71, voltage=6.0, cart_damping=5.4)
    assert abs(scene.cart_mass - cart.cart_mass) < 1e-6 and abs(scene.cart_damping - cart.cart_damping) < 1e-4
    rod = rigs.link(0.6413, rigs.rod(0.230, 0.6413))
    assert abs(rod.inertia - scene.inertia[0]) < 5e-6


def test_the_stepped_double_pendulum_is_its_data_sheet() -> None:
    scene = find_scene("rig_stepped_double")
    upper = rigs.link(0.30, rigs.tube(0.052, 0.32, 0.016, 0.014, start=-0.01), rigs.disc(0.038, 0.032, 0.30))
    lower = rigs.link(0.25, rigs.tube(0.041, 0.25, 0.016, 0.014), rigs.point(0.009, 0.25))
    for name, values in rigs.links(upper, lower).items():
        assert np.allclose(getattr(scene, name), values, rtol=1e-13), name
    assert scene.cart_mass is None and scene.u_names == ("acceleration",)


def test_the_acrobot_moves_as_published() -> None:
    """(0.3, -0.2), (0.5, -1), torque 1: solved in 40 digits elsewhere."""
    scene = find_scene("rig_acrobot")
    state = {"q": np.array([0.3, -0.2]), "v": np.array([0.5, -1.0]), "u": np.array([1.0])}
    found = evaluate(lower_function(derive(scene), "forward_dynamics", "loops"), state)["a"]
    assert np.allclose(found, [-2.7110094150749185, 4.2023172428700033], rtol=1e-15, atol=0)
