r"""Numbers of the emitted sine-cosine kernel (`templates/trig/sincos.c.j2`): coefficients, splittings, bounds.

The kernel turns n angles x at once, without branches, so that a compiler vectorises it over the links:

    q = round(x 2/pi),   r - e = x - q pi/2                       (Cody & Waite's reduction, 1980)
    sin(r - e) = r - (r^3 S(r^2) + e (1 - r^2/2)),   cos(r - e) = 1 - r^2/2 + (r^4 C(r^2) + r e),

then the quadrant q mod 4 exchanges the two and sets their signs. All quantities are pure numbers (radians).

Reduction. pi/2 = P1 + P2 + P3 with P1, P2 of p - b bits (p = 53 or 24), so that q P1 and q P2 are exact for
|q| <= 2^b, as are x - q P1 and the error of the second subtraction; only q P3 is rounded. b is the largest
that keeps the error left in r - e small, relative to r - e, at the floating-point numbers nearest to all
2^b multiples of pi/2, which a test repeats: 2^-57.9 for double with b = 18, 2^-25.4 for float with b = 11.
No fused multiply-add is needed, and one does not disturb. Adding and subtracting 1.5 2^(p-1) rounds to the
nearest integer; the sum's last bits hold q.

Polynomials. S and C interpolate at the zeros of a Chebyshev polynomial, mapped so that its smallest zero
lies at r = 0, where the relative error vanishes anyway: 6 + 6 terms for double leave 2^-57.8 and 2^-63.3,
3 + 3 for float 2^-27.8 and 2^-32.4, at most 1.1 times the minimax error. A coefficient is rounded to the
format before the next ones are found, so that they make up for its rounding. The derivation, in mpmath::

    from mpmath import cos, frexp, ldexp, lu_solve, matrix, mpf, nint, pi, polyval, sin, sqrt, workprec

    def rounded(value, bits):
        mantissa, exponent = frexp(value)
        return ldexp(nint(ldexp(mantissa, bits)), exponent - bits)

    def fit(series, count, order, bits, top):
        size = count + order
        zeros = [cos(pi * (mpf(i) + 0.5) / size) for i in range(size)]
        points = [top * (zero - zeros[-1]) / (1 - zeros[-1]) for zero in zeros]
        known = []
        for free in range(count, 0, -1):
            rows = matrix([[z**j for j in range(free)] for z in points[:free]])
            rest = [(series(z) - polyval(known[::-1] or [0], z)) / z ** len(known) for z in points[:free]]
            known.append(rounded(lu_solve(rows, matrix(rest))[0], bits))
        return known

    def sine_rest(z):
        return (1 - sin(sqrt(z)) / sqrt(z)) / z

    def cosine_rest(z):
        return (cos(sqrt(z)) - 1 + z / 2) / z**2

    derived = {}
    with workprec(300):
        for real, bits, count, slack in (("double", 53, 6, mpf(2) ** -30), ("float", 24, 3, mpf(2) ** -11)):
            top = (pi / 4 + slack) ** 2
            derived[real] = [fit(sine_rest, count, 1, bits, top), fit(cosine_rest, count, 2, bits, top)]

`slack` is how far beyond pi/4 the rounding of x 2/pi may leave r. Errors measured, in units of the last
place of the result: double 0.834 over 16 million random angles and all multiples of pi/4 with their
neighbours, 0.784 where the compiler fuses; float 0.917 over every single number up to the bound.

`templates/trig/bundled.c.j2` is the same in single precision for targets: angles one after another, pairs of sine and cosine, cos = 3/4 -
less, and the reduction of larger angles in integers. 0.964 over every single number up to 2^20.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import factorial, ldexp
from typing import Final

from phichain.emit.expressions import double_literal, float_literal
from phichain.scene import Scene

HEADERS: Final = ("float.h", "math.h", "stdint.h", "string.h")
"""Headers a translation unit needs before it includes the rendered template."""


@dataclass(frozen=True)
class Kernel:
    """What one format needs: every number exact in it.

    Attributes:
        half_pi: P1, P2, P3 of the reduction.
        two_over_pi: 2/pi to the format.
        rounder: 1.5 2^(p-1); adding and subtracting it rounds to the nearest integer.
        sine: Coefficients of S, lowest power of r^2 first.
        cosine: Coefficients of C, lowest power of r^2 first.
        bound: Largest magnitude of an angle the kernel takes, in radians; the C library takes larger ones.
        error_ulp: Bound of the error within `bound`, in units of the last place.
    """

    half_pi: tuple[float, float, float]
    two_over_pi: float
    rounder: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]
    bound: float
    error_ulp: float


def _exact(*texts: str) -> tuple[float, ...]:
    return tuple(float.fromhex(text) for text in texts)


KERNELS: Final = {
    "double": Kernel(
        half_pi=(
            float.fromhex("0x1.921fb5444p+0"),
            float.fromhex("0x1.68c234c4cp-39"),
            float.fromhex("0x1.98a2e03707345p-77"),
        ),
        two_over_pi=float.fromhex("0x1.45f306dc9c883p-1"),
        rounder=float.fromhex("0x1.8p+52"),
        sine=_exact(
            "0x1.5555555555549p-3",
            "-0x1.111111110f89fp-7",
            "0x1.a01a019c14f6ep-13",
            "-0x1.71de357a10113p-19",
            "0x1.ae5e67cd64926p-26",
            "-0x1.5d93691e8362dp-33",
        ),
        cosine=_exact(
            "0x1.5555555555548p-5",
            "-0x1.6c16c16c14aeep-10",
            "0x1.a01a019c245c1p-16",
            "-0x1.27e4f7af8f851p-22",
            "0x1.1ee9b48775c89p-29",
            "-0x1.8f94661c27c04p-37",
        ),
        bound=400000.0,
        error_ulp=0.9,
    ),
    "float": Kernel(
        half_pi=(
            float.fromhex("0x1.922p+0"),
            float.fromhex("-0x1.2afp-18"),
            float.fromhex("0x1.0b4612p-34"),
        ),
        two_over_pi=float.fromhex("0x1.45f306p-1"),
        rounder=float.fromhex("0x1.8p+23"),
        sine=_exact(
            "0x1.555546p-3",
            "-0x1.110778p-7",
            "0x1.9953e4p-13",
        ),
        cosine=_exact(
            "0x1.555548p-5",
            "-0x1.6c0b3p-10",
            "0x1.99ad38p-16",
        ),
        bound=3200.0,
        error_ulp=0.95,
    ),
}
"""The kernel's numbers for each of the two formats."""


