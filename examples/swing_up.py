"""
Two links, swung up
===================

On a cart, with masses that are wrong by ten per cent, drawn as a strip::

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

# %%
# The plan as a strip, the angles, the cart and its force:
#
# .. image:: /docs/img/swing_up_two.png
#    :alt: Two links on a cart, swung up

# sphinx_gallery_thumbnail_path = 'docs/img/swing_up_two.png'
