"""A solved regulator as the frozen record of its gains."""

from __future__ import annotations

from phichain.control.controllability import Controllability
from phichain.control.equations.riccati import Riccati
from phichain.control.gains import Gains
from phichain.control.linear import LinearSystem
from phichain.system import Parameters, System, Vector
from phichain.system.vertical import configuration


def record(
    system: System,
    linear: LinearSystem,
    margins: Controllability,
    weights: tuple[Vector, Vector],
    solution: Riccati,
    sample: float | None,
    error: float = 0.0,
    p: Parameters | None = None,
) -> Gains:
    """The Gains of one equilibrium.

    Args:
        system: The chain.
        linear: It, about the equilibrium.
        margins: How well its modes can be reached.
        weights: (Q, R).
        solution: S, K, poles and residual.
        sample: Time between two samples, s; None in continuous time.
        error: Relative error of K that the accuracy of the matrices explains; 0 where it was not estimated.
        p: Runtime parameters.
    """
    return Gains(
        name=system.name,
        space=system.space,
        cart=system.cart_size,
        s=linear.s,
        equilibrium=configuration(system, linear.s),
        K=solution.K,
        S=solution.S,
        A=linear.first_order[0],
        B=linear.first_order[1],
        Q=weights[0],
        R=weights[1],
        poles=solution.poles,
        modes=margins.modes,
        margins=margins.margins,
        # The equation solved is the chain's only as far as the matrices are.
        residual=max(solution.residual, linear.noise),
        iterations=solution.iterations,
        state_names=linear.state_names,
        input_names=system.u_names or tuple(f"u_{k + 1}" for k in range(linear.B.shape[1])),
        digest=system.digest,
        sample=0.0 if sample is None else float(sample),
        error=error,
        p=system.values(p),
    )
