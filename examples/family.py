"""
Families of limit cycles
========================

Follow both families of paper A's double pendulum by one harmonic, and check the first point against theory::

    python examples/family.py
"""

from phichain import build, standard_scene, trace
from phichain.orbits import linear_modes
from phichain.report import figures
from phichain.report.style import save

system = build(standard_scene(2))
modes = linear_modes(system)

for mode in (1, 2):
    branch = trace(system, mode=mode, amplitude_max=2.5)
    print(branch)
    print(f"  small motions: omega = {branch.column('omega')[0]:.6f}, linear theory {modes.omega[mode - 1]:.6f} rad/s")
    print("  wrote", save(figures.family(branch), f"generated/figures/family_{mode}.png", of=branch))
