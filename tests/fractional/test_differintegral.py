"""Differintegrals of sampled signals against closed forms; their orders of convergence are measured."""

from __future__ import annotations

import tracemalloc
from math import log2
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.errors import ArrayError, PhichainError, SignalError
from phichain.fractional import (
    Differintegral,
    convolution,
    differintegral,
    differintegrate,
    grunwald_letnikov,
)
from tests import tables
from tests.fractional.closed_forms import cosine, exponential, naive_grunwald_letnikov, power

OMEGA, PHASE, END = 1.5, 0.7, 3.0
ORDERS = (1, 2, 3, 4, 5, 6)


def sampled(count: int) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0.0, END, count + 1)
    return t, np.cos(OMEGA * t + PHASE)


def largest_error(count: int, alpha: float, order: int) -> float:
    """Over all t > 0, the first samples included; cos(phase) != 0, so that the start is felt."""
    t, signal = sampled(count)
    found = differintegrate(t, signal, alpha, order=order).values[0]
    return float(np.max(np.abs(found[1:] - cosine(alpha, OMEGA, PHASE, t[1:]))))


@pytest.mark.parametrize("alpha", [-2.5, -2.0, -1.6, -1.0, -0.5, -0.1])
@pytest.mark.parametrize("order", ORDERS)
def test_integrals_converge_at_the_stated_order_up_to_the_start(alpha: float, order: int) -> None:
    count = 400 if order < 6 else 300
    measured = log2(largest_error(count // 2, alpha, order) / largest_error(count, alpha, order))
    assert measured == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("alpha", [0.3, 0.7, 1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize("order", ORDERS)
def test_derivatives_converge_at_the_stated_order_up_to_the_start(alpha: float, order: int) -> None:
    # The finest grids on which truncation still stands well above round-off.
    grids = (1280, 640, 320, 160, 80, 40)
    finest = next(n for n in grids if largest_error(n, alpha, order) > 40.0 * round_off(n, alpha, order))
    measured = log2(largest_error(finest // 2, alpha, order) / largest_error(finest, alpha, order))
    assert measured == pytest.approx(order, abs=0.1)


def round_off(count: int, alpha: float, order: int) -> float:
    """eps (delta_p(-1) / h)^alpha: what the rounding of the samples alone does to a derivative."""
    symbol = sum(2.0**k / k for k in range(1, order + 1))
    return float(np.finfo(float).eps * (symbol * count / END) ** max(alpha, 0.0))


@pytest.mark.parametrize("alpha", [-1.5, -0.5, 0.5])
def test_grunwald_letnikov_is_of_first_order_away_from_the_start(alpha: float) -> None:
    errors = []
    for count in (1000, 2000):
        t, signal = sampled(count)
        errors.append(
            abs(grunwald_letnikov(t, signal, alpha).values[0, -1] - cosine(alpha, OMEGA, PHASE, t[-1:])[0])
        )
    assert log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("alpha", [-2.0, -0.7, 0.0, 0.4, 1.0, 2.5])
def test_grunwald_letnikov_is_the_double_sum(alpha: float) -> None:
    t, signal = sampled(700)
    found = grunwald_letnikov(t, signal, alpha).values[0]
    expected = naive_grunwald_letnikov(signal, t[1], alpha)
    assert np.max(np.abs(found - expected)) <= 2e-14 * np.max(np.abs(expected))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("alpha", [-2.0, -1.5, -0.5, 0.5])
def test_polynomials_below_the_order_are_exact(order: int, alpha: float) -> None:
    t = np.linspace(0.0, 2.0, 900)
    coefficients = [0.7, -1.3, 0.4, 0.9, -0.2, 0.3][:order]
    signal = sum(c * t**k for k, c in enumerate(coefficients))
    expected = sum(c * power(alpha, k, t[1:]) for k, c in enumerate(coefficients))
    found = differintegrate(t, signal, alpha, order=order).values[0, 1:]
    assert np.max(np.abs(found - expected)) < 1e-12 * np.max(np.abs(expected))


@pytest.mark.parametrize("alpha", [-1.4, -0.3, 0.6])
def test_exponential_is_a_mittag_leffler_function(alpha: float) -> None:
    t = np.linspace(0.0, 2.0, 2001)
    found = differintegrate(t, np.exp(-1.3 * t), alpha, order=5).values[0]
    for n in (10, 500, 2000):
        assert found[n] == pytest.approx(exponential(alpha, -1.3, t[n]), rel=1e-11)


def test_every_sample_keeps_its_own_digits_under_growing_weights() -> None:
    # D^-2 of 1 by (3) is (n+1)(n+2)/2 h^2 exactly; one plain FFT of this length is wrong by 1e-6 at the first samples.
    n = np.arange(20000.0)
    found = grunwald_letnikov(n, np.ones(n.size), -2.0).values[0]
    expected = (n + 1.0) * (n + 2.0) / 2.0
    assert np.max(np.abs(found / expected - 1.0)) < 1e-13


@given(alpha=st.floats(-1.5, -0.1), beta=st.floats(-1.4, -0.1))
def test_integrals_compose(alpha: float, beta: float) -> None:
    t = np.linspace(0.0, 2.0, 801)
    signal = t**3 * np.exp(-t)
    once = differintegrate(t, signal, alpha, order=3).values[0]
    twice = differintegrate(t, once, beta, order=3).values[0]
    direct = differintegrate(t, signal, alpha + beta, order=3).values[0]
    assert np.max(np.abs(twice - direct)) < 1e-5


@pytest.mark.long
@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=12), st.sampled_from(ORDERS))
def test_an_order_does_not_depend_on_its_neighbours(orders: list[float], order: int) -> None:
    t, signal = sampled(500)
    together = differintegrate(t, signal, orders, order=order)
    for k, alpha in enumerate(orders):
        alone = differintegrate(t, signal, alpha, order=order).values[0]
        admitted = 100.0 * round_off(500, alpha, order)
        assert np.allclose(together.values[k], alone, rtol=1e-12, atol=admitted, equal_nan=True)


def test_long_signals_come_by_pieces_and_keep_every_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of 64 samples against the double sum, and against one piece; the last piece is a part of one."""
    t, signal = sampled(700)
    pair = np.stack([signal, 1 + t**2], axis=1)
    orders = [-2.0, -0.7, 0.4, 1.0]
    whole = differintegrate(t, pair, orders)
    monkeypatch.setattr(convolution, "PIECE", 64)
    monkeypatch.setattr(convolution, "DIRECT", 16)
    pieces = differintegrate(t, pair, orders)
    assert np.allclose(pieces.values, whole.values, rtol=1e-11, atol=1e-11, equal_nan=True)
    for alpha in (-2.0, -0.7, 0.4):
        found = grunwald_letnikov(t, signal, alpha).values[0]
        expected = naive_grunwald_letnikov(signal, t[1], alpha)
        assert np.max(np.abs(found - expected)) <= 2e-14 * np.max(np.abs(expected))
    n = np.arange(5000.0)
    found = grunwald_letnikov(n, np.ones(n.size), -2.0).values[0]
    assert np.max(np.abs(found / ((n + 1.0) * (n + 2.0) / 2.0) - 1.0)) < 1e-13


def test_many_orders_of_a_long_signal_need_little_beside_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """10^6 samples and 101 orders must fit in 1 GiB, 808 MB of it the result: so many bytes a sample for the rest."""
    monkeypatch.setattr(convolution, "PIECE", 2**13)
    monkeypatch.setattr(differintegral, "_MOST_SCRATCH", 80 * 2**17)
    size = 2**17 + 1
    t, signal = sampled(size - 1)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    record = differintegrate(t, signal, np.linspace(-1.9, -0.1, 7), workers=64)
    beside = tracemalloc.get_traced_memory()[1] - before - record.values.nbytes
    tracemalloc.stop()
    assert beside < 110 * size
    assert np.max(np.abs(record.at(-1.0)[1::999] - cosine(-1.0, OMEGA, PHASE, t[1::999]))) < 1e-13
    assert 101 * 8 * 10**6 + 110 * 10**6 < 2**30 - 128 * 2**20  # what the interpreter and its libraries take


def test_channels_and_threads_change_nothing() -> None:
    t, signal = sampled(600)
    pair = np.stack([signal, np.sin(3.0 * t)], axis=1)
    orders = np.linspace(-2.0, 1.0, 13)
    one, two = (differintegrate(t, pair, orders, workers=count).values for count in (1, 2))
    assert one.shape == (13, 601, 2)
    assert np.array_equal(one, two, equal_nan=True)
    for channel in range(2):
        single = differintegrate(t, pair[:, channel], orders).values
        assert np.allclose(one[:, :, channel], single, rtol=1e-12, atol=1e-12, equal_nan=True)


def test_integrals_start_at_zero_and_derivatives_say_that_they_cannot() -> None:
    t, signal = sampled(50)
    values = differintegrate(t, signal, [-1.5, -0.5, 0.0, 0.5, 1.0]).values
    assert values[:2, 0] == pytest.approx(0.0, abs=1e-15)
    assert values[2, 0] == signal[0]
    assert np.isnan(values[3, 0]) and not np.any(np.isnan(values[:, 1:]))
    assert values[4, 0] == pytest.approx(-OMEGA * np.sin(PHASE), abs=1e-4)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    ("alpha", "powers"),
    [(0.6, [3.0]), (0.6, [1.0, 4.0]), (0.99, [1.5]), (1.5, [2.0]), (1.5, [3.0, 7.0]), (2.4, [3.0]), (0.3, [])],
)
def test_the_first_sample_is_zero_where_the_signal_starts_at_zero(alpha: float, powers: list, order: int) -> None:
    """D^alpha t^b = Gamma(b+1) / Gamma(b+1-alpha) t^(b-alpha), which starts at 0 where b > alpha."""
    t = np.linspace(0.0, 1.0, 101)
    found = differintegrate(t, sum((t**b for b in powers), np.zeros(101)), alpha, order=order).values[0]
    assert found[0] == 0.0 and np.all(np.isfinite(found))
    if powers == [3.0] and order >= 4:
        rounding = 10 * np.finfo(float).eps * (sum(2.0**k / k for k in range(1, order + 1)) * 100) ** alpha
        assert found[1:] == pytest.approx(power(alpha, 3.0, t[1:]), rel=1e-13, abs=rounding)


@pytest.mark.parametrize(
    ("alpha", "start"), [(0.6, 1e-9), (0.6, 1.0), (1.5, 0.0), (2.4, 0.0), (1.2, 1.0)]
)
def test_the_first_sample_is_none_where_the_signal_or_a_derivative_does_not(alpha: float, start: float) -> None:
    t = np.linspace(0.0, 1.0, 101)
    channels = np.stack([start + np.sin(t) if alpha < 2 else t**2, t**4], axis=1)
    found = differintegrate(t, channels, alpha).values[0]
    assert np.isnan(found[0, 0]) and found[0, 1] == 0.0 and np.all(np.isfinite(found[1:]))


def test_a_start_at_the_rounding_of_zero_counts_as_zero() -> None:
    t = np.linspace(0.0, 1.0, 101)
    signal = np.cos(t + np.pi / 2)
    assert 0 < signal[0] < 1e-16 and differintegrate(t, signal, 0.5).values[0, 0] == pytest.approx(0, abs=1e-14)


def test_initial_terms_lead_back_to_the_motion() -> None:
    t = np.linspace(0.0, 4.0, 2001)
    theta, rate, acceleration = np.cos(2 * t + 0.3), -2 * np.sin(2 * t + 0.3), -4 * np.cos(2 * t + 0.3)
    orders = np.linspace(-2.0, 0.0, 9)
    psi = differintegrate(t, acceleration, orders, order=5, initial=(theta[0], rate[0]))
    assert np.max(np.abs(psi.at(-2.0) - theta)) < 1e-11
    assert np.array_equal(psi.at(0.0), acceleration)
    assert np.max(np.abs(psi.at(-1.0)[1:] - rate[1:])) < 1e-10
    # In between it is the Riemann-Liouville differintegral of theta itself, of order alpha + 2.
    for alpha in (-1.75, -1.25, -0.5):
        expected = cosine(alpha + 2.0, 2.0, 0.3, t[1:1000])
        assert np.max(np.abs(psi.at(alpha)[1:1000] - expected) / np.abs(expected).max()) < 1e-11
    assert np.all(np.isnan(psi.values[1:-1, 0])) and not np.any(np.isnan(psi.values[:, 1:]))
    without = differintegrate(t, acceleration, -2.0, order=5).values[0]
    assert np.max(np.abs(without - theta)) > 1.0


def test_shifted_time_and_long_grids_count_from_the_first_sample() -> None:
    t, signal = sampled(300)
    here = differintegrate(t, signal, -1.2).values
    later = differintegrate(t + 1000.0, signal, -1.2).values
    assert np.allclose(here, later, rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "options", "error", "words"),
    [
        ((np.linspace(0, 1, 50), np.ones(50), -3.1), {}, SignalError, "supported range"),
        ((np.linspace(0, 1, 50), np.ones(50), np.nan), {}, SignalError, "supported range"),
        ((np.linspace(0, 1, 50) ** 2, np.ones(50), -1.0), {}, SignalError, "not uniform"),
        ((np.linspace(1, 0, 50), np.ones(50), -1.0), {}, SignalError, "do not increase"),
        ((np.linspace(0, 1, 4), np.ones(4), -1.0), {"order": 4}, SignalError, "too short"),
        ((np.linspace(0, 1, 50), np.r_[np.ones(30), np.nan, np.ones(19)], -1.0), {}, SignalError, "index 30"),
        ((np.linspace(0, 1, 50), np.ones(49), -1.0), {}, ArrayError, "must be"),
        ((np.linspace(0, 1, 50), np.ones(50) * 1j, -1.0), {}, ArrayError, "real"),
        ((np.linspace(0, 1, 50), np.ones(50), []), {}, ArrayError, "vector"),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"order": 7}, SignalError, "no such quadrature"),
        ((np.linspace(0, 1, 50), np.ones(50), 0.5), {"initial": (0.0, 1.0)}, SignalError, r"\[-2, 0\]"),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"initial": (0.0, np.inf)}, SignalError, "finite"),
        (
            (np.linspace(0, 1, 50), np.ones(50), -1.0),
            {"initial": ([1.0, 2.0], 0.0)},
            ArrayError,
            "per channel",
        ),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"initial": (0.0, 1.0, 2.0)}, ArrayError, "no pair"),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"initial": 1.0}, ArrayError, "no pair"),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"order": True}, SignalError, "no such quadrature"),
        ((np.linspace(0, 1, 50), np.ones(50), -1.0), {"workers": 0}, ArrayError, "at least 1"),
    ],
)
def test_bad_input_is_one_clear_error(
    arguments: tuple, options: dict, error: type[PhichainError], words: str
) -> None:
    with pytest.raises(error, match=words):
        differintegrate(*arguments, **options)


def test_record_prints_and_leaves_memory_whole(tmp_path: Path) -> None:
    t, signal = sampled(20)
    record = differintegrate(t, signal, [-1.0, -0.5], order=2)
    assert isinstance(record, Differintegral) and "order 2" in str(record)
    record.to_csv(tmp_path / "d.csv")
    lines = tables.lines(tmp_path / "d.csv")
    assert lines[0] == "t,alpha=-1.0,alpha=-0.5" and float(lines[-1].split(",")[1]) == record.values[0, -1]
    record.to_npz(tmp_path / "d.npz")
    back = Differintegral.from_npz(tmp_path / "d.npz")
    assert all(np.array_equal(getattr(back, name), getattr(record, name)) for name in ("time", "alpha", "values"))
    assert (back.order, back.starting, back.initial) == (record.order, record.starting, record.initial)
