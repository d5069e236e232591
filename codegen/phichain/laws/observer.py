"""An observer: the deviation from a target, estimated from one measurement after another of a part of it."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.laws.numbers import Matrix, as_numbers


@dataclass(frozen=True)
class Observer:
    """z = z_expected + L w(y - y_0 - C z_expected), then z_expected = F w(z) + H (u - u_0) for the next call.

    Stationary: the same matrices at every call. w takes whole turns from angles. An innovation that is not finite (a sensor that
    is silent) corrects nothing.

    Attributes:
        kind: "kalman" or "reduced"; a reduced one takes what is measured for exact, C L = 1.
        advance: F (n, n), the deviation from one call to the next.
        drive: H (n, nu), what an input that is held in between adds.
        seen: C (ny, n), what is measured of the deviation.
        correction: L (n, ny).
        start: The pseudoinverse of C (n, ny): from the first measurement to the first estimate, at rest.

    Raises:
        ArrayError: Shapes that do not fit, or numbers that are not finite.
    """

    kind: str
    advance: Matrix
    drive: Matrix
    seen: Matrix
    correction: Matrix
    start: Matrix

    def __post_init__(self) -> None:
        n, ny = len(self.advance), len(self.seen)
        nu = len(self.drive[0]) if n else 0
        shapes = {"advance": (n, n), "drive": (n, nu), "seen": (ny, n), "correction": (n, ny), "start": (n, ny)}
        for field, shape in shapes.items():
            object.__setattr__(self, field, as_numbers(f"observer.{field}", getattr(self, field), shape))
