"""The Jacobi-Anger series against quadrature of what they expand, and products of cosine series."""

from __future__ import annotations

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from phichain.harmonic.series import COSINE, SINE_SQUARED, CosineSeries, cosine_of, sine_of


@pytest.mark.parametrize("z", [0.3, -2.1, 7.5])
def test_jacobi_anger_coefficients_are_fourier_coefficients(z: float) -> None:
    for series, function in ((cosine_of(z, 7), mp.cos), (sine_of(z, 7), mp.sin)):
        for n in range(8):
            integral = mp.quad(
                lambda t, n=n, f=function: f(z * mp.cos(t)) * mp.cos(n * t), mp.linspace(0, 2 * mp.pi, 9)
            )
            expected = integral / (mp.pi if n else 2 * mp.pi)
            assert abs(float(series.harmonic(n)) - expected) < 1e-13


series = st.dictionaries(st.integers(0, 5), st.integers(-9, 9).map(sympy.Integer), min_size=1).map(
    CosineSeries
)


@given(a=series, b=series)
def test_products_multiply_values(a: CosineSeries, b: CosineSeries) -> None:
    def value(of: CosineSeries, tau: float) -> float:
        return float(sum(float(c) * mp.cos(n * tau) for n, c in of.coefficients.items()))

    for tau in (0.0, 0.7, 2.9):
        assert value(a * b, tau) == pytest.approx(value(a, tau) * value(b, tau), abs=1e-9)


def test_sine_squared_is_one_minus_cosine_squared() -> None:
    square = COSINE * COSINE
    assert {n: -c for n, c in square.coefficients.items() if n} == {
        n: c for n, c in SINE_SQUARED.coefficients.items() if n
    }
    assert 1 - square.harmonic(0) == SINE_SQUARED.harmonic(0)
