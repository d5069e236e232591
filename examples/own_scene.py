"""
A scene of your own
===================

In Python instead of TOML: a crane's cable with a load, whose cart mass stays open::

    python examples/own_scene.py
"""

import numpy as np

from phichain import Scene, build, simulate
from phichain.report import figures
from phichain.report.style import save

crane = Scene(
    "crane",
    links=3,
    base="cart",
    mass=[0.4, 0.4, 20.0],  # kg
    length=1.5,  # m
    cart_mass="runtime",
    damping=0.05,  # N m s/rad at every joint
    want=["forward_dynamics", "energy", "state_jacobian"],
)
print(crane)

system = build(crane)
start = ([0.0, 0.3, 0.0, 0.0], [0.0] * 4)  # cart and joint angles, and their rates
for cart_mass in (5.0, 50.0, 500.0):
    motion = simulate(system, start, 20.0, p={"cart_mass": cart_mass})
    print(f"cart of {cart_mass:5.0f} kg: it travels {np.ptp(motion.q[:, 0]):.3f} m while the load swings out")
print("wrote", save(figures.motion(system, motion), "generated/figures/own_scene.png", of=motion))
