"""Regulators of many equilibria at once: the same bits as one by one, in far fewer calls."""

from __future__ import annotations

import dataclasses
from itertools import product

import numpy as np
import pytest

from phichain.control import Gains, equilibria, lqr, regulators
from phichain.control import regulators as function
from phichain.control.equations import newton, riccati
from phichain.control.equations.doubling import doubled
from phichain.errors import ControlError, UnsupportedError
from phichain.system import System
from tests.handmade import paper_b, planar, spatial

CHAINS = {
    "spatial on a cart": (spatial([0.1] * 3, [0.1] * 3, cart_mass=0.5), {}),
    "weights that tell the planes apart": (spatial([0.1] * 2, [0.1] * 2, cart_mass=0.5), {"Q": np.arange(1.0, 13.0), "R": [1.0, 2.0]}),
    "coupled inputs": (spatial([0.1] * 2, [0.2] * 2, cart_mass=0.5), {"R": [[1.0, 0.9], [0.9, 1.3]]}),
    "damped": (planar([0.3, 0.2, 0.4], [0.5, 0.4, 0.3], [0.4, 0.3, 0.2], cart_mass=0.7, damping=[0.2, 0.1, 0.1], actuated="all"), {}),
    "fixed": (planar([0.3, 0.2, 0.4, 0.1], [0.5, 0.4, 0.3, 0.2], actuated="all"), {}),
    "hard": (planar([0.2, 0.3, 0.4, 0.5, 0.6, 0.7], [0.3] * 6, [0.2] * 6, cart_mass=0.7, actuated="cart"), {}),
}


def same(one: Gains, other: Gains) -> bool:
    return all(np.array_equal(getattr(one, item.name), getattr(other, item.name)) for item in dataclasses.fields(Gains))


@pytest.mark.parametrize("kind", CHAINS)
def test_all_at_once_are_those_one_by_one_to_the_last_bit(kind: str) -> None:
    system, weights = CHAINS[kind]
    every = list(product((1, -1), repeat=system.links))
    found = regulators(system, **weights)
    assert [gains.s for gains in found] == every
    some = range(0, len(every), 1 + len(every) // 10)
    assert all(same(found[k], lqr(system, every[k], **weights)) for k in some)


def test_stacks_end_anywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    system = spatial([0.1] * 3, [0.1] * 3, cart_mass=0.5)
    whole = regulators(system)
    monkeypatch.setitem(function.__globals__, "STACK", 3)
    assert all(map(same, regulators(system), whole))
    assert regulators(system, []) == ()
    assert [gains.s for gains in regulators(system, iter([(1, -1, 1)]))] == [(1, -1, 1)]


def test_one_schur_form_and_one_stack_serve_every_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton's later steps keep the first form, and nothing but it is done equilibrium by equilibrium."""
    forms, stacks = [], []
    monkeypatch.setattr(riccati, "schur_form", lambda closed, form=newton.schur_form: forms.append(1) or form(closed))
    monkeypatch.setattr(newton, "schur_form", lambda closed, form=newton.schur_form: forms.append(1) or form(closed))
    monkeypatch.setattr(riccati, "doubled", lambda A, *more: stacks.append(A.shape) or doubled(A, *more))
    found = regulators(paper_b())
    assert stacks == [(32, 12, 12)] and len(forms) == 32
    assert sum(gains.iterations for gains in found) > 32


def test_a_chain_with_springs_has_those_at_which_it_rests() -> None:
    system = planar([0.2, 0.1], [0.5, 0.4], stiffness=[3.0, 2.0], actuated="all")
    assert [gains.s for gains in regulators(system)] == [item.s for item in equilibria(system)] == [(1, 1)]
    with pytest.raises(ControlError, match="s: .*no equilibrium of this chain"):
        regulators(system, [(1, 1), (1, -1)])


def test_the_first_that_fails_is_named() -> None:
    folded = planar([0.4, 0.3], [1.0, 0.9], [0.4, 0.6], cart_mass=0.8, actuated="cart")
    with pytest.raises(ControlError, match="uncontrollable") as caught:
        regulators(folded)
    assert "[1, -1]" in str(caught.value)
    with pytest.raises(ControlError, match="one sign per link"):
        regulators(folded, [(1, 1), (1,)])
    with pytest.raises(UnsupportedError, match="2\\^17"):
        regulators(spatial([0.1] * 17, [0.1] * 17))
    with pytest.raises(ControlError, match="no input"):
        regulators(planar([0.1], [0.1]))


def test_one_equation_without_an_answer_leaves_the_others_theirs() -> None:
    """x' = x + u has S = 1 + sqrt 2; gamma is an eigenvalue of the second, whose doubling cannot start; the third overflows."""
    A = np.array([[[1.0]], [[1.0]], [[1e200]]])
    G, Q = np.array([[[1.0]], [[0.0]], [[1e-300]]]), np.array([[[1.0]], [[0.0]], [[1e300]]])
    with np.errstate(all="ignore"):
        found = doubled(A, G, Q)
    assert found[0, 0, 0] == pytest.approx(1 + np.sqrt(2), rel=1e-14)
    assert np.isnan(found[1, 0, 0]) and np.isnan(found[2, 0, 0])


def test_the_residual_of_a_float_chain_is_that_of_its_matrices() -> None:
    """Rounded to single precision the matrices move the gains by 1e-5; a residual of 1e-19 would hide it."""
    system = planar([0.1] * 5, [0.1] * 5, cart_mass=0.5, actuated="cart")

    def rounded(s: np.ndarray) -> tuple[np.ndarray, ...]:
        return tuple(np.float32(part) for part in system.linearization(s))

    single = System(**{**system.__dict__, "functions": {"linearization": rounded}, "real": "float"})
    gains, exact = lqr(single), lqr(system)
    away = np.max(np.abs(gains.K - exact.K)) / np.max(np.abs(exact.K))
    assert 1e-7 < away < 1e-2 and gains.residual == np.finfo(np.float32).eps
    assert exact.residual == np.finfo(float).eps
