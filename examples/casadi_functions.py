"""Use a generated folder from CasADi alone: exact Jacobians of the equations of motion in your own expressions.

    python examples/casadi_functions.py
"""

import importlib.util
from pathlib import Path

import casadi

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
print("da/dq at rest:")
print(stiffness([0.0, 0.0, 0.0]))
