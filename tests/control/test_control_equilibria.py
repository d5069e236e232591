"""Equilibria, their eigenstructure, and controllability with its margin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from phichain.control import LinearSystem, controllability, equilibria, equilibrium, feedback, linearize, lqr
from phichain.control.controllability import margins_of
from phichain.errors import ControlError, UnsupportedError
from phichain.system import AbsentFunctionError, System, rhs_jacobian
from tests.handmade import GRAVITY, paper_b, planar, spatial, uniform_planar

PAPER_B = paper_b()


def tangent_spatial(system: System, q: np.ndarray) -> np.ndarray:
    """First-order dynamics in z = [x; C^T xi; x'; C^T omega] from the exact Jacobian of the nonlinear equations."""
    n, nq = system.links, system.nq
    lift = np.zeros((2 * nq, 4 + 4 * n))
    lift[:2, :2] = lift[nq : nq + 2, 2 + 2 * n : 4 + 2 * n] = np.eye(2)
    for k in range(n):
        s = q[4 + 3 * k]
        at = 2 + 3 * k
        # delta q = xi x s e_3 and delta omega = xi'.
        lift[at : at + 3, 2 + 2 * k : 4 + 2 * k] = s * np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, 0.0]])
        lift[nq + at : nq + at + 2, 4 + 2 * n + 2 * k : 6 + 2 * n + 2 * k] = np.eye(2)
    x = np.concatenate([q, np.zeros(nq)])
    return np.linalg.pinv(lift) @ rhs_jacobian(system)(0.0, x) @ lift


def test_the_linearisation_is_the_tangent_of_the_nonlinear_equations() -> None:
    """All 32 equilibria of the five-link chain, and planar ones with dampers."""
    for found in equilibria(PAPER_B):
        A = linearize(PAPER_B, found.s).first_order[0]
        exact = tangent_spatial(PAPER_B, found.q)
        assert np.max(np.abs(A - exact)) < 1e-12 * np.max(np.abs(exact))
    damped = planar([0.3, 0.2], [0.5, 0.4], [0.4, 0.3], cart_mass=0.7, damping=[0.2, 0.1], actuated="all")
    for found in equilibria(damped):
        A, B = linearize(damped, found.s).first_order
        exact = rhs_jacobian(damped)(0.0, np.concatenate([found.q, np.zeros(3)]))
        assert np.max(np.abs(A - exact)) < 1e-12 * np.max(np.abs(exact))
        assert np.allclose(B[3:], damped.state_jacobian(found.q, np.zeros(3), np.zeros(3))[2], rtol=1e-12)


def test_the_32_equilibria_and_their_energies() -> None:
    found = equilibria(PAPER_B)
    assert len({item.s for item in found}) == 32
    assert found[0].s == (1,) * 5 and found[-1].s == (-1,) * 5
    for item in found:
        heights = np.cumsum(0.1 * np.array(item.s))
        assert item.energy == pytest.approx(-GRAVITY * 0.1 * heights.sum(), abs=1e-15)
        rest = PAPER_B.forward_dynamics(item.q, np.zeros(17), np.zeros(2))
        assert np.max(np.abs(rest)) == 0


def test_only_hanging_is_stable() -> None:
    """Elsewhere each upright link gives two falling directions and two real pairs +-lambda."""
    for item in equilibria(PAPER_B):
        upright = sum(sign < 0 for sign in item.s)
        assert item.falling == 2 * upright
        assert item.kind == ("stable" if upright == 0 else "saddle")
        assert np.sum(item.squares > 1e-6) == 2 * upright and np.sum(np.abs(item.squares) < 1e-6) == 2
        growing = item.poles.real[item.poles.real > 1e-6]
        assert len(growing) == 2 * upright
        assert np.allclose(np.sort(growing**2), np.sort(item.squares[item.squares > 1e-6]), rtol=1e-9)