def literal(value: float, real: str) -> str:
    """Write a number as a decimal literal that every C and C++ compiler reads as that number ("double" or "float")."""
    return (float_literal if real == "float" else double_literal)(Fraction(value)).text


def _bits(value: float, real: str) -> str:
    pattern = struct.pack(">d" if real == "double" else ">f", value).hex()
    return f"0x{pattern}u" if real == "float" else f"UINT64_C(0x{pattern})"


def _series(coefficients: Sequence[float], real: str, indent: str) -> str:
    """Write c0 + c1 r2 + c2 r2^2 + ... as pairs in r2, nested in r4: half as deep as Horner's nesting."""
    pairs = [coefficients[i : i + 2] for i in range(0, len(coefficients), 2)]
    terms = [literal(pair[0], real) + "".join(_signed_term(c, real) for c in pair[1:]) for pair in pairs]
    text = terms[-1]
    factor = text if len(pairs[-1]) == 1 and pairs[-1][0] > 0.0 else f"({text})"
    for term in reversed(terms[:-1]):
        text = f"({term})\n{indent}+ r4 * {factor}"
        factor = f"({text})"
    return text


def _signed_term(coefficient: float, real: str) -> str:
    sign = "-" if coefficient < 0 else "+"
    return f" {sign} r2 * {literal(abs(coefficient), real)}"


def _middle(kernel: Kernel, real: str) -> str:
    """Write q P2 such that it is +0 at q = 0 for either sign of P2: an angle of -0 then keeps its sign."""
    part = kernel.half_pi[1]
    factor = "quarter" if part > 0 else f"({literal(kernel.rounder, real)} - rounded)"
    return f"{factor} * {literal(abs(part), real)}"


#: Largest angle of the bundled kernel, and its error within, in units of the last place: see tests/emit/test_bundled_trig.py.
RANGE: Final = 1_000_000
BUNDLED_ERROR: Final = {"double": 0.51, "float": 0.97}
#: The first angle that single precision has no sine of: 2^20.
FLOAT_END: Final = 1_048_576
#: S and C of the bundled kernel in single precision: the derivation above with a slack of 3/32, above what x 2/pi is off by up to 2^20.
WIDE_SINE: Final = _exact("0x1.555536p-3", "-0x1.1101ccp-7", "0x1.979616p-13")
WIDE_COSINE: Final = _exact("0x1.55553cp-5", "-0x1.6c04f4p-10", "0x1.98202p-16")
#: pi/2 in units of 2^-24, of 2^-56, and what is left in units of 2^-56.
HALF_PI_WORDS: Final = (26353589, 1145229700)
HALF_PI_REST: Final = float.fromhex("0x1.a62634p-2")
#: Bits of the number whose units count quarter turns, less those of the least that the near reduction takes, which one instruction
#: of Cortex-M compares with (four times the same byte); no quarter turn is `COUNTER_ZERO` above, a multiple of four from zero.
COUNTER_START: Final = 0x4B4B4B4B
COUNTER_ZERO, COUNTER_SPAN = 2049, 4096
#: 2/pi in units of 2^-128 by halves, pi/4 in units of 2^-64, and how many terms of sine and cosine leave 2^-64 up to pi/4.
_TWO_OVER_PI: Final = 0xA2F9836E4E441529FC2757D1F534DDC0
_QUARTER_PI: Final = 0xC90FDAA22168C235
_TERMS: Final = (8, 9)


