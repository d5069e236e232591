"""
A driven link bends over
========================

Drive a damped link by a torque A cos(omega t): its response bends over and folds. Beside it: how long the Fourier series of free
swings get::

    python examples/response.py
"""

import numpy as np

from phichain import Scene, build, respond, trace
from phichain.report.orbits.responses import peaks, spectra
from phichain.report.style import figure, look, save

chain = {"mass": 1.0, "length": 1.0, "com": 0.5, "actuated": "none"}
want = ["inverse_and_jacobian", "forward_dynamics"]

# Fourier series of the free link's swings, from 1 rad to nearly upright, as long as their tails ask for.
free = build(Scene("free_link", 1, want=want, **chain))
family = trace(free, method="harmonics", until="amplitude=3.1")
print(family)

# The damped link, driven harder and harder; harmonic balance follows each response through its folds.
damped = build(Scene("damped_link", 1, damping=0.03, want=want, **chain))
responses = [respond(damped, 1, torque, (2.0, 6.0)) for torque in (0.05, 0.1, 0.2)]
for response in responses:
    print(response)

with look():
    drawing = figure(9.6, 4.0)
    left, right = drawing.subplots(1, 2)
    spectra(left, free, family.points[np.searchsorted(family.column("theta_1"), (1.0, 2.0, 2.9))])
    for response in responses:
        peaks(right, response)
    right.get_legend().remove()
    right.set_xlabel(r"$\omega$ (rad/s)")
print("wrote", save(drawing, "generated/figures/response.png", of=[family, *responses]))
