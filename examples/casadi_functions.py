"""
A generated folder in CasADi
============================

Use it from CasADi alone: exact Jacobians of the equations of motion in your own expressions::

    python examples/casadi_functions.py
"""

import importlib.util
from pathlib import Path

import casadi
import numpy as np
from matplotlib.figure import Figure

from phichain import generate, standard_scene

folder = generate(standard_scene(3), Path("generated"))

# From here on phichain is not needed: the module stands alone. In a project of your own, `import planar3_casadi`.
spec = importlib.util.spec_from_file_location("planar3_casadi", folder / "planar3_casadi.py")
planar3_casadi = importlib.util.module_from_spec(spec)
spec.loader.exec_module(planar3_casadi)

f = planar3_casadi.forward_dynamics()
print(f)

q, v, u = (casadi.SX.sym(name, 3) for name in "qvu")
stiffness = casadi.Function("stiffness", [q], [casadi.jacobian(f(q, 0, 0), q)])
at_rest = np.array(stiffness([0.0, 0.0, 0.0]))
print("da/dq at rest:")
print(at_rest)

drawing = Figure(figsize=(4.2, 3.4), layout="constrained")
ax = drawing.subplots()
drawing.colorbar(ax.matshow(at_rest, cmap="RdBu", vmin=-np.abs(at_rest).max(), vmax=np.abs(at_rest).max()), label="da/dq (1/s²)")
ax.set(xlabel="by angle", ylabel="of acceleration", xticks=range(3), yticks=range(3), xticklabels=(1, 2, 3), yticklabels=(1, 2, 3))
picture = Path("generated", "figures", "casadi_functions.png")
picture.parent.mkdir(parents=True, exist_ok=True)
drawing.savefig(picture, dpi=150)
print("wrote", picture)
