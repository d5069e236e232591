"""The runtime parameters of a call: the C struct as one flat array, filled and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.native.memory.arrays import converted, wrong_shape
from phichain.native.memory.slots import slot
from phichain.native.signature import Argument, Signature
from phichain.scene.keys import NOT_NEGATIVE, POSITIVE


class ParameterBlock:
    """The C struct of the runtime parameters as one flat array; `rows_source` proves the layout in C.

    Attributes:
        values: The array.
    """

    __slots__ = ("_checked", "_fields", "_names", "_signature", "_takes", "values")

    def __init__(self, signature: Signature, real: np.dtype[Any]) -> None:
        """Allocate what a function takes.

        Args:
            signature: The function.
            real: The type that C computes in.
        """
        sizes = [parameter.size for parameter in signature.parameters]
        ends = np.cumsum(sizes)
        self.values: NDArray[Any] = np.zeros(sum(sizes), real)
        self._signature, self._checked = signature, b""
        places = zip(signature.parameters, ends - sizes, ends, strict=True)
        self._fields = [self.values[start:end].reshape(item.shape) for item, start, end in places]
        self._names = [parameter.name for parameter in signature.parameters]
        self._takes = [slot(field.shape, field).take for field in self._fields]

    def fill(self, p: Mapping[str, Any] | None) -> bool:
        """Take parameters by name.

        Returns:
            Whether they are others than those taken last.

        Raises:
            ArrayError: One is missing, unknown, has another shape, or is none that a scene could hold.
        """
        if not self._took(p):
            given = parameter_values(self._signature, p, self.values.dtype)
            for field, value in zip(self._fields, given, strict=True):
                field[...] = value
        values = self.values.tobytes()
        # What was given last time was checked then; comparing costs a tenth of checking.
        if values == self._checked:
            return False
        for parameter, field in zip(self._signature.parameters, self._fields, strict=True):
            demand_range(f"{self._signature.name}.p[{parameter.name!r}]", parameter, field)
        demand_bodies(f"{self._signature.name}.p", self._signature.parameters, self._fields)
        self._checked = values
        return True

    def _took(self, p: Any) -> bool:
        """Copy parameters that need no conversion; False at anything else."""
        names = self._names
        whole = type(p) is dict and len(p) == len(names) and all(map(p.__contains__, names))
        return whole and all(take(p[name]) for name, take in zip(names, self._takes, strict=True))


def parameter_values(
    signature: Signature, p: Mapping[str, Any] | None, real: np.dtype[Any]
) -> list[NDArray[Any]]:
    """The runtime parameters, one array each in the order of the C struct.

    A function that reads none of them takes them all the same, so that one set serves every function of a
    system.

    Raises:
        ArrayError: One is missing, unknown, or has another shape.
    """
    names = [parameter.name for parameter in signature.parameters]
    if not names and isinstance(p, Mapping) and not p:
        return []
    if not names:
        problem, remedy = (
            "this scene has no runtime parameters",
            'leave p out, or make them "runtime" in the scene',
        )
        raise ArrayError(f"{signature.name}.p", p, problem, remedy)
    field, example = f"{signature.name}.p", ", ".join(f"'{name}': ..." for name in names)
    if not isinstance(p, Mapping):
        problem = f"the runtime parameters {', '.join(names)} are missing"
        raise ArrayError(field, p, problem, f"pass them by name, p={{{example}}}")
    if p.keys() != set(names):
        missing, unknown = (
            [name for name in names if name not in p],
            [name for name in p if name not in names],
        )
        problem = f"must hold exactly {', '.join(names)}"
        raise ArrayError(field, list(p), problem, f"pass p={{{example}}}", missing=missing, unknown=unknown)
    given = [_parameter(f"{field}[{parameter.name!r}]", parameter, p[parameter.name], real) for parameter in signature.parameters]
    demand_bodies(field, signature.parameters, given)
    return given


def _parameter(field: str, parameter: Argument, value: Any, real: np.dtype[Any]) -> NDArray[Any]:
    if callable(value):
        raise changing(field, parameter.name, value)
    array = converted(field, value, real)
    if array.shape != parameter.shape:
        raise wrong_shape(field, parameter, value, array, batch=False)
    demand_range(field, parameter, array)
    return array


def changing(field: str, name: str, value: Any) -> ArrayError:
    """The refusal of a runtime parameter that is a function, of time for instance."""
    problem = "is a function, and a runtime parameter is a number that holds for a whole run"
    remedy = "pass numbers; what changes in time is an input u"
    if name == "gravity":
        remedy = 'set base = "moving" in the scene: gravity that changes is an acceleration of the base, and that is an input u'
    return ArrayError(field, value, problem, remedy)


def demand_range(field: str, parameter: Argument, array: NDArray[Any]) -> None:
    """Check that a runtime parameter is one that a scene could hold.

    Raises:
        ArrayError: It is not finite in the type of the C, or has the wrong sign.
    """
    if not np.isfinite(array).all():
        raise ArrayError(field, array.tolist(), "is not finite", f"use finite numbers that {array.dtype} can hold")
    above_zero = parameter.name in POSITIVE and not parameter.may_be_zero
    if above_zero and not (array > 0).all():
        raise ArrayError(field, array.tolist(), "is not positive", "use numbers above zero")
    if (parameter.may_be_zero or parameter.name in NOT_NEGATIVE) and not (array >= 0).all():
        raise ArrayError(field, array.tolist(), "is negative", "use zero or numbers above it")


def demand_bodies(field: str, parameters: Sequence[Argument], arrays: Sequence[NDArray[Any]]) -> None:
    """Check that no link has its mass at its joint without an inertia there.

    Raises:
        ArrayError: One has: nothing would resist its turning.
    """
    given = {parameter.name: array for parameter, array in zip(parameters, arrays, strict=True)}
    for parameter in parameters:
        if parameter.name in ("com", "inertia") and parameter.beside:
            given[{"com": "inertia", "inertia": "com"}[parameter.name]] = np.array(parameter.beside)
    if "com" not in given or "inertia" not in given:
        return
    bare = np.flatnonzero((np.atleast_1d(given["com"]) == 0) & (np.atleast_1d(given["inertia"]) == 0))
    if bare.size:
        problem = f"puts the mass of link {bare[0] + 1} on its joint, and the link has no inertia"
        values = {name: given[name].tolist() for name in ("com", "inertia")}
        raise ArrayError(field, values, problem, "give the link a com or an inertia above zero")
