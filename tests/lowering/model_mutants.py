"""Models whose Lagrangian is not that of their scene, each wrong in one place."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import sympy

from phichain.mechanics import Model, derive
from phichain.mechanics.energies import Energies
from phichain.scene import Scene

Mutants = Iterator[tuple[str, Model]]

_UNEVEN: dict[str, Any] = {"mass": [1.0, 0.7, 0.3], "length": [0.5, 0.4, 0.9], "com": [0.2, 0.4, 0.1]}
_RUNTIME: dict[str, Any] = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}
_JOINTS: dict[str, Any] = {"stiffness": [0.3, 0.2, 0.5], "damping": [0.1, 0.4, 0.2]}
_CART: dict[str, Any] = {"base": "cart", "cart_mass": 2.5}
_LOSSES: dict[str, Any] = {
    "rest_angle": [0.3, -0.2, 0.5], "friction": [0.2, 0.6, 0.1], "friction_speed": 0.5,
    "cart_damping": 0.2, "cart_friction": 0.4, "cart_friction_speed": 0.3,
}  # fmt: skip

KINDS: dict[str, dict[str, Any]] = {
    "planar fixed": {**_UNEVEN, **_JOINTS},
    "planar fixed, absolute": {**_UNEVEN, "angles": "absolute", "damping": 0.1},
    "planar fixed, adjacent": {**_UNEVEN, "angles": "adjacent", "stiffness": 0.1},
    "planar fixed, tip masses": {"mass": 0.3, "length": 0.2},
    "planar cart": {**_UNEVEN, **_JOINTS, **_CART},
    "planar fixed, rotors": {**_UNEVEN, "armature": [0.2, 0.0, 0.3], "damping": 0.1},
    "planar cart, runtime rotors": {**_UNEVEN, **_CART, "armature": "runtime", "angles": "adjacent"},
    "planar fixed, runtime": {**_RUNTIME, "stiffness": "runtime", "damping": "runtime"},
    "planar cart, runtime": {**_RUNTIME, "base": "cart", "cart_mass": "runtime"},
    "planar fixed, runtime masses": {"mass": "runtime", "length": [0.5, 0.4, 0.9], "com": [0.2, 0.4, 0.1]},
    "planar cart, losses": {**_UNEVEN, **_JOINTS, **_CART, **_LOSSES},
    "planar fixed, runtime losses": {**_RUNTIME, "damping": "runtime", "friction": "runtime", "friction_speed": 0.5},
    "spatial cart, braked": {"space": "spatial", **_UNEVEN, **_CART, "cart_damping": 0.2},
    "spatial fixed": {"space": "spatial", **_UNEVEN, **_JOINTS},
    "spatial cart": {"space": "spatial", **_UNEVEN, **_JOINTS, **_CART},
    "spatial cart, tip masses": {"space": "spatial", "mass": 0.1, "length": 0.1, "base": "cart", "cart_mass": 0.5},
    "spatial fixed, runtime": {"space": "spatial", **_RUNTIME, "stiffness": "runtime", "damping": "runtime"},
    "spatial cart, runtime": {"space": "spatial", **_RUNTIME, "base": "cart", "cart_mass": "runtime"},
}


def model_of(kind: str) -> Model:
    """The unmutated Model of a kind of scene, three links."""
    return derive(Scene("chain", 3, want=["forward_dynamics", "energy"], **KINDS[kind]))


def mutants(model: Model) -> Mutants:
    """Every mutant of a Model, by what is wrong with it."""
    for name, energies in (*_whole(model), *_coefficients(model), *_definitions(model)):
        yield name, replace(model, energies=energies)


def _whole(model: Model) -> Iterator[tuple[str, Energies]]:
    right = model.energies
    for field in ("kinetic", "potential", "dissipation"):
        value = getattr(right, field)
        if value != 0:
            yield f"{field} := 0", replace(right, **{field: sympy.S.Zero})
            yield f"{field} doubled", replace(right, **{field: 2 * value})
            yield f"{field} negated", replace(right, **{field: -value})
    yield "T and V exchanged", replace(right, kinetic=right.potential, potential=right.kinetic)
    yield "T is nothing", replace(right, kinetic=None)
    yield "V is no number", replace(right, potential=sympy.nan)
    yield "S without a definition", replace(right, definitions=right.definitions[:-1] if _last(right) == "S" else ())
    yield "definitions turned round", replace(right, definitions=right.definitions[::-1])
    yield "T as a root", replace(right, kinetic=sympy.sqrt(right.kinetic))


def _last(energies: Energies) -> str:
    return str(energies.definitions[-1][0])


def _coefficients(model: Model) -> Iterator[tuple[str, Energies]]:
    """T, V or R with a term more, so that one coefficient is wrong."""
    right, small, axes = model.energies, sympy.Rational(1, 1024), 2 if model.scene.is_planar else 3
    rates = [[sympy.Symbol(f"qdot_{k}_{i}") for i in range(1, axes + 1)] for k in (1, 2, 3)]
    speed = list(model.symbols.cart_rate)

    def kinetic(term: sympy.Expr) -> Energies:
        return replace(right, kinetic=right.kinetic + small * term)

    def potential(term: sympy.Expr) -> Energies:
        return replace(right, potential=right.potential + small * term)

    for i in range(3):
        for j in range(i, 3):
            yield f"c_{i + 1}_{j + 1}", kinetic(_dot(rates[i], rates[j]))
        yield f"first component of c_{i + 1}_{i + 1}", kinetic(rates[i][0] ** 2)
        yield f"last component of c_{i + 1}_{i + 1}", kinetic(rates[i][-1] ** 2)
        yield f"mu_{i + 1} in V", potential(sympy.Symbol(f"q_{i + 1}_{axes}"))
        yield f"a pull aside on link {i + 1}", potential(sympy.Symbol(f"q_{i + 1}_1"))
        if speed:
            yield f"mu_{i + 1} in T", kinetic(_dot(speed, rates[i]))
        bend = sympy.Symbol(f"bend_{i + 1}")
        if model.scene.stiffness is not None:
            yield f"k_{i + 1}", potential(bend**2 if axes == 2 else bend)
        if model.scene.armature is not None:
            yield f"A_{i + 1}", kinetic(sympy.Symbol(f"slip_{i + 1}") ** 2)
        if model.scene.damping is not None:
            slip = [f"slip_{i + 1}"] if axes == 2 else [f"slip_{i + 1}_{axis}" for axis in (1, 2, 3)]
            square = _dot(*[[sympy.Symbol(name) for name in slip]] * 2)
            yield f"d_{i + 1}", replace(right, dissipation=right.dissipation + small * square)
    yield "two components mixed", kinetic(rates[0][0] * rates[1][1])
    yield "a rate alone", kinetic(rates[2][0])
    yield "a fourth power", kinetic(rates[2][0] ** 4)
    yield "drag on link 1", replace(right, dissipation=right.dissipation + small * rates[0][0] ** 2)
    yield "gravity dropped", replace(right, potential=right.potential.subs(sympy.Symbol("S"), 0))
    yield "gravity turned", replace(right, potential=right.potential.subs(sympy.Symbol("S"), -sympy.Symbol("S")))
    yield "gravity stronger", potential(sympy.Symbol("S"))
    if speed:
        yield "M00", kinetic(_dot(speed, speed))
        yield "the cart's friction", replace(right, dissipation=right.dissipation + small * _dot(speed, speed))
        yield "the cart on a spring", potential(model.symbols.cart[0] ** 2)
        yield "the cart uphill", potential(model.symbols.cart[0])


def _definitions(model: Model) -> Iterator[tuple[str, Energies]]:
    """One definition after the other with a wrong expression."""
    right = model.energies
    used = {symbol for _, expression in right.definitions for symbol in expression.free_symbols}
    for energy in (right.kinetic, right.potential, right.dissipation):
        used |= energy.free_symbols
    changes: dict[str, Callable[[sympy.Expr], sympy.Expr]] = {
        "doubled": lambda value: 2 * value,
        "one more": lambda value: value + 1,
    }
    for place, (symbol, expression) in enumerate(right.definitions):
        for what, change in changes.items():
            wrong = change(expression)
            if symbol in used and wrong != expression:
                changed = (*right.definitions[:place], (symbol, wrong), *right.definitions[place + 1 :])
                yield f"{symbol} {what}", replace(right, definitions=changed)


def _dot(a: list[sympy.Symbol], b: list[sympy.Symbol]) -> sympy.Expr:
    """a . b; a cart has no component along gravity."""
    return sympy.Add(*[x * y for x, y in zip(a, b, strict=False)])
