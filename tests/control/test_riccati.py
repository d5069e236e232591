"""The Riccati equation by blocks, by doubling and in twice the digits, against other routes and known gains."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from phichain.control import linearize, lqr
from phichain.control.equations import riccati as module
from phichain.control.equations import wide
from phichain.control.equations.blocks import blocks
from phichain.control.equations.doubling import doubled, doubled_wide
from phichain.control.equations.riccati import ordered_schur, riccati
from phichain.control.equations.wide import Wide
from phichain.errors import ControlError
from tests.handmade import paper_b, planar, spatial

PAPER_B = paper_b()


def test_the_two_planes_are_one_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solved once; xi_1 turns the other way than xi_2, so that K_2 is K_1 with the sign of its angles changed."""
    solved = []
    monkeypatch.setattr(module, "_refined", lambda *part, refined=module._refined: solved.append(part[0].shape) or refined(*part))
    gains = lqr(PAPER_B, (1, -1, -1, 1, -1))
    assert solved == [(1, 12, 12)]
    first, second = gains.K[0].reshape(2, 6, 2), gains.K[1].reshape(2, 6, 2)
    assert np.array_equal(first[:, 0, 0], second[:, 0, 1])
    assert np.array_equal(first[:, 1:, 1], -second[:, 1:, 0])
    assert not np.any(first[:, 0, 1]) and not np.any(first[:, 1:, 0])
    weights = np.ones(24)
    weights[2] = 3.0
    solved.clear()
    other = lqr(PAPER_B, (1, -1, -1, 1, -1), Q=weights)
    assert solved == [(1, 12, 12)] * 2 and np.array_equal(other.K[0], gains.K[0])
    solved.clear()
    lqr(PAPER_B, Q=np.ones((24, 24)) + np.eye(24))
    assert solved == [(1, 24, 24)]


@given(arrays(float, (4, 4), elements=st.floats(-2, 2)), st.permutations(range(8)), st.lists(st.sampled_from([1.0, -1.0]), min_size=8, max_size=8))
def test_blocks_are_found_under_any_order_and_signs(inner, order, signs) -> None:
    """Two equal blocks, mixed up and turned: the parts come out in one canonical form."""
    chain = np.eye(4, k=1) + np.diag([0.0, *inner[0, 1:]]) + np.diag([3.0, 4.0, 5.0], -1)
    drive = np.array([[0.0], [0.0], [0.0], [1.0]])
    A, B = np.kron(np.eye(2), chain), np.kron(np.eye(2), drive)
    order = [k for k in order if k < 4] + [k for k in order if k >= 4]
    turn = np.diag(signs)
    mixed, force = (turn @ A @ turn)[np.ix_(order, order)], (turn @ B)[order]
    ((_, found),) = blocks((mixed[None],), force[None])
    assert sorted(len(block.states) for block in found) == [4, 4]
    for block in found:
        positions = np.array(order)[block.states] % 4
        back = np.argsort(positions)
        square, across = block.square(mixed)[0][np.ix_(back, back)], block.across(force)[0][back]
        assert np.array_equal(np.abs(square), np.abs(chain)) and np.array_equal(np.abs(across), np.abs(drive))
        assert np.array_equal(np.diag(square), np.diag(chain))


def test_parts_without_an_input_stay_with_the_whole() -> None:
    A = np.diag([-1.0, -2.0, -3.0])
    ((_, (block,)),) = blocks((A[None],), np.array([[[1.0], [1.0], [0.0]]]))
    assert block.states.tolist() == [0, 1, 2] and block.square(A)[0].tolist() == A.tolist()
    found = riccati(A, np.array([[1.0], [1.0], [0.0]]), np.eye(3), np.eye(1))
    assert found.S[2, 2] == pytest.approx(1 / 6) and found.K[0, 2] == 0


def two_rods(**more: object):
    """Two uniform rods (.5 kg, .5 m) on a cart of 1 kg as point masses: section 1.1's equivalence, from the tip."""
    tip, base = (0.125, 0.125 / 3), (0.375 - 0.5 * 0.375, 0.5 / 3 - 0.25 * 0.375)
    (mass_2, com_2), (mass_1, com_1) = (((a * a) / b, b / a) for a, b in (tip, base))
    return planar([mass_1, mass_2], [0.5, 0.5], [com_1, com_2], cart_mass=2 - mass_1 - mass_2, **more)


def test_the_gains_of_two_rods_on_a_cart() -> None:
    system = two_rods(angles="absolute", actuated="cart", gravity=9.8)
    gains = lqr(system, Q=[50, 50, 50, 20, 700, 700], R=1)
    expected = [7.07106781, 438.81392912, -556.47989845, 14.76770454, 4.82407542, -78.04248163]
    assert gains.K[0] == pytest.approx(np.array(expected), abs=6e-9) or gains.K[0] == pytest.approx(-np.array(expected), abs=6e-9)


