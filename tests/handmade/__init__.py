"""Systems made by hand from small dense NumPy formulas: the numerics' tests need no emitted code.

The formulas are the closed forms of docs/theory.md, section 1 (dense mass matrix, Coriolis and gravity
vectors), solved with LAPACK, and of its section 6 (Phi with SciPy's Bessel functions): an independent route to what
the emitted code computes by O(N) sweeps. Jacobians of the plane come from the complex step, exact to round-off.
"""

from __future__ import annotations

from tests.handmade.formulas import GRAVITY, angle_map, batched, coefficients
from tests.handmade.planar_chain import planar, uniform_planar
from tests.handmade.spatial_chain import paper_b, spatial

__all__ = ["GRAVITY", "angle_map", "batched", "coefficients", "paper_b", "planar", "spatial", "uniform_planar"]
