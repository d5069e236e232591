"""What dry friction along a vector is regularised by where the vector vanishes, said once for every layer that writes the law."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

#: Added to |w|^2 / v_0^2 before its root is taken, so that root and quotient have values and derivatives at rest: no digit of
#: any arithmetic sees it, and its inverse has room in single precision.
LEAST_SQUARE: Final = Fraction(1, 2**126)
