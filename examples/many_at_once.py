"""
Many states in one call
=======================

How fast a small difference grows in a double pendulum. Sixty-four pendulums start within a millionth of a radian of each other and are
stepped together by the emitted Runge-Kutta step; the batch axis comes first everywhere::

    python examples/many_at_once.py
"""

import numpy as np

from phichain import build, standard_scene
from phichain.report.style import figure, look, save

system = build(standard_scene(2))

count, h = 64, 1e-3
q = np.tile([2.0, 0.0], (count, 1))
q[:, 0] += 1e-6 * np.linspace(0.0, 1.0, count)
v = np.zeros_like(q)
u = np.zeros_like(q)

spread = []
for second in range(1, 11):
    for _ in range(1000):
        q, v = system.step(h, q, v, u)
    spread.append(np.ptp(q[:, 0]))
    print(f"t = {second:2d} s: the pendulums are spread over {spread[-1]:.1e} rad")

with look():
    drawing = figure(5.2, 3.2)
    ax = drawing.subplots()
    ax.semilogy(range(1, 11), spread, marker="o")
    ax.set(xlabel="t (s)", ylabel="spread of the first angle (rad)")
print("wrote", save(drawing, "generated/figures/many_at_once.png"))
