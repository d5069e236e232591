"""Swing two links on a cart up, with masses that are wrong by ten per cent, and draw it as a strip.

    python examples/swing_up.py
"""

from phichain import Scene, build, generate_swingup, swing_up
from phichain.report.laws.swing_up import strip
from phichain.report.style import save

scene = Scene("two_links", 2, base="cart", cart_mass=0.5, mass=0.1, length=0.2, want=("forward_dynamics", "linearization"))
system = build(scene)

wrong = {"mass": 0.1, "cart_mass": 0.1}
found = swing_up(system, limit=20.0, rail=1.0, errors=wrong, runs=100, report=print)
print(found)
print("C in", generate_swingup(found.law, "generated").name)
print("wrote", save(strip(system, found.plan), "generated/figures/swing_up.png", of=found.plan))
