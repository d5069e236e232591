"""The linearisation (19) of a System as matrices: second order, first order, reduced.

    M x'' + D x' + G x = B u,   x = [x; C^T xi_1; ..; C^T xi_n] in space, [x; delta theta] in the plane,

about the equilibrium s in {-1, +1}^n, s_k = +1 hanging and -1 upright. In space delta q_k = xi_k x s_k e_3, so that
xi_k = s_k e_3 x q_k to first order, and xi_k' = omega_k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from phichain.control.equations.blocks import blocks, part
from phichain.control.weights import solve
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.vertical import Signs, check_signs


@dataclass(frozen=True, eq=False)
class LinearSystem(Held):
    """M x'' + D x' + G x = B u about one equilibrium.

    Attributes:
        s: Directions of the links, +1 hanging, -1 upright.
        M: Inertia (m, m).
        D: Damping (m, m), zeros without dampers.
        G: Stiffness (m, m).
        B: Input (m, nu), possibly with no column.
        cart: Number of cart coordinates at the head of x.
        names: Names of the m coordinates.
        first_order: (A, B) of z' = A z + B u with z = (x, x'); shapes (2m, 2m) and (2m, nu).
        noise: Relative accuracy of the matrices.
    """

    s: Signs
    M: Vector
    D: Vector
    G: Vector
    B: Vector
    cart: int
    names: tuple[str, ...]
    first_order: tuple[Vector, Vector]
    noise: float = float(np.finfo(float).eps)

    @property
    def reduced(self) -> tuple[Vector, Vector, Vector, Vector]:
        """(M_qq, D_qq, G_qq, B_q) of equation (20): the links driven by the cart's acceleration.

        On a cart a force can give the cart any acceleration a, and feedback does not change controllability:
        M_qq x_q'' + D_qq x_q' + G_qq x_q = -M_qx a + B_q u_q, where u_q are the joint torques, if any (the paper
        prints G_qq without x_q, and another sign of a). A cart that is driven by its acceleration has that in B. On a fixed base
        nothing is removed.
        """
        c = self.cart
        inputs = np.hstack([self.B[c:, :c] - self.M[c:, :c], self.B[c:, c:]]) if c else self.B
        return self.M[c:, c:], self.D[c:, c:], self.G[c:, c:], inputs

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of z = (x, x')."""
        return (*self.names, *(f"{name}_dot" for name in self.names))


def linearize(system: System, s: Sequence[int], p: Parameters | None = None) -> LinearSystem:
    """(19) at the equilibrium s, from the system's `linearization`.

    Raises:
        ControlError: s is no equilibrium: not one +1 or -1 per link.
        AbsentFunctionError: The system has no `linearization`.
    """
    return linearized(system, [s], p)[0]


def linearized(system: System, every: Sequence[Sequence[int]], p: Parameters | None = None) -> list[LinearSystem]:
    """(19) at several equilibria; errors as in `linearize`."""
    signs = [check_signs(system, s) for s in every]
    m = system.cart_size + (system.links if system.is_planar else 2 * system.links)
    parameters = system.parameters(p)
    given = [system.linearization(np.array(s, dtype=float), **parameters) for s in signs]
    parts = [np.array(part, dtype=float) for part in zip(*given, strict=True)]
    M, G = parts[0].reshape(-1, m, m), parts[1].reshape(-1, m, m)
    B = parts.pop().reshape(-1, m, system.nu) if system.nu else np.zeros((len(M), m, 0))
    # A damped scene has a third output; an undamped one leaves it out.
    D = parts[2].reshape(-1, m, m) if len(parts) > 2 else np.zeros_like(M)
    noise = float(np.finfo(np.float32 if system.real == "float" else np.float64).eps)
    names = _names(system)
    rows = zip(signs, M, D, G, B, zip(*first_order(M, D, G, B), strict=True), strict=True)
    return [LinearSystem(s, m, d, g, b, system.cart_size, names, first, noise) for s, m, d, g, b, first in rows]


def first_order(M: Vector, D: Vector, G: Vector, B: Vector) -> tuple[Vector, Vector]:
    """(A, B) of z' = A z + B u; what does not mix is solved apart, so that what is equal in M stays equal to the last bit."""
    count, m, nu = B.shape
    A, drive = np.zeros((count, 2 * m, 2 * m)), np.zeros((count, 2 * m, nu))
    A[:, :m, m:] = np.eye(m)
    given = np.concatenate([-G, -D, B], axis=2)
    for items, found in blocks((M, D, G), B):
        for block in found:
            rows = np.ix_(items, block.states)
            right = solve(part(M[items], block.states, block.states), given[rows])
            at = (rows[0], rows[1] + m)
            A[at], drive[at] = right[..., : 2 * m], right[..., 2 * m :]
    return A, drive


def _names(system: System) -> tuple[str, ...]:
    if system.is_planar:
        return system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq))
    cart = system.q_names[: system.cart_size] or ("x_1", "x_2")[: system.cart_size]
    return (*cart, *(f"xi_{k + 1}_{i + 1}" for k in range(system.links) for i in range(2)))
