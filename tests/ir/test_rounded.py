"""Correctly rounded arithmetic: against the two neighbours of an exact number, and against hardware where IEEE 754 fixes the bits."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir.rounded import EPSILON, arithmetic, nearest

TYPES = {"double": np.float64, "float": np.float32}
LEAST = {"double": (-1080, 1020), "float": (-155, 126)}


def numbers(real: str) -> Iterator[Fraction]:
    """Random fractions over the whole range; half-way cases of the type, and hairs to both sides of them."""
    source = random.Random(real)
    bits = 53 if real == "double" else 24
    for _ in range(3000):
        low, high = LEAST[real]
        exponent = source.choice((source.randint(low, high), source.randint(-20, 20), source.randint(low, low + 30)))
        half_way = Fraction(2 * source.getrandbits(bits) + 1, 2) * Fraction(2) ** (exponent - bits)
        hair = half_way / 2 ** source.randint(30, 200)
        yield source.choice((-1, 1)) * (half_way + source.choice((-1, 0, 1)) * hair)
        yield Fraction(source.randint(-(10**9), 10**9), source.randint(1, 10**9)) * Fraction(2) ** exponent


def nearest_by_search(real: str, value: Fraction) -> float:
    """The nearest of three neighbours, the even one of two."""
    kind = TYPES[real]
    middle = kind(float(value))
    around = [middle, np.nextafter(middle, kind(np.inf)), np.nextafter(middle, kind(-np.inf))]
    unsigned = np.uint64 if real == "double" else np.uint32
    finite = [x for x in around if np.isfinite(x)]
    return float(min(finite, key=lambda x: (abs(Fraction(float(x)) - value), int(x.view(unsigned)) & 1)))


@pytest.mark.parametrize("real", TYPES)
def test_numbers_are_rounded_once(real: str) -> None:
    for value in numbers(real):
        expected = nearest_by_search(real, value)
        assert nearest(real, value) == expected
        if value.denominator & (value.denominator - 1) == 0:
            with mp.workprec(1500):
                assert nearest(real, mpf(value.numerator) / value.denominator) == expected


@pytest.mark.parametrize(("real", "largest"), [("double", 2**1024 - 2**971), ("float", 2**128 - 2**104)])
def test_beyond_the_range_is_infinite(real: str, largest: int) -> None:
    half_way = largest + (largest & -largest) // 2
    assert nearest(real, Fraction(half_way) - 1) == largest
    assert nearest(real, Fraction(half_way)) == math.inf == -nearest(real, -Fraction(half_way))
    assert nearest(real, mpf("-inf")) == -math.inf and math.isnan(nearest(real, mpf("nan")))
    assert nearest(real, Fraction(1, 10**400)) == 0.0 and nearest(real, 0) == 0.0


@pytest.mark.parametrize("real", TYPES)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_operations_are_those_of_the_hardware(real: str) -> None:
    """One operation on two scalars is IEEE's on every processor."""
    kind, apply, source = TYPES[real], arithmetic(real).apply, random.Random(real)
    low, high = LEAST[real]
    special = [0.0, -0.0, math.inf, -math.inf, math.nan, 1.0, -1.0]
    expected = {"add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide}
    for turn in range(4000):
        a, b = (
            source.choice(special) if turn % 5 == 0 else nearest(real, math.ldexp(source.uniform(-1, 1), source.choice((0, 3, low // 2, high))))
            for _ in range(2)
        )
        for name, operation in expected.items():
            found, right = apply(name, (a, b), ""), float(operation(kind(a), kind(b)))
            same_sign = math.copysign(1.0, found) == math.copysign(1.0, right)
            assert (math.isnan(found) and math.isnan(right)) or (found == right and same_sign), (name, a, b)
        root = float(np.sqrt(kind(a)))
        assert apply("sqrt", (a,), "") == root or (math.isnan(root) and math.isnan(apply("sqrt", (a,), "")))


@pytest.mark.parametrize("real", TYPES)
def test_sines_and_bessel_functions_are_rounded_once(real: str) -> None:
    algebra, source = arithmetic(real), random.Random(real)
    for _ in range(200):
        x = nearest(real, source.uniform(-30, 30))
        with mp.workdps(60):
            exact = {"sin": mp.sin(x), "cos": mp.cos(x), "besselj3": mp.besselj(3, x)}
            for name, value in exact.items():
                assert abs(algebra.apply(name, (x,), "") - value) <= abs(value) * EPSILON[real] / 2
    assert math.isnan(algebra.apply("sin", (math.inf,), ""))


def test_a_constant_is_rounded_once() -> None:
    tie = Fraction(1) + Fraction(1, 2**24)  # half-way between two binary32; a hair above it binary64 sees nothing
    assert arithmetic("float").constant(tie) == 1.0
    assert arithmetic("float").constant(tie + Fraction(1, 2**90)) == 1 + 1 / 2**23
