"""The field of integers modulo the prime 2^61 - 1: exact numbers, reproducible random ones, and the points of circle and sphere.

A scene's numbers are dyadic rationals, so each has an image here without rounding. An identity between rational functions that
holds at a random point of the field fails elsewhere with probability below degree / 2^61 (Schwartz and Zippel).
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Final

from phichain.mechanics.residues import PRIME, inverse

__all__ = ["HALF", "PRIME", "Source", "Vector", "cross", "dot", "exact", "inverse", "plus", "root"]

HALF: Final = (PRIME + 1) // 2
"""1/2."""

Vector = list[int]


def exact(value: Fraction | float) -> int:
    """The image of a rational number.

    Raises:
        ZeroDivisionError: the prime divides its denominator.
    """
    ratio = Fraction(value)
    return ratio.numerator * inverse(ratio.denominator) % PRIME


def root(value: int) -> int:
    """The square root that is a square itself, of what is a square: with the prime 3 modulo 4 there is one."""
    return pow(value, (PRIME + 1) // 4, PRIME)


def dot(a: Iterable[int], b: Iterable[int]) -> int:
    """a.b"""
    return sum(x * y for x, y in zip(a, b, strict=True)) % PRIME


def cross(a: Sequence[int], b: Sequence[int]) -> Vector:
    """a x b"""
    return [
        (a[1] * b[2] - a[2] * b[1]) % PRIME, (a[2] * b[0] - a[0] * b[2]) % PRIME, (a[0] * b[1] - a[1] * b[0]) % PRIME
    ]  # fmt: skip


def plus(a: Sequence[int], b: Sequence[int], weight: int = 1) -> Vector:
    """a + weight b"""
    return [(x + weight * y) % PRIME for x, y in zip(a, b, strict=True)]


class Source:
    """Random elements of the field, the same for the same words on every machine."""

    def __init__(self, *words: object) -> None:
        """Seed by a hash of the words: a scene's digest, the number of a point, a purpose."""
        seed = hashlib.sha256("\0".join(map(str, words)).encode()).digest()
        self._random = random.Random(int.from_bytes(seed))

    def element(self) -> int:
        """One element, never zero."""
        return 1 + self._random.getrandbits(128) % (PRIME - 1)

    def vector(self, size: int) -> Vector:
        """Several."""
        return [self.element() for _ in range(size)]

    def circle(self) -> tuple[int, int]:
        """(cosine, sine) of an angle: a point of the unit circle."""
        t = self.element()
        scale = inverse(1 + t * t)
        return (1 - t * t) * scale % PRIME, 2 * t * scale % PRIME

    def sphere(self) -> Vector:
        """A unit vector of three components."""
        s, t = self.element(), self.element()
        scale = inverse(1 + s * s + t * t)
        return [2 * s * scale % PRIME, 2 * t * scale % PRIME, (1 - s * s - t * t) * scale % PRIME]

    def across(self, unit: Sequence[int]) -> Vector:
        """A vector orthogonal to a unit vector."""
        return cross(self.vector(3), unit)
