"""
Five links upright on their cart
================================

Balance paper B's chain on its cart, from gains to the nonlinear closed loop::

    python examples/balance.py
"""

import numpy as np

from phichain import build, lqr, simulate
from phichain.control import errors, feedback
from phichain.report import figures
from phichain.report.style import save
from phichain.scene.library import find_scene
from phichain.system.starts import leaning

system = build(find_scene("paper_b"))
upright = [-1] * system.links

gains = lqr(system, upright, Q=1.0, R=1.0)
print(gains)

start = leaning(system, 0.1, upright)  # every link 0.1 rad off, at rest
motion = simulate(system, start, np.linspace(0.0, 20.0, 2001), u=feedback(system, gains))
direction_error, rate_error = errors(system, gains, motion.x)

print(motion)
print(f"e_q: {direction_error[0]:.3g} at first, {direction_error[-1]:.1e} after 20 s")
drawing = figures.closed_loop(system, motion, direction_error, rate_error)
print("wrote", save(drawing, "generated/figures/balance.png", of=[motion, gains]))
