"""
A double pendulum, let go
=========================

Simulate paper A's: build, simulate, look at energy and angles, draw::

    python examples/swing.py
"""

import numpy as np

from phichain import build, simulate, standard_scene
from phichain.report import figures
from phichain.report.style import save

system = build(standard_scene(2))  # derived, emitted as C, compiled, loaded

q = [np.pi / 2, 0.0]  # joint angles, rad: straight out to the side
v = [0.0, 0.0]  # rad/s
motion = simulate(system, (q, v), np.linspace(0.0, 10.0, 1001), tol=1e-11)

print(motion)
print(f"largest angle of the second joint: {np.abs(motion.q[:, 1]).max():.4f} rad")
print("wrote", save(figures.motion(system, motion), "generated/figures/swing.png", of=motion))