def test_hanging_is_the_minimum_of_the_energy() -> None:
    rng = np.random.default_rng(5)
    lowest = equilibrium(PAPER_B, (1,) * 5).energy
    for _ in range(200):
        directions = rng.normal(size=(5, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        assert PAPER_B.energy(np.concatenate([[0, 0], directions.ravel()]), np.zeros(17))[1] >= lowest


def test_a_spring_can_make_the_inverted_link_stable_and_removes_crooked_equilibria() -> None:
    """k > m g l holds an inverted link up when the spring is relaxed there; with it, hanging is no equilibrium."""
    system = planar([0.2], [0.5], stiffness=[3.0])
    assert [item.s for item in equilibria(system)] == [(1,)]
    with pytest.raises(ControlError, match="no equilibrium of this chain") as caught:
        lqr(planar([0.2], [0.5], stiffness=[3.0], actuated="all"), (-1,))
    assert caught.value.acceleration == pytest.approx(3 * np.pi / (0.2 * 0.25))


def test_too_many_equilibria_are_not_listed() -> None:
    chain = spatial([0.1] * 17, [0.1] * 17)
    with pytest.raises(UnsupportedError, match="2\\^17"):
        equilibria(chain)
    assert equilibrium(chain, [1] * 17).kind == "stable"


def test_masses_at_the_ends_are_always_controllable_from_the_cart() -> None:
    for item in equilibria(PAPER_B):
        found = controllability(PAPER_B, item.s)
        assert found.is_controllable and 1e-3 < found.margin <= 1
        assert len(found.modes) == 10 == len(found.margins)
        swinging = found.modes.imag > 1e-6
        assert np.allclose(found.modes[swinging].real, 0) and np.sum(~swinging) == item.falling


def folded(gap: float = 0.0, gravity: float = GRAVITY, **more) -> System:
    """Two links folded on each other with r_2 = l_1 - r_1 + gap: at gap 0 the cart cannot reach one mode."""
    return planar(
        [0.4, 0.3],
        [1.0, 0.9],
        [0.4, 0.6 + gap],
        cart_mass=0.8,
        gravity=gravity,
        **{"actuated": "cart", **more},
    )


@pytest.mark.parametrize("s", [(1, -1), (-1, 1)])
@pytest.mark.parametrize("angles", ["relative", "absolute"])
def test_a_folded_chain_that_no_force_on_the_cart_can_reach(s, angles) -> None:
    system = folded(angles=angles)
    found = controllability(system, s)
    assert not found.is_controllable and found.margin < 1e-15
    # lambda^2 = s_1 g mu_1 / (m_1 r_1 (l_1 - r_1)), from the first row of the pencil.
    square = s[0] * GRAVITY * (0.4 * 0.4 + 0.3) / (0.4 * 0.4 * 0.6)
    assert found.modes[found.worst] ** 2 == pytest.approx(square)
    with pytest.raises(ControlError, match="uncontrollable: margin") as caught:
        lqr(system, s)
    assert caught.value.mode**2 == pytest.approx(square) and caught.value.margin < 1e-15
    assert caught.value.number == found.worst + 1
    # The mode itself: the rank test (21) on the full first-order system fails at the same eigenvalue.
    A, B = linearize(system, s).first_order
    pencil = np.hstack([A - caught.value.mode * np.eye(6), B])
    assert np.linalg.svd(pencil, compute_uv=False)[-1] < 1e-13


@pytest.mark.parametrize("s", [(1, 1, -1), (-1, 1, -1), (1, -1, 1), (-1, -1, 1)])
def test_two_folded_links_at_the_tip_keep_their_mode(s) -> None:
    """Links 2 and 3 as above, under any first link: lambda^2 = s_2 g mu_2 / (m_2 r_2 (l_2 - r_2))."""
    system = planar([0.5, 0.4, 0.3], [0.7, 1.0, 0.9], [0.3, 0.4, 0.6], cart_mass=0.8, actuated="cart")
    found = controllability(system, s)
    assert not found.is_controllable
    assert found.modes[found.worst] ** 2 == pytest.approx(
        s[1] * GRAVITY * (0.4 * 0.4 + 0.3) / (0.4 * 0.4 * 0.6)
    )


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.floats(0.5, 2.0), st.floats(0.5, 2.0)), min_size=2, max_size=4),
    st.floats(0.2, 1.0),
    st.data(),
)
def test_the_last_mass_alone_may_sit_anywhere(links, share: float, data) -> None:
    """The theorem of theory section 3: r_k = l_k for k < N suffices, at every equilibrium."""
    mass, length = (list(values) for values in zip(*links, strict=True))
    s = data.draw(st.tuples(*[st.sampled_from((1, -1))] * len(links)))
    com = [*length[:-1], share * length[-1]]
    system = planar(mass, length, com, cart_mass=1.0, actuated="cart")
    assert controllability(system, s).margin > 1e-6


def test_the_margin_measures_the_distance_from_it() -> None:
    gaps = np.array([1e-2, 1e-3, 1e-4])
    margins = np.array([controllability(folded(gap), (1, -1)).margin for gap in gaps])
    assert np.allclose(np.diff(np.log(margins)) / np.diff(np.log(gaps)), 1, atol=0.1)
    gains = [np.max(np.abs(lqr(folded(gap), (-1, 1)).K)) for gap in gaps]
    assert gains[0] < gains[1] < gains[2]
    assert controllability(folded(), (1, 1)).margin > 1e-2
    assert controllability(folded(actuated="all"), (1, -1)).margin > 1e-2


def test_single_precision_matrices_are_not_trusted_beyond_their_digits() -> None:
    """The unreachable mode stays unreachable when rounding to single precision lends it a margin of 1e-8."""
    system = folded()

    def rounded(function):
        return lambda *a: tuple(np.float32(part) for part in function(*a))

    functions = {"linearization": rounded(system.linearization)}
    single = System(**{**system.__dict__, "functions": functions, "real": "float"})
    found = controllability(single, (1, -1))
    assert 1e-12 < found.margin < found.limit and not found.is_controllable
    assert controllability(single, (1, 1)).is_controllable


