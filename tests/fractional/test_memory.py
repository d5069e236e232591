"""The short-memory principle: its bound holds, the printed one does not, and integrals are refused."""

from __future__ import annotations

from math import gamma

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.errors import ArrayError, SignalError, ToleranceError
from phichain.fractional import grunwald_letnikov, implied_error, memory_length, short_memory

TIME = np.linspace(0.0, 8.0, 801)


@given(
    alpha=st.floats(0.1, 2.9),
    tolerance=st.floats(1e-3, 1.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_truncation_stays_within_the_tolerance(alpha: float, tolerance: float, seed: int) -> None:
    # Random signs are the worst a bounded signal can do.
    signal = np.random.default_rng(seed).choice([-1.0, 1.0], TIME.size)
    whole = grunwald_letnikov(TIME, signal, alpha).values[0]
    short = short_memory(TIME, signal, alpha, tolerance=tolerance)
    round_off = 1e-13 * (2.0 / TIME[1]) ** alpha
    assert short.implied_error <= tolerance * (1.0 + 1e-9)
    assert np.max(np.abs(short.values - whole)) <= short.implied_error + round_off


def test_bound_is_reached_by_a_constant() -> None:
    # D^alpha 1 = t^-alpha / Gamma(1-alpha); with a memory L it settles at L^-alpha / Gamma(1-alpha).
    short = short_memory(TIME, np.ones(TIME.size), 0.5, length=2.0)
    whole = grunwald_letnikov(TIME, np.ones(TIME.size), 0.5).values[0]
    settled = short.values[-1] - whole[-1]
    assert short.values[-1] == pytest.approx(implied_error(0.5, 2.0), rel=2e-3)
    assert abs(settled) <= short.implied_error


def test_printed_bound_would_break_the_tolerance() -> None:
    alpha, tolerance = 0.9, 0.01
    right, printed = memory_length(alpha, tolerance), 1.0 / (tolerance**2 * gamma(alpha))
    assert right == pytest.approx((1.0 / (tolerance * gamma(1.0 - alpha))) ** (1.0 / alpha))
    assert implied_error(alpha, right) == pytest.approx(tolerance)
    # Here the printed length is hundreds of times too long, at alpha = 0.2 it is too short.
    assert printed > 100.0 * right
    assert implied_error(0.2, 1.0 / (tolerance**2 * gamma(0.2))) > tolerance


def test_short_length_says_the_error_it_implies() -> None:
    with pytest.raises(ToleranceError, match=r"implies a relative error of 0\.564") as caught:
        short_memory(TIME, np.ones(TIME.size), 0.5, length=1.0, tolerance=0.1)
    assert caught.value.implied_error == pytest.approx(1.0 / gamma(0.5))
    assert caught.value.bound == pytest.approx(memory_length(0.5, 0.1))
    exact = short_memory(TIME, np.ones(TIME.size), 0.5, length=memory_length(0.5, 0.25), tolerance=0.25)
    assert exact.implied_error <= 0.25


@pytest.mark.parametrize("alpha", [0.0, -0.5, -2.0])
def test_integrals_are_not_truncated(alpha: float) -> None:
    for attempt in (
        lambda: short_memory(TIME, np.ones(TIME.size), alpha, length=1.0),
        lambda: memory_length(alpha, 0.1),
        lambda: implied_error(alpha, 1.0),
    ):
        with pytest.raises(SignalError, match="keeps its whole memory"):
            attempt()


def test_whole_derivatives_need_no_memory() -> None:
    signal = np.sin(TIME)
    short = short_memory(TIME, signal, 2.0, tolerance=1e-9)
    assert short.length == pytest.approx(2 * TIME[1]) and short.implied_error == 0.0
    assert np.allclose(short.values, grunwald_letnikov(TIME, signal, 2.0).values[0], rtol=0, atol=1e-9)


def test_channels_and_long_memories() -> None:
    signal = np.stack([np.sin(TIME), np.cos(TIME)], axis=1)
    short = short_memory(TIME, signal, 0.4, length=100.0)
    whole = grunwald_letnikov(TIME, signal, 0.4).values[0]
    assert short.values.shape == whole.shape and np.allclose(short.values, whole, atol=1e-11)


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({}, SignalError),
        ({"length": 0.0}, SignalError),
        ({"length": np.nan}, SignalError),
        ({"tolerance": 0.0}, ToleranceError),
        ({"tolerance": np.nan}, ToleranceError),
        ({"length": "long"}, ArrayError),
        ({"tolerance": [1e-3]}, ArrayError),
    ],
)
def test_bad_lengths_and_tolerances(options: dict, error: type[Exception]) -> None:
    with pytest.raises(error):
        short_memory(TIME, np.ones(TIME.size), 0.5, **options)


def test_an_order_that_hardly_forgets_says_so() -> None:
    with pytest.raises(ToleranceError, match="no finite memory keeps it for alpha = 1e-06"):
        short_memory(TIME, np.ones(TIME.size), 1e-6, tolerance=1e-3)
    with pytest.raises(ArrayError, match="one real number"):
        short_memory(TIME, np.ones(TIME.size), [0.3, 0.4], length=1.0)  # type: ignore[arg-type]
