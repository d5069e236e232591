"""Binary numbers taken apart: the words and numbers by which the flows' stencils read exponents and make powers of two."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

_FRACTION_BITS: Final = {"double": 52, "float": 23}
_BIAS: Final = {"double": 1023, "float": 127}


def binary_words(real: str) -> dict[str, str]:
    """What stands for the stencils' words: a type, a shift, and masks."""
    bits, bias, width = _FRACTION_BITS[real], _BIAS[real], 64 if real == "double" else 32

    def word(value: int) -> str:
        return f"UINT{width}_C(0x{value:0{width // 4}x})"

    return {
        "PHI_WORD": f"uint{width}_t",
        "PHI_DIGITS": str(bits),
        "PHI_DIGITS_MASK": word((1 << bits) - 1),
        "PHI_ONE_BITS": word(bias << bits),
        "PHI_COUNT_BITS": word((bias + bits) << bits),
    }


def binary_numbers(real: str) -> dict[str, Fraction]:
    """Their numbers: what a counted exponent of 1 reads as, what rounds to whole numbers, from where on all are whole, what splits one in halves, and bounds of powers that exist."""
    bits, bias = _FRACTION_BITS[real], _BIAS[real]
    far = Fraction(1 << (bias - 7))
    return {
        "PHI_COUNT_ONE": Fraction((1 << bits) + bias),
        "PHI_WHOLE": Fraction(1 << bits),
        "PHI_HALVES": Fraction((1 << (bits // 2 + 1)) + 1),
        "PHI_ROUNDER": Fraction(3 << (bits - 1)),
        "PHI_NEAR": 1 / far,
        "PHI_FAR": far,
    }
