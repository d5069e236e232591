"""Pole placement, gains from elsewhere, python-control's state spaces, and what gains of float scenes say of themselves."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import place_poles

from phichain.control import from_control, linearize, lqr, place, to_control, with_gains
from phichain.control.exchange import _library
from phichain.errors import ControlError, UnsupportedError
from phichain.system import System
from tests.handmade import paper_b, planar, spatial

CART = planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart")
JOINTS = planar([0.3, 0.2], [0.4, 0.3], actuated="all")
POLES = [-2.0, -3.0, -4 + 1j, -4 - 1j, -6.0, -7.0]


def eigenvalues(gains) -> np.ndarray:
    return np.sort_complex(np.linalg.eigvals(gains.A - gains.B @ gains.K))


def test_the_closed_loop_has_the_poles() -> None:
    gains = place(CART, None, POLES)
    assert np.allclose(eigenvalues(gains), np.sort_complex(POLES), rtol=1e-8)
    assert np.allclose(np.sort_complex(gains.poles), np.sort_complex(POLES), rtol=1e-10)
    # One input leaves no choice: SciPy's gains are the same.
    A, B = linearize(CART, (-1, -1)).first_order
    assert np.allclose(gains.K, place_poles(A, B, POLES).gain_matrix, rtol=1e-7)
    cost = gains.A - gains.B @ gains.K
    assert np.allclose(cost.T @ gains.S + gains.S @ cost, -np.eye(6) - gains.K.T @ gains.K, atol=1e-6 * np.max(gains.S))


def test_sampled_poles_are_those_of_the_held_chain() -> None:
    period = 0.01
    gains = place(CART, (1, -1), POLES, sample=period)
    whole = np.zeros((7, 7))
    whole[:6, :6], whole[:6, 6:] = gains.A, gains.B
    flow = expm(whole * period)
    values = np.linalg.eigvals(flow[:6, :6] - flow[:6, 6:] @ gains.K)
    assert np.allclose(np.sort_complex(np.log(values) / period), np.sort_complex(POLES), rtol=1e-6)
    assert gains.sample == period and gains.law(limit=5.0).sample == period


def test_several_inputs_leave_a_choice_that_is_taken_well() -> None:
    gains = place(JOINTS, (-1, 1), [-3, -4, -5, -6])
    assert np.allclose(eigenvalues(gains), [-6, -5, -4, -3], rtol=1e-8)


def test_both_planes_of_a_chain_in_space_share_the_poles_or_divide_them() -> None:
    chain = spatial([0.2], [0.4], cart_mass=0.5)
    half = place(chain, None, [-2, -3, -4, -5])
    assert np.allclose(eigenvalues(half), np.repeat([-5, -4, -3, -2], 2), atol=1e-5)
    divided = place(chain, None, -2 - np.arange(8) * 0.5)
    assert np.allclose(eigenvalues(divided), np.sort(-2 - np.arange(8) * 0.5), rtol=1e-6)


@pytest.mark.parametrize(
    ("poles", "words"),
    [
        ([-1, -2], "poles: are not as many as states: 6"),
        ([-1, -2, -3, -4, -5, 1], "poles: are not all in the open left half plane"),
        ([-1, -2, -3, -4, -5, np.nan], "poles: are not all in the open left half plane"),
        ([-1, -2, -3, -4, -5, -6 + 1j], "without its conjugate"),
        (["a"] * 6, "poles: holds something that is no number"),
    ],
)
def test_poles_that_cannot_be_are_refused(poles, words: str) -> None:
    with pytest.raises(ControlError, match=words):
        place(CART, None, poles)


def test_poles_that_a_double_cannot_place_are_refused() -> None:
    with pytest.raises(ControlError, match=r"poles: cannot be placed by gains in double precision: .* off") as refused:
        place(paper_b(), None, -1 - 0.1 * np.arange(12))
    assert refused.value.off > 1e-3
    with pytest.raises(ControlError, match="poles: cannot be placed: "):
        place(JOINTS, (-1, 1), [-3, -3, -3, -4])


def test_gains_from_elsewhere_become_a_record_and_a_law() -> None:
    """python-control's regulator of our linear model, back as ours."""
    A, B = linearize(CART, (-1, -1)).first_order
    K, _, _ = control.lqr(A, B, np.eye(6), np.eye(1))
    gains, own = with_gains(CART, None, K), lqr(CART)
    assert np.allclose(gains.K, own.K, rtol=1e-7) and gains.decay == pytest.approx(own.decay, rel=1e-6)
    assert np.allclose(gains.S, own.S, rtol=1e-5, atol=1e-6 * np.max(own.S))
    assert gains.law(limit=3.0).gains == tuple(map(tuple, K))
    with pytest.raises(ControlError, match="K: leads to a closed loop that is not stable: an eigenvalue at"):
        with_gains(CART, None, -K)
    with pytest.raises(ControlError, match="K: must hold finite numbers of shape"):
        with_gains(CART, None, K[:, :4])
    with pytest.raises(ControlError, match="not stable"):
        with_gains(CART, None, np.zeros((1, 6)), sample=0.01)


