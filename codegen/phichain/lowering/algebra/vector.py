"""Vectors of Program scalars in any dimension: what planar and spatial chains share.

A planar chain is a chain of unit vectors too, q = (sin phi, cos phi); code written with these serves both.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Number

Vector = tuple[Expr, ...]


def load(array: ArrayRef, k: Index, size: int = 3) -> Vector:
    """The k-th vector of an array of vectors."""
    return tuple(array[size * k + i] for i in range(size))


def store(array: ArrayRef, k: Index, value: Vector) -> None:
    """Write the k-th vector."""
    for i, entry in enumerate(value):
        array[len(value) * k + i] = entry


def dot(a: Vector, b: Vector) -> Expr:
    """a . b"""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> Vector:
    """a x b in space, its one component in the plane; (a x b).(c x d) = (a.c)(b.d) - (a.d)(b.c) in both."""
    if len(a) == 2:
        return (a[0] * b[1] - a[1] * b[0],)
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def add(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def sub(a: Vector, b: Vector) -> Vector:
    """a - b"""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(factor: Expr | Number, a: Vector) -> Vector:
    """a factor: every component is written in front of the factor."""
    return tuple(x * factor for x in a)


def multiple(factor: Expr | Number, a: Vector) -> Vector:
    """factor a: the same numbers, with the factor written in front."""
    return tuple(factor * x for x in a)


def down(builder: Builder, size: int, value: Expr | Number = 1) -> Vector:
    """value * e_d, along gravity."""
    return (*zeros(builder, size - 1), builder.lift(value))


def zeros(builder: Builder, size: int) -> Vector:
    """The zero vector."""
    return (builder.lift(0),) * size


def named(builder: Builder, label: str, value: Vector) -> Vector:
    """Give every component a name in the emitted text."""
    return tuple(builder.let(f"{label}_{axis}", x) for axis, x in zip("xyz", value, strict=False))
