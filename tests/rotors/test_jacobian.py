"""Jacobians of chains with rotors: one factorisation for all columns, its operations, its digits, and no wrong sign passes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from phichain.errors import ProofError
from phichain.ir import evaluate, total_operations
from phichain.lowering import lower, lower_function
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference
from phichain.scene import Scene
from tests.lowering.jacobians.test_planar_jacobian import _flipped, _ops, arguments, differentiated

JOINTS: dict[str, Any] = {"stiffness": 0.3, "rest_angle": 0.2, "damping": 0.1, "friction": 0.2, "friction_speed": 0.4}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 1.0, "cart_damping": 0.2, "cart_friction": 0.3, "cart_friction_speed": 0.5}


def chain(links: int, **more: Any) -> Scene:
    numbers = {"mass": [0.7, 1.9, 0.4, 1.0], "length": [0.5, 1.3, 0.8, 0.6], "com": [0.2, 0.9, 0.8, 0.3], "armature": [0.4, 0.0, 0.2, 1.0]}
    keys = {name: (values * links)[:links] for name, values in numbers.items()}
    return Scene("geared", links, **keys | {"actuated": "all", "want": ["state_jacobian"], "code": "loops"} | more)


@pytest.mark.parametrize("links", [4, 8, 16])
def test_a_column_is_one_substitution(links: int) -> None:
    """Some 50 operations a link and column; the differentiated sweeps took 2.3 to 3 times as many."""
    scene = chain(links)
    found = total_operations(lower_function(derive(scene), "state_jacobian", "loops"))
    assert found <= 150 * links**2 + 250 * links
    assert total_operations(differentiated(scene)) > 2.2 * found


@pytest.mark.parametrize("rotors", [[0.3] * 4, [1e12] * 4, [1e12, 0.0, 1e-3, 1.0]])
@pytest.mark.parametrize("more", [{}, CART | {"angles": "absolute"}], ids=["fixed", "cart"])
def test_stiff_rotors_cost_no_digit(rotors: list[float], more: dict[str, Any]) -> None:
    """Row by row: behind a rotor of 1e12 accelerations are small, and so are their slopes."""
    scene = chain(4, armature=rotors, **JOINTS, **more)
    for seed in (1, 2):
        given = arguments(scene, seed)
        found = evaluate(lower_function(derive(scene), "state_jacobian", "loops"), given)
        true = reference(scene, "state_jacobian", {name: list(values) for name, values in given.items()}, digits=40)
        for name, rows in true.items():
            for own, row in zip(found[name], rows, strict=True):
                size = max(map(abs, row))
                assert not size or max(abs(mpf(float(a)) - b) for a, b in zip(own, row, strict=True)) < 4e-15 * size


def test_masses_that_alternate_are_left_to_the_differentiated_sweeps() -> None:
    """A light link that holds a heavy one would leave 5e-13 of a row here."""
    scene = chain(4, mass=[1e-3, 1e4, 1.0, 1e3])
    found = lower_function(derive(scene), "state_jacobian", "loops")
    assert total_operations(found) == total_operations(differentiated(scene))


@pytest.mark.parametrize("more", [{"angles": "adjacent"}, CART], ids=["fixed", "cart"])
def test_a_wrong_sign_anywhere_is_refused(more: dict[str, Any]) -> None:
    model = derive(chain(3, armature=[0.4, 0.3, 0.2], **JOINTS, **more))
    lowered = lower(model)
    prove(model, lowered)
    program = lowered.wanted["state_jacobian"]
    places = [i for i, op in enumerate(_ops(program.body)) if op.kind == "add"]
    right, refused = evaluate(program, given := arguments(model.scene)), 0
    for place in places[:: max(1, len(places) // 12)]:
        wrong = replace(program, body=_flipped(program.body, [place]))
        found = evaluate(wrong, given)
        if all(np.array_equal(found[name], right[name]) for name in right):
            continue  # what is added to nothing
        with pytest.raises(ProofError):
            prove(model, replace(lowered, wanted={"state_jacobian": wrong}))
        refused += 1
    assert refused >= 6


def test_both_at_once_and_by_differences() -> None:
    """Through a complex step of the accelerations."""
    scene = chain(3, **JOINTS, want=["state_jacobian", "dynamics_and_jacobian", "forward_dynamics"])
    model, given = derive(scene), arguments(scene)
    both, forward = (lower_function(model, name, "loops") for name in ("dynamics_and_jacobian", "forward_dynamics"))
    found = evaluate(both, given)
    assert np.array_equal(found["a"], evaluate(forward, given)["a"])
    for name in ("q", "v", "u"):
        for j in range(3):
            moved = {key: values.astype(complex) for key, values in given.items()}
            moved[name][j] += 1e-30j
            slope = evaluate(forward, moved)["a"].imag / 1e-30
            assert np.max(np.abs(found[f"dad{name}"][:, j] - slope)) < 1e-13 * np.max(np.abs(found[f"dad{name}"]))
