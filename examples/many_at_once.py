"""A whole batch of states in one call: how fast a small difference grows in a double pendulum.

Sixty-four pendulums start within a millionth of a radian of each other and are stepped together by the emitted
Runge-Kutta step; the batch axis comes first everywhere.

    python examples/many_at_once.py
"""

import numpy as np

from phichain import build, standard_scene

system = build(standard_scene(2))

count, h = 64, 1e-3
q = np.tile([2.0, 0.0], (count, 1))
q[:, 0] += 1e-6 * np.linspace(0.0, 1.0, count)
v = np.zeros_like(q)
u = np.zeros_like(q)

for second in range(1, 11):
    for _ in range(1000):
        q, v = system.step(h, q, v, u)
    print(f"t = {second:2d} s: the pendulums are spread over {np.ptp(q[:, 0]):.1e} rad")