def test_the_gains_of_a_cart_with_friction() -> None:
    """Cart 2 kg with .1 N s/m, two masses .2 kg on .6 m."""
    linear = linearize(planar([0.2, 0.2], [0.6, 0.6], cart_mass=2.0, angles="absolute", actuated="cart"), (-1, -1))
    friction = np.zeros((3, 3))
    friction[0, 0] = 0.1
    A, B = linear.first_order
    A = A.copy()
    A[3:, 3:] = -np.linalg.solve(linear.M, friction)
    found = riccati(A, B, np.diag([1.0, 100, 100, 1, 10, 0.1]), np.array([[0.1]]))
    expected = [3.16227766, 411.85064877, -493.3603324, 8.71695113, 27.82476306, -85.07905641]
    assert found.K[0] == pytest.approx(np.array(expected), abs=6e-9)


def test_fourteen_upright_links_need_twice_the_digits() -> None:
    """Doubles and long doubles lose every digit here; 50 digits say the same as what comes out."""
    system = planar([1.0] * 14, [1 / 14] * 14, cart_mass=1.0, angles="relative", actuated="cart")
    gains = lqr(system)
    assert gains.decay == pytest.approx(0.18587275344627638, rel=1e-8)
    assert np.max(np.abs(gains.K)) == pytest.approx(1.341e11, rel=1e-3)
    assert gains.residual < 1e-15


def test_twice_the_digits_agree_with_doubles_where_these_serve() -> None:
    gains = lqr(planar([0.1] * 3, [0.1] * 3, cart_mass=0.5, actuated="cart"), (-1, -1, 1))
    A, B, Q, R = gains.A, gains.B, gains.Q, gains.R
    extended = module.Equations.of(A[None], B[None], Q[None], R[None])
    precise = module._in_twice_the_digits(extended, A, B, Q, R)
    assert np.max(np.abs(precise.K - gains.K)) < 1e-14 * np.max(np.abs(gains.K))
    assert np.allclose(precise.poles, gains.poles, rtol=1e-10)
    schur = ordered_schur(A, B, Q, R)
    assert np.allclose(doubled(A[None], (B @ B.T)[None], Q[None])[0], schur, rtol=1e-8, atol=1e-8 * np.max(schur))


def exactly(value: Wide) -> list[list[mpmath.mpf]]:
    return [[mpmath.mpf(h) + mpmath.mpf(l) for h, l in zip(*rows, strict=True)] for rows in zip(value.high, value.low, strict=True)]


def test_wide_numbers_keep_thirty_digits() -> None:
    rng = np.random.default_rng(8)
    a, b = (Wide(part, part * 1e-17 * rng.uniform(-1, 1, part.shape)) for part in rng.normal(size=(2, 7, 7)))
    spd = a @ a.T + Wide.of(np.eye(7))
    with mpmath.workdps(50):
        x, y = (mpmath.matrix(exactly(part)) for part in (a, b))
        for found, expected in (
            (a + b, x + y),
            (a - b, x - y),
            (a @ b, x * y),
            (a * 0.3, x * mpmath.mpf(0.3)),
            (wide.inverse(a), x**-1),
            (wide.cholesky(spd), mpmath.cholesky(mpmath.matrix(exactly(spd)))),
        ):
            gap = mpmath.matrix(exactly(found)) - expected
            assert max(map(abs, gap)) < 1e-29 * max(map(abs, expected))
        quotient = exactly(a / b)
        assert max(abs(q - x[i, j] / y[i, j]) / abs(q) for i, r in enumerate(quotient) for j, q in enumerate(r)) < 1e-30
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        wide.cholesky(a @ a.T * -1.0)
    zero = Wide.of(np.zeros((2, 2)))
    assert np.allclose(doubled_wide(Wide.of(-np.eye(2)), zero, Wide.of(np.eye(2))).high, np.eye(2) / 2, rtol=1e-15)


def test_spatial_gains_are_right_where_long_doubles_are_not() -> None:
    """Eleven links upright: the longest corrections of long doubles go astray, and the result is still settled."""
    system = spatial([0.1] * 11, [0.1] * 11, cart_mass=0.5)
    gains = lqr(system)
    along = [0, *range(3, 24, 2), 24, *range(27, 48, 2)]
    A, B, Q = gains.A[np.ix_(along, along)], gains.B[along][:, :1], gains.Q[np.ix_(along, along)]
    a, b = Wide.of(A), Wide.of(B)
    S = doubled_wide(a, b @ b.T, Wide.of(Q))
    assert np.max(np.abs((b.T @ S).high - gains.K[:1, along])) < 1e-8 * np.max(np.abs(gains.K))
    assert gains.decay > 0


@pytest.mark.parametrize("size", [2.0**700, 1e300])
def test_weights_whose_squares_overflow_are_solved_by_their_ratio(size: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """K of the ratio, S of the weights themselves, and nothing that is solved has a weight whose square overflows."""
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    plain, seen = riccati(A, B, np.eye(2), np.eye(1)), []
    solver = module.by_blocks
    monkeypatch.setattr(module, "by_blocks", lambda a, b, q, r, one: seen.append((q.max(), r.max())) or solver(a, b, q, r, one))
    found = riccati(A, B, size * np.eye(2), size * np.eye(1))
    np.testing.assert_allclose(found.K, plain.K, rtol=1e-14)
    np.testing.assert_allclose(found.S / size, plain.S, rtol=1e-14)
    assert len(seen) == 1 and max(seen[0]) <= 2.0 and found.poles[0].real < 0
    with pytest.raises(ControlError, match="a weight is 1e.150 times the other or more"):
        riccati(A, B, size * np.eye(2), np.eye(1))