def test_a_state_space_goes_there_and_back() -> None:
    linear = linearize(CART, (1, -1))
    there = to_control(linear, name="double")
    assert isinstance(there, control.StateSpace) and there.state_labels == list(linear.state_names) and there.dt == 0
    back = from_control(there, (1, -1), cart=1)
    assert all(np.array_equal(a, b) for a, b in zip(back.first_order, linear.first_order, strict=True))
    assert np.allclose(back.M @ np.linalg.solve(linear.M, linear.G), back.G, atol=1e-12) and back.names == linear.names
    held = to_control(linear, sample=0.01)
    assert held.dt == 0.01 and np.allclose(held.A, control.c2d(there, 0.01).A, rtol=1e-12, atol=1e-14)
    with pytest.raises(ControlError, match="space.dt: belongs to a sampled system"):
        from_control(held, (1, -1))
    with pytest.raises(ControlError, match=r"space: has a state that is no \(x, x'\)"):
        from_control(control.ss([[1.0, 0], [0, 1]], [[0.0], [1]], np.eye(2), 0), (1,))


def test_without_python_control_the_error_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "control", None)
    with pytest.raises(UnsupportedError, match="control: is not installed .*pip install control"):
        _library()


def single(system: System) -> System:
    """The chain as a float scene computes it."""
    exact = system.functions["linearization"]

    def rounded(*given):
        return tuple(np.asarray(part, dtype=np.float32).astype(float) for part in exact(*given))

    return replace(system, real="float", functions={**system.functions, "linearization": rounded})


@pytest.mark.parametrize(("links", "sample"), [(1, None), (5, None), (2, 0.01)])
def test_gains_of_a_float_scene_carry_their_own_error(links: int, sample: float | None) -> None:
    """Beside the gains of the same chain in double: within what they say, and not far within."""
    chain = planar([0.1] * links, [0.2] * links, cart_mass=0.5, actuated="cart")
    right, found = lqr(chain, sample=sample), lqr(single(chain), sample=sample)
    off = np.max(np.abs(found.K - right.K)) / np.max(np.abs(right.K))
    assert off < found.error < 300 * off + 1e-6 and right.error == 0
    assert f"gains right to {found.error:.1e}" in str(found)


def test_sixteen_links_upright_keep_their_gains() -> None:
    """The largest gain of (A, B) in rational arithmetic and a doubling in 32 digits, to 1e-9: a double alone loses them all."""
    chain = planar([1.0] * 16, [1 / 16] * 16, cart_mass=1.0, actuated="cart")
    assert np.max(np.abs(lqr(chain).K)) == pytest.approx(3985864324618.7007, rel=1e-9)


def test_more_links_than_digits_are_refused_by_how_much() -> None:
    chain = planar([1.0] * 19, [1 / 19] * 19, cart_mass=1.0, actuated="cart")
    with pytest.raises(ControlError, match=r"s: has a regulator whose cost spreads over 32 digits, of which 30 are computed") as refused:
        lqr(chain)
    assert refused.value.lost > 31


def test_an_uncontrollable_equilibrium_names_what_would_be_controllable() -> None:
    """Two links folded on each other with r_2 = l_1 - r_1: the cart feels nothing of one mode."""
    chain = planar([1.0, 1.0], [1.0, 1.0], [0.5, 0.5], cart_mass=1.0, actuated="cart")
    for make in (lambda: lqr(chain, (1, -1)), lambda: place(chain, (1, -1), POLES)):
        with pytest.raises(ControlError, match=r"mode 2 .* is uncontrollable: margin .*such as s = \[1, 1\], \[-1, -1\].*joint 1 or 2") as refused:
            make()
        assert refused.value.equilibria == ((1, 1), (-1, -1)) and refused.value.joints == (1, 2)


def test_the_page_runs(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lines of docs/control.md, as they stand there."""
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[2] / "docs" / "control.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    exec(compile(code, "control.md", "exec"), {})  # noqa: S102 - our own page
    assert (tmp_path / "generated" / "rig_controller" / "manifest.json").exists()
