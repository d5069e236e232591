"""E - E(0) - work + loss of rigs with everything in it: one sum in which inertia, rotors, brakes and driven bases must all be right."""

from __future__ import annotations

import numpy as np
import pytest

from phichain import build, simulate
from phichain.scene import Scene
from phichain.system import power

LINKS = {"mass": [1, 0.7], "length": [0.5, 0.6], "com": [0.2, 0.3], "inertia": [0.1, 0.05]}
WANT = ["forward_dynamics", "energy", "state_jacobian"]
BRAKED = {"cart_mass": 1, "cart_damping": 0.3, "cart_friction": 0.1, "cart_friction_speed": 0.5}

RIGS = {
    "moved up and down": ({"base": "moving", "damping": 0.1}, lambda t, x: [np.cos(3 * t), 0.5 * np.sin(2 * t)]),
    "stepper": ({"base": "cart", "drive": "acceleration", "damping": 0.1, **BRAKED}, lambda t, x: [np.cos(3 * t)]),
    "geared and braked": (
        {"base": "cart", "friction": 0.1, "friction_speed": 0.3, "armature": 0.05, **BRAKED}, lambda t, x: [np.cos(3 * t)],
    ),
    "sprung aside": ({"base": "fixed", "stiffness": 2, "rest_angle": [0.3, -0.2], "actuated": [2]}, lambda t, x: [0.3 * np.cos(t)]),
    "moved in space": ({"space": "spatial", "base": "moving", "damping": 0.1}, lambda t, x: [np.cos(3 * t), 0.3, 0.5 * np.sin(2 * t)]),
    "stepper in space": (
        {"space": "spatial", "base": "cart", "drive": "acceleration", "cart_mass": 1, "cart_damping": 0.3, "damping": 0.1},
        lambda t, x: [np.cos(3 * t), 0.2],
    ),
}  # fmt: skip


def motion(name: str):
    keys, law = RIGS[name]
    system = build(Scene("rig", 2, want=WANT, **LINKS, **keys))
    q, v = ([0.4, -0.3], [0.5, -1.0]) if system.is_planar else ([0, 0.6, 0.8, 0.6, 0, 0.8], [0.5, 0, 0, 0, -1.0, 0])
    carts = system.cart_size
    return simulate(system, [*[0.0] * carts, *q, *[0.2] * carts, *v], 4.0, tol=1e-11, u=law)


@pytest.mark.long
@pytest.mark.parametrize("name", RIGS)
def test_the_books_close(name: str) -> None:
    run = motion(name)
    assert run.energy is not None and run.work is not None and run.loss is not None
    moved = np.ptp(run.energy) + abs(run.work[-1]) + run.loss[-1]
    assert moved > 0.1
    assert np.max(np.abs(run.energy - run.energy[0] - run.work + run.loss)) < 1e-11 * moved


@pytest.mark.parametrize(("name", "term"), [("geared and braked", "_of_cart"), ("moved in space", "_of_moving_base"), ("stepper in space", "_of_driven_cart")])
def test_a_term_that_is_missing_is_seen(name: str, term: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = getattr(power, term)
    monkeypatch.setattr(power, term, lambda *given: 0.999 * whole(*given))
    run = motion(name)
    assert np.max(np.abs(run.energy - run.energy[0] - run.work + run.loss)) > 1e-6
