"""The unknowns of a fit: which numbers of which runtime parameters, and the initial state, as one vector without units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from phichain.contract.words import nearest
from phichain.errors import ArrayError, UnsupportedError
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import reals
from phichain.system.described import RUNTIME

_ABOVE_ZERO: Final = ("mass", "length", "com", "cart_mass")
_ANY_SIGN: Final = ("gravity", "rest_angle")
_SMALLEST: Final = 1e-6
"""Share of its starting value below which a positive parameter cannot fall."""


@dataclass(frozen=True, eq=False)
class Unknowns(Held):
    """z = (parameters, initial state), each over its scale.

    Attributes:
        names: Names of the parameters' numbers, such as mass_1, gravity; then those of the state's entries, such as theta_1(0).
        keys: The runtime parameter and the place in it of every parameter's number.
        scale: Scale of every unknown, in its unit.
        z: Starting point.
        low: Lower bounds.
        given: All runtime parameters as they start: name -> array (N,) or ().
        x0: The state (nx,) that the motion starts from.
        fits_state: Whether the state is among the unknowns.
    """

    names: tuple[str, ...]
    keys: tuple[tuple[str, int], ...]
    scale: Vector
    z: Vector
    low: Vector
    given: Mapping[str, Vector]
    x0: Vector
    fits_state: bool

    @property
    def count(self) -> int:
        """How many numbers of parameters are unknown; the state's entries follow them."""
        return len(self.keys)

    def parameters(self, z: Vector) -> dict[str, Any]:
        """The runtime parameters at a point."""
        found = {name: np.array(value) for name, value in self.given.items()}
        for (name, place), value in zip(self.keys, (z * self.scale)[: self.count], strict=True):
            found[name].reshape(-1)[place] = value
        return {name: float(value) if value.ndim == 0 else value for name, value in found.items()}

    def state(self, z: Vector) -> Vector:
        """The initial state at a point."""
        return (z * self.scale)[self.count :] if self.fits_state else self.x0


def runtime_names(system: System) -> tuple[str, ...]:
    """The parameters that a system leaves to run time."""
    return tuple(
        field.name for part in (system.numbers, system.joints) for field in fields(part) if getattr(part, field.name) == RUNTIME
    )


def unknowns(
    system: System, start: Mapping[str, Any], p: Parameters | None, fixed: Iterable[str], x0: Vector, x_scale: Vector,
    fits_state: bool,
) -> Unknowns:  # fmt: skip
    """Lay the unknowns out.

    Args:
        system: The chain.
        start: Starting values of the parameters that are fitted, by name; one number stands for all links.
        p: Values of the runtime parameters that are not.
        fixed: Numbers of started parameters that keep their starting value, such as mass_1.
        x0: The initial state (nx,).
        x_scale: Sizes of its entries (nx,).
        fits_state: Whether the initial state is fitted, too.

    Raises:
        UnsupportedError: Nothing of the scene is a runtime parameter.
        ArrayError: A name that is no runtime parameter, one given twice or not at all, values of a wrong shape, sign or size; no
            unknown is left.
    """
    runtime = runtime_names(system)
    if not runtime:
        raise UnsupportedError("scene", system.name, "leaves no parameter to run time", 'write mass = "runtime" for what is to be fitted')
    known = {**(system.params or {}), **(p or {})}
    for name in (*start, *(p or {})):
        if name not in runtime:
            best = nearest(name, runtime)
            raise ArrayError("start", name, "is no runtime parameter of this scene", f"{_guess(best)}there are {', '.join(runtime)}")
    if not start:
        raise ArrayError("start", None, "names nothing to fit", f"give starting values for some of {', '.join(runtime)}")
    given = {name: _values(system, name, start.get(name, known.get(name)), name in start) for name in runtime}
    if both := [name for name in start if name in (p or {})]:
        raise ArrayError("start", both[0], "is given to be fitted and to be kept", "leave one of them out")
    labels = {_label(name, k, given[name]): (name, k) for name in runtime if name in start for k in range(given[name].size)}
    held = set(fixed)
    for name in held:
        if name not in labels:
            best = nearest(name, labels)
            raise ArrayError("fix", name, "is none of the numbers to be fitted", f"{_guess(best)}there are {', '.join(labels)}")
    free = {label: key for label, key in labels.items() if label not in held}
    if not free:
        raise ArrayError("fix", tuple(held), "leaves nothing to be fitted", "fix fewer numbers")
    values = np.array([given[name].reshape(-1)[k] for name, k in free.values()])
    scale = np.where(values != 0, np.abs(values), 1.0)
    low = np.array([-np.inf if name in _ANY_SIGN else _SMALLEST if name in _ABOVE_ZERO else 0.0 for name, _ in free.values()])
    names = tuple(free)
    if fits_state:
        names += tuple(f"{name}(0)" for name in (*system.q_names, *system.v_names))
        values, scale = np.concatenate([values, x0]), np.concatenate([scale, x_scale])
        low = np.concatenate([low, np.full(len(x0), -np.inf)])
    return Unknowns(names, tuple(free.values()), scale, values / scale, low, given, np.array(x0), fits_state)


def _guess(best: str | None) -> str:
    return f'did you mean "{best}"? ' if best else ""


def _label(name: str, place: int, values: Vector) -> str:
    return f"{name}_{place + 1}" if values.ndim else name


def _values(system: System, name: str, value: Any, starts: bool) -> Vector:
    field = f"start.{name}" if starts else f"p.{name}"
    if value is None:
        raise ArrayError(field, None, "has no value", f"start it (--start {name}=...) to fit it, or set it (--set {name}=...) to keep it")
    array = reals(field, value, "give real numbers")
    shape = () if name == "gravity" or name.startswith("cart_") else (system.links,)
    if array.size == 1 or array.shape == shape:
        array = np.array(np.broadcast_to(array.reshape(()) if array.size == 1 else array, shape))
    else:
        raise ArrayError(field, array, f"must have shape {shape}", "give one number for every link, or one for all")
    if not np.isfinite(array).all():
        raise ArrayError(field, array.tolist(), "is not finite", "give finite numbers")
    if name not in _ANY_SIGN and (array < 0).any() or name in _ABOVE_ZERO and (array == 0).any():
        raise ArrayError(field, array.tolist(), "has a sign that no such parameter has", "give positive numbers")
    if starts and name != "rest_angle" and (array == 0).any():
        raise ArrayError(field, array.tolist(), "starts from zero, which says nothing of its size", "start from a likely size")
    return array
