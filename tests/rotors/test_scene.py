"""Rotors are asked for by name, shown by name, and refused where they have no meaning."""

from __future__ import annotations

import pytest
import sympy

from phichain.errors import SceneError
from phichain.harmonic.projection import OMEGA, amplitude_symbols, phi_expressions
from phichain.mechanics import derive, with_symbols
from phichain.scene import Scene

ARM = {"mass": [1.0, 0.8], "length": [0.5, 0.4], "armature": [0.25, 0.5]}


def test_the_lagrangian_shows_them() -> None:
    model = derive(Scene("arm", 2, **ARM))
    assert [float(a) for a in model.armature] == [0.25, 0.5]
    assert "1/2 sum_k A_k (phi_k' - phi_{k-1}')^2" in str(model)
    assert "A_k (phi_k'' - phi_{k-1}'')" in str(model)


def test_formulas_with_symbols() -> None:
    """T holds A_k/2 theta_k'^2 with the relative rate, whatever the scene's angles are."""
    for angles, relative in (("relative", "thetadot_2"), ("absolute", "(thetadot_2 - thetadot_1)"), ("adjacent", "thetadot_2")):
        model = derive(with_symbols(Scene("arm", 2, **ARM, angles=angles)))
        slope = model.kinetic.diff(sympy.Symbol("A_2", positive=True))
        assert sympy.expand(slope - sympy.sympify(f"{relative}**2 / 2")) == 0


def test_phi_projected() -> None:
    """A rotor adds -omega^2 A_k times the amplitude of its joint."""
    without, geared = (Scene("arm", 2, mass=1.0, length=0.5, **more) for more in ({}, {"armature": [0.25, 0.5]}))
    first, second = amplitude_symbols(geared)
    change = [b - a for a, b in zip(phi_expressions(without), phi_expressions(geared), strict=True)]
    assert [sympy.nsimplify(sympy.expand(c)) for c in change] == [-OMEGA**2 * first / 4, -OMEGA**2 * second / 2]


def test_no_rotors_in_space() -> None:
    with pytest.raises(SceneError, match="armature"):
        Scene("arm", 2, space="spatial", **ARM)
