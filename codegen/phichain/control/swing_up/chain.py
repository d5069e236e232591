"""The emitted CasADi function of a chain as its step over a sample, with exact derivatives by state, input and parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from phichain.errors import UnsupportedError
from phichain.scene.keys import PARAMETERS
from phichain.system import System, Vector

FINEST = 2
"""Steps of the classical Runge-Kutta method within one sample."""


class Chain:
    """x' = f(x, u) of a planar chain as flat expressions, its runtime parameters at their values.

    Attributes:
        system: The chain.
        parameters: Values of its runtime parameters, in the order of the emitted struct (np,).
        rate: casadi.Function (x, u, relative errors) -> x'.
    """

    def __init__(self, system: System) -> None:
        """Take the function from a system.

        Raises:
            UnsupportedError: The system has no casadi.Function of its forward dynamics.
        """
        if not system.has("casadi"):
            raise UnsupportedError(
                "system", system.name, "has no casadi.Function of its forward dynamics",
                'build it from a scene that wants "forward_dynamics", with casadi installed',
            )  # fmt: skip
        import casadi as ca

        made: Callable[[], Any] = system.functions["casadi"]
        dynamics = made()
        self.system, self.parameters = system, flat_parameters(system)
        x, u, error = ca.SX.sym("x", system.nx), ca.SX.sym("u", system.nu), ca.SX.sym("e", self.parameters.size)
        given: dict[str, Any] = {"q": x[: system.nq], "v": x[system.nq :], "u": u}
        given["p"] = ca.DM(self.parameters) * (1 + error)
        arguments = [given[name] for name in dynamics.name_in()]
        self.rate = ca.Function("rate", [x, u, error], [ca.vertcat(x[system.nq :], dynamics(*arguments))])

    @property
    def push(self) -> Vector:
        """Sizes of the inputs (nu,) that accelerate the chain, hanging, as its weight would: what inputs are measured by."""
        system = self.system
        still, none = np.zeros(system.nx), np.zeros(self.parameters.size)
        lengths = np.asarray(system.number("length"))
        reach = np.concatenate([np.ones(system.cart_size), np.full(system.links, float(np.mean(lengths)))])
        bare = np.array(self.rate(still, np.zeros(system.nu), none)).ravel()[system.nq :]
        sizes = []
        for k in range(system.nu):
            pushed = np.array(self.rate(still, np.eye(system.nu)[k], none)).ravel()[system.nq :]
            sizes.append(abs(float(system.number("gravity"))) / max(float(np.max(np.abs(pushed - bare) * reach)), 1e-300))
        return np.array(sizes)

    def step(self, sample: float) -> Any:
        """casadi.Function (x, u, relative errors) -> x after a sample, the input held."""
        import casadi as ca

        x, u = ca.SX.sym("x", self.system.nx), ca.SX.sym("u", self.system.nu)
        error = ca.SX.sym("e", self.parameters.size)
        after = x
        for _ in range(FINEST):
            after = runge_kutta(lambda z: self.rate(z, u, error), after, sample / FINEST)
        return ca.Function("step", [x, u, error], [after])

    def derivatives(self, sample: float) -> Any:
        """casadi.Function (x, u) -> (A, B, E): of the step by state, input and relative errors, these being zero."""
        import casadi as ca

        step = self.step(sample)
        x, u, error = (ca.SX.sym(name, step.size1_in(k)) for k, name in enumerate(("x", "u", "e")))
        after = step(x, u, error)
        none = ca.DM.zeros(error.numel())
        found = [ca.substitute(ca.jacobian(after, by), error, none) for by in (x, u, error)]
        return ca.Function("derivatives", [x, u], found)


def runge_kutta(rate: Callable[[Any], Any], x: Any, h: Any) -> Any:
    """One step of the classical method with a rate of the state alone."""
    first = rate(x)
    second = rate(x + h / 2 * first)
    third = rate(x + h / 2 * second)
    fourth = rate(x + h * third)
    return x + h / 6 * (first + 2 * (second + third) + fourth)


def parameter_names(system: System) -> tuple[str, ...]:
    """What they are called, likewise: gravity, or mass_1 and on."""
    sizes = {name: np.ravel(np.asarray(values)).size for name, values in (system.params or {}).items()}
    return tuple(one for name in PARAMETERS if name in sizes for one in ([name] if sizes[name] == 1 else [f"{name}_{k + 1}" for k in range(sizes[name])]))


def flat_parameters(system: System) -> Vector:
    """Runtime parameters one behind the other (np,), in the order of the emitted struct; nothing for a chain without."""
    values = system.params or {}
    return np.concatenate([np.zeros(0), *(np.ravel(np.asarray(values[name], dtype=float)) for name in PARAMETERS if name in values)])
