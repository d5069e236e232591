"""Straight equilibria: energies, types, and stability by the energy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from phichain.errors import ArrayError, UnsupportedError
from phichain.mechanics import derive, with_symbols
from phichain.mechanics.equilibria import equilibria, equilibrium
from phichain.mechanics.linearization import linearize
from phichain.reference import reference
from phichain.scene import Scene, standard_scene

PAPER_B: dict[str, Any] = {"mass": 0.1, "length": 0.1, "base": "cart", "cart_mass": 0.5}


def test_paper_b_has_32_equilibria_and_only_the_hanging_one_is_stable() -> None:
    found = list(equilibria(derive(Scene("b", 5, "spatial", **PAPER_B))))
    assert len({item.signs for item in found}) == 32
    assert [item.signs for item in found if item.is_stable] == [(1,) * 5] == [found[0].signs]
    assert found[-1].kind == "maximum" and found[-1].energy == -found[0].energy
    assert all(item.falling == 2 * item.signs.count(-1) and item.neutral == 0 for item in found)
    assert min(found, key=lambda item: item.energy) is found[0]


def test_energies_are_those_of_the_positions() -> None:
    scene = Scene("b", 3, "spatial", mass=[0.1, 0.4, 0.2], length=0.3, com=0.2, stiffness=[0.2, 0.1, 0.4])
    for item in equilibria(derive(scene)):
        q = [entry for s in item.signs for entry in (0.0, 0.0, float(s))]
        energy = reference(scene, "energy", {"q": q, "v": [0.0] * 9})
        assert isinstance(item.energy, Fraction)
        assert float(item.energy) == pytest.approx(float(energy["potential"]), rel=1e-14)


def test_nothing_moves_at_an_equilibrium() -> None:
    scene = Scene("b", 3, "spatial", mass=[0.1, 0.4, 0.2], length=0.3, stiffness=[0.2, 0.1, 0.4], damping=0.1)
    for item in equilibria(derive(scene)):
        q = [entry for s in item.signs for entry in (0.0, 0.0, float(s))]
        assert not any(reference(scene, "forward_dynamics", {"q": q, "v": [0.0] * 9})["a"])


@given(
    signs=st.lists(st.sampled_from([1, -1]), min_size=1, max_size=5),
    stiffness=st.floats(0.01, 1e3),
    slope=st.floats(0.1, 10),
)
def test_the_index_counts_the_negative_directions_of_G(
    signs: list[int], stiffness: float, slope: float
) -> None:
    links = len(signs)
    springs = [stiffness * slope**k for k in range(links)]
    model = derive(Scene("b", links, "spatial", mass=0.4, length=0.3, stiffness=springs))
    item = equilibrium(model, signs)
    spectrum = np.linalg.eigvalsh(np.array(linearize(model, signs).G, dtype=float))
    if np.min(np.abs(spectrum)) > 1e-9 * np.max(np.abs(spectrum)):
        assert item.falling == np.sum(spectrum < 0)
        assert item.neutral == 0
        assert item.is_stable == (spectrum[0] > 0)


def test_springs_hold_parallel_upright_links_together_but_push_a_link_off_the_vertical() -> None:
    """The spring of joint 1 measures from e_3 and is at its own maximum when link 1 stands against it."""
    model = derive(Scene("b", 2, "spatial", mass=1.0, length=1.0, stiffness=[0.1, 100.0]))
    free = derive(Scene("b", 2, "spatial", mass=1.0, length=1.0))
    assert equilibrium(free, (-1, -1)).falling == 4
    assert equilibrium(model, (-1, -1)).falling == 2
    assert equilibrium(model, (1, -1)).falling == 2


@pytest.mark.parametrize("links", [1, 2, 3])
def test_zero_pivots_are_counted_exactly(links: int) -> None:
    """Without gravity and springs every direction is neutral; with springs alone hanging is a minimum."""
    idle = derive(Scene("b", links, "spatial", mass=1.0, length=1.0, gravity=0.0))
    assert equilibrium(idle, (1,) * links).neutral == 2 * links
    assert equilibrium(idle, (1,) * links).kind == "degenerate"
    sprung = derive(Scene("b", links, "spatial", mass=1.0, length=1.0, gravity=0.0, stiffness=0.5))
    assert equilibrium(sprung, (1,) * links).kind == "minimum"


def test_a_zero_pivot_inside_the_chain_keeps_the_inertia() -> None:
    """g mu_2 = k_2 makes the tip's pivot vanish; the coupled pair has one direction down and one up."""
    model = derive(Scene("b", 2, "spatial", mass=1.0, length=1.0, gravity=1.0, stiffness=[4.0, 1.0]))
    spectrum = np.linalg.eigvalsh(np.array(linearize(model, (-1, -1)).G, dtype=float))
    item = equilibrium(model, (-1, -1))
    assert linearize(model, (-1, -1)).G[2, 2] == 0
    assert (item.falling, item.neutral) == (int(np.sum(spectrum < 0)), 0)


def test_runtime_masses_leave_the_type_decided() -> None:
    model = derive(with_symbols(standard_scene(2)))
    item = equilibrium(model, (1, -1))
    assert (item.kind, item.falling) == ("saddle", 1)
    assert item.energy.free_symbols == set(sympy.symbols("m_1 m_2 l_1 r_1 r_2 g", positive=True))


def test_text() -> None:
    assert (
        str(equilibrium(derive(standard_scene(2)), (1, -1)))
        == "v^  V = -2.4525 J  saddle, 1 falling directions"
    )


def test_undecided_and_impossible_requests_are_refused() -> None:
    sprung = Scene("b", 2, mass=1.0, length=1.0, stiffness=1.0)
    assert equilibrium(derive(sprung), (1, 1)).is_stable
    with pytest.raises(UnsupportedError, match="planar springs pull"):
        equilibrium(derive(sprung), (1, -1))
    runtime = Scene("b", 2, "spatial", mass=1.0, length=1.0, stiffness="runtime")
    with pytest.raises(UnsupportedError, match="give gravity and springs as numbers"):
        equilibrium(derive(runtime), (-1, -1))
    with pytest.raises(ArrayError, match="2 times"):
        equilibrium(derive(sprung), (1, 1, 1))
