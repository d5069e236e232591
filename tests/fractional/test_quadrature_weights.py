"""The weights and the quadrature's error on powers of t, against 40 and 60 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.fractional import series, weights
from tests.fractional.closed_forms import lubich_weights

SIZE = 500


def rule_of(order: int, alpha: float, size: int = SIZE) -> tuple[weights.Quadrature, weights.Basis]:
    starting = weights.starting_values(order, alpha)
    return weights.quadrature(order, starting, np.array([alpha]), size), weights.Basis(order, size)


@pytest.mark.parametrize("order", weights.ORDERS)
@pytest.mark.parametrize("alpha", [-2.0, -1.3, -0.02, 0.5, 1.7])
def test_weights_agree_with_forty_digits_in_head_and_tail(order: int, alpha: float) -> None:
    with mpmath.workdps(40):
        expected = np.array([float(w) for w in lubich_weights(order, alpha, SIZE)])
    found = weights.weights(*rule_of(order, alpha)[:1], slice(0, 1), rule_of(order, alpha)[1])[0]
    # Weights of a derivative pass through zero near the start: there relative to the algebraic envelope.
    envelope = np.arange(1.0, SIZE + 1) ** (-alpha - 1.0) * abs(
        series.reciprocal_gammas(np.array([alpha]), 0, 1)[0, 0]
    )
    assert np.max(np.abs(found - expected) / np.maximum(np.abs(expected), envelope)) < 2e-12
    tail = slice(weights.HEAD[order], None)
    assert np.max(np.abs(found[tail] / expected[tail] - 1.0)) < 1e-14


@pytest.mark.parametrize(("order", "alpha"), [(1, -1.37), (1, 0.4), (5, -0.6)])
def test_far_weights_keep_their_digits_with_few_terms(order: int, alpha: float) -> None:
    size = 3000
    rule, basis = rule_of(order, alpha, size)
    with mpmath.workdps(30):
        expected = lubich_weights(order, alpha, size)
    found = weights.weights(rule, slice(0, 1), basis)[0]
    for n in (2047, 2048, 2049, size - 1):
        assert found[n] == pytest.approx(float(expected[n]), rel=1e-14)


@pytest.mark.parametrize("order", [1, 2, 4, 6])
@pytest.mark.parametrize("alpha", [-2.0, -0.5, 0.3, 1.5])
def test_error_on_powers_keeps_its_digits_where_the_difference_has_none(order: int, alpha: float) -> None:
    rule, basis = rule_of(order, alpha)
    n = SIZE - 1
    with mpmath.workdps(60):
        exact_weights, a = lubich_weights(order, alpha, SIZE), mpmath.mpf(alpha)
        for q in range(rule.starting):
            begin = weights.Start(np.eye(rule.starting)[q], np.zeros((basis.near, basis.near)), 0)
            exact = mpmath.factorial(q) * mpmath.rgamma(q + 1 - a) * mpmath.mpf(n) ** (q - a)
            sampled = mpmath.fsum(exact_weights[n - j] * mpmath.mpf(j) ** q for j in range(n + 1))
            expected = exact - sampled
            found = np.zeros((1, SIZE))
            weights.correct(found, rule, slice(0, 1), basis, begin)
            assert abs(found[0, n] - expected) <= 1e-13 * abs(expected) + 1e-16 * mpmath.mpf(n) ** (-a - 1)


@given(alpha=st.floats(-1.5, 1.5), beta=st.floats(-1.5, 1.5), order=st.sampled_from(weights.ORDERS))
def test_powers_of_the_generating_function_multiply(alpha: float, beta: float, order: int) -> None:
    size = 60
    first, second, both = (
        weights.weights(*rule_of(order, a, size)[:1], slice(0, 1), rule_of(order, a, size)[1])[0]
        for a in (alpha, beta, alpha + beta)
    )
    product = np.convolve(first, second)[:size]
    scale = np.convolve(np.abs(first), np.abs(second))[:size]
    assert np.all(np.abs(product - both) <= 1e-12 * scale + 1e-13 * np.max(np.abs(both)))


def test_whole_orders_have_their_exact_finite_weights() -> None:
    second_difference = rule_of(1, 2.0)[0].head[0]
    assert second_difference.tolist() == [1.0, -2.0, 1.0] + [0.0] * (weights.HEAD[1] - 3)
    rule, basis = rule_of(1, -1.0)
    assert np.array_equal(weights.weights(rule, slice(0, 1), basis)[0], np.ones(SIZE))


def test_number_of_starting_values_grows_with_the_derivative() -> None:
    assert [weights.starting_values(4, a) for a in (-2.0, 0.0, 0.1, 1.0, 1.5)] == [4, 4, 5, 5, 6]


def test_difference_weights_are_the_tabulated_ones() -> None:
    assert series.difference_weights(3, 1, 1).tolist() == [-0.5, 0.0, 0.5]
    assert series.difference_weights(3, 2, 0).tolist() == [1.0, -2.0, 1.0]
    assert series.difference_weights(5, 1, 2).tolist() == pytest.approx([1 / 12, -2 / 3, 0.0, 2 / 3, -1 / 12])


def test_power_sums_are_the_zeta_values() -> None:
    found = series.power_sum_series(1, 6)
    expected = [float(mpmath.zeta(-1 - k)) * (-1) ** k / float(mpmath.factorial(k)) for k in range(6)]
    assert found == pytest.approx(expected, abs=1e-18)
