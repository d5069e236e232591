"""The variables of an FMU, in the order of their value references, which `stencils/fmi/fmi3_instance.c` counts alike."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.scene import Scene
from phichain.scene.described import BY_NAME
from phichain.units import unit_of


@dataclass(frozen=True)
class Variable:
    """One variable.

    Attributes:
        name: Its name.
        reference: Its value reference.
        role: "time", "state", "rate", "input", "parameter" or "energy".
        unit: Its unit; empty for pure numbers.
        start: Its value at the start, where it has one.
        rate_of: Reference of the state whose rate it is; 0 for others.
        text: What it is.
    """

    name: str
    reference: int
    role: str
    unit: str
    start: float | None = None
    rate_of: int = 0
    text: str = ""


def variables(scene: Scene) -> list[Variable]:
    """Every variable: time, states, their rates, inputs, parameters, energies."""
    found = [Variable("time", 0, "time", "s")]
    names = (*scene.q_names, *scene.v_names)
    units = list(map(_of_fmi, map(unit_of, names)))
    starts = (*start(scene), *[0.0] * scene.nv)

    def add(name: str, role: str, unit: str, value: float | None = None, rate_of: int = 0, text: str = "") -> None:
        found.append(Variable(name, len(found), role, unit, value, rate_of, text))

    for name, unit, value in zip(names, units, starts, strict=True):
        add(name, "state", unit, value)
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        add(f"der({name})", "rate", _rate(unit), rate_of=1 + k)
    for name in scene.u_names:
        add(name, "input", _of_fmi(unit_of(name)), 0.0)
    for name, value in parameters(scene):
        key = BY_NAME[name.partition("[")[0]]
        add(name, "parameter", _of_fmi(key.unit), value, text=key.text)
    if "energy" in scene.want:
        add("kinetic_energy", "energy", "J")
        add("potential_energy", "energy", "J")
    return found


def start(scene: Scene) -> tuple[float, ...]:
    """The chain hanging at rest: angles zero, unit vectors along the last axis."""
    cart = scene.nq - scene.links * (1 if scene.is_planar else 3)
    return (0.0,) * scene.nq if scene.is_planar else (0.0,) * cart + (0.0, 0.0, 1.0) * scene.links


def parameters(scene: Scene) -> list[tuple[str, float]]:
    """Every number of the runtime parameters by its name, `mass[1]`, and where it starts: one of a kind that every chain takes."""
    found = []
    for name, shape in scene.runtime_shapes.items():
        value = 9.81 if name == "gravity" else 0.5 if name == "com" else 1.0 if BY_NAME[name].sign == "above zero" else 0.0
        found += [(f"{name}[{k + 1}]", value) for k in range(shape[0])] if shape else [(name, value)]
    return found


def _of_fmi(unit: str) -> str:
    """A unit as FMI writes it."""
    return unit.replace(" ", ".").replace("^", "")


def _rate(unit: str) -> str:
    return {"": "1/s", "m": "m/s", "m/s": "m/s2", "rad": "rad/s", "rad/s": "rad/s2"}[unit]