def test_without_gravity_the_links_cannot_be_told_apart() -> None:
    with pytest.raises(ControlError, match="uncontrollable"):
        lqr(folded(gravity=0.0), (1, 1))


def test_dampers_move_the_modes_and_enter_the_test() -> None:
    found = controllability(folded(0.2, damping=[0.3, 0.2]), (1, 1))
    assert np.all(found.modes.real < 0) and found.is_controllable
    A = linearize(folded(0.2, damping=[0.3, 0.2]), (1, 1)).first_order[0]
    assert np.min(np.linalg.eigvals(A).real) < -0.1


def test_joint_torques_on_a_fixed_base() -> None:
    system = uniform_planar(2, actuated="all")
    assert controllability(system, (-1, -1)).is_controllable
    gains = lqr(system, (-1, -1))
    assert gains.K.shape == (2, 4) and gains.decay > 0 and gains.blocks["K_x"].shape == (2, 0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lqr(PAPER_B, (1, 1, 1, 1)), "one sign per link"),
        (lambda: lqr(PAPER_B, (1, 1, 0, 1, 1)), "one sign per link"),
        (lambda: lqr(PAPER_B, (1, 1, 0.5, 1, 1)), "one sign per link"),
        (lambda: lqr(PAPER_B, (1, 1, np.nan, 1, 1)), "one sign per link"),
        (lambda: lqr(PAPER_B, R=0.0), "R: must be positive definite"),
        (lambda: lqr(PAPER_B, R=-1.0), "R: must be positive definite"),
        (lambda: lqr(PAPER_B, R=[1.0, 0.0]), "R: must be positive definite"),
        (lambda: lqr(PAPER_B, Q=-1.0), "Q: must be positive semidefinite"),
        (lambda: lqr(PAPER_B, Q=0.0), "Q: must be positive semidefinite"),
        (lambda: lqr(PAPER_B, Q=np.diag([1.0] * 23 + [-1e-3])), "smallest eigenvalue is -0.001"),
        (lambda: lqr(PAPER_B, Q=np.ones(23)), "weigh 24 quantities"),
        (lambda: lqr(PAPER_B, Q=np.triu(np.ones((24, 24)))), "not symmetric"),
        (lambda: lqr(PAPER_B, Q=np.nan), "not finite"),
        (lambda: lqr(PAPER_B, (1,) * 5, Q=[0, 0] + [1] * 22), "Q: does not weigh the mode lambda = "),
        (lambda: lqr(uniform_planar(2), (1, 1)), "no input"),
        (lambda: lqr(PAPER_B, "up"), "s: does not hold real numbers"),
        (lambda: lqr(PAPER_B, [1, [1, 1]]), "s: does not hold real numbers"),
        (lambda: lqr(PAPER_B, Q="identity"), "Q: does not hold real numbers"),
        (lambda: lqr(PAPER_B, R=[[1.0], [1.0, 2.0]]), "R: does not hold real numbers"),
        (lambda: lqr(PAPER_B, R=1j), "R: does not hold real numbers"),
        (lambda: feedback(PAPER_B, lqr(PAPER_B), ["here", "there"]), "target: does not hold real numbers"),
    ],
)
def test_bad_input_is_one_control_error(call, words) -> None:
    with pytest.raises(ControlError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_system_without_linearization_says_what_to_add() -> None:
    with pytest.raises(AbsentFunctionError, match="linearization"):
        lqr(planar([0.1], [0.1], cart_mass=1.0, actuated="cart", leave_out=["linearization"]))


def test_without_dynamics_the_target_is_taken_on_trust() -> None:
    blind = planar([0.1], [0.1], cart_mass=1.0, actuated="cart", leave_out=["forward_dynamics", "energy"])
    assert lqr(blind).decay > 0 and equilibrium(blind, [1]).energy is None


def test_a_mode_is_judged_on_every_part_that_does_not_mix() -> None:
    """Two pendulums with inputs of their own, one of which hardly acts: the margin of the whole pencil at each mode."""
    M, G, B = np.diag([1.0, 2.0]), np.diag([3.0, 5.0]), np.diag([1.0, 1e-3])
    zero = np.zeros((2, 2))
    first_order = np.block([[zero, np.eye(2)], [-np.linalg.solve(M, G), zero]]), np.vstack([zero, np.linalg.solve(M, B)])
    found = margins_of(LinearSystem((1, 1), M, zero, G, B, 0, ("a", "b"), first_order))
    stiffness, drive = np.diag([3.0, 2.5]), np.diag([1.0, 1e-3 / np.sqrt(2)])
    expected = [
        np.linalg.svd(np.hstack([(stiffness - w * np.eye(2)) / 3.0, drive]), compute_uv=False)[-1] for w in (2.5, 3.0)
    ]
    assert found.margins == pytest.approx(expected, rel=1e-12)