def _nested(coefficients: Sequence[float], real: str) -> str:
    """Write c0 + r2 (c1 + r2 (...)), which takes the fewest registers."""
    text = literal(coefficients[-1], real)
    for coefficient in reversed(coefficients[:-1]):
        sign = "-" if text.startswith("-") else "+"
        factor = text.removeprefix("-")
        text = f"{literal(coefficient, real)} {sign} r2 * {f'({factor})' if ' ' in factor else factor}"
        if coefficient < 0 and " " in text:
            text = _opposite(text)
    return text


def _opposite(text: str) -> str:
    """-a + r2 * b as -(a - r2 * b), so that each level of nesting starts with a plain number."""
    head, tail = text.removeprefix("-").split(" ", 1)
    return f"-{head} {'-' if tail[0] == '+' else '+'}{tail[1:]}"


def _word(value: int) -> str:
    return f"UINT64_C(0x{value:016X})"


def _inverse_factorials(first: int, count: int) -> tuple[str, ...]:
    """1/first!, 1/(first + 2)!, ... to the nearest 2^-64."""
    return tuple(_word(round(Fraction(2**64, factorial(first + 2 * k)))) for k in range(count))


def sets_pairs(scene: Scene) -> bool:
    """Whether a scene's kernel sets sines and cosines side by side: the bundled one of single precision."""
    return scene.trig == "bundled" and scene.real == "float"


def bundled(real: str) -> dict[str, object]:
    """Return what `templates/trig/bundled.c.j2` asks for beside `coefficients`."""
    counter = struct.unpack(">f", (COUNTER_START + COUNTER_ZERO).to_bytes(4, "big"))[0]
    return {
        "range": RANGE, "error": f"{BUNDLED_ERROR[real]:g}",
        "two_over_pi_halves": (_word(_TWO_OVER_PI >> 64), _word(_TWO_OVER_PI % 2**64)), "quarter_pi": _word(_QUARTER_PI),
        "end": FLOAT_END, "counter": literal(counter, real), "counter_start": f"0x{COUNTER_START:X}u",
        "counter_zero": COUNTER_ZERO, "counter_span": COUNTER_SPAN, "half_pi_words": HALF_PI_WORDS, "half_pi_rest": literal(HALF_PI_REST, real),
        "range_bits": _bits(float(RANGE), real), "last_exponent": FLOAT_END.bit_length() + 125, "high_unit": literal(ldexp(1.0, -24), real), "low_unit_bits": _bits(ldexp(1.0, -56), "float"),
        "quarter": literal(0.25, real), "three_quarters": literal(0.75, real), "of_sine": _inverse_factorials(3, _TERMS[0]), "of_cosine": _inverse_factorials(2, _TERMS[1]),
        "sine_nested": _nested(WIDE_SINE, real), "cosine_nested": _nested(WIDE_COSINE, real),
    }  # fmt: skip


def coefficients(real: str) -> dict[str, object]:
    """Return the finished literals and names that `templates/trig/sincos.c.j2` asks for, beside `name` and `real`.

    Args:
        real: "double" or "float".

    Returns:
        The template's variables; every number is text, exact in the format.
    """
    kernel = KERNELS[real]
    width = 64 if real == "double" else 32
    letter, suffix = ("", "") if real == "double" else ("F", "f")
    indent = " " * 12
    return {
        "word": f"uint{width}_t",
        "sign_bit": _bits(-0.0, real),
        "sign_shift": width - 1,
        "half_turn_shift": width - 2,
        "bound": f"{kernel.bound:.0f}",
        "bound_bits": _bits(kernel.bound, real),
        "error_ulp": f"{kernel.error_ulp:g}",
        "half_pi": tuple(literal(part, real) for part in kernel.half_pi),
        "middle": _middle(kernel, real),
        "two_over_pi": literal(kernel.two_over_pi, real),
        "rounder": literal(kernel.rounder, real),
        "half": f"0.5{letter}",
        "one": f"1.0{letter}",
        "sine_series": _series(kernel.sine, real, indent),
        "cosine_series": _series(kernel.cosine, real, indent),
        "libm_sin": f"sin{suffix}",
        "libm_cos": f"cos{suffix}",
    }
