"""Rodas5P (Steinebach 2023): a Rosenbrock method of order 5 with 8 stages, stiffly accurate and L-stable.

For an autonomous y' = f(y) with J = f'(y_0), in the form that needs no product with J (Hairer & Wanner, Solving ODEs II, IV.7):

    (I - gamma h J) U_i = gamma (h f(y_0 + sum_j a_ij U_j) + sum_j c_ij U_j),    y_1 = y_0 + sum_i m_i U_i

The last stages are a_7j = a_6j, a_76 = 1, a_8j = a_7j, a_87 = 1 and m_j = a_8j, m_8 = 1, so that U_8 is the difference to the
embedded method of order 4. Being stiffly accurate, the method has R(infinity) = 0.

Reference: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
Differential Equations package, BIT Numerical Mathematics 63 (2023). The published decimals satisfy the conditions of their order
to 6e-15, that of order 1 among them: a motion of 5 s came out early by 3e-14 s, whatever the steps. These here are doubles that lie
within 5e-14 of them, relatively, and satisfy all conditions to 6e-16 and those of orders 1 and 2 to 4e-18; a_21 and gamma are as published.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Final

ORDER: Final = 5
"""Order of y_1."""
EMBEDDED_ORDER: Final = 4
"""Order of y_1 - U_8."""
STAGES: Final = 8

GAMMA: Final = Fraction(0.21193756319429014)

_SIXTH: Final = (
    -7.502846399306128, 2.561846144803885, -11.627539656261147, -0.1826876765994252, 0.03019817200837655,
)  # fmt: skip
_A: Final = (
    (),
    (3.0,),
    (2.849394379747933, 0.4584224220446408),
    (-6.954028509809135, 2.4898450618695414, -10.35899609847363),
    (2.80299862756279, 0.5072464736228143, -0.39883125417706305, -0.04721187230404466),
    _SIXTH,
    (*_SIXTH, 1.0),
    (*_SIXTH, 1.0, 1.0),
)
_C: Final = (
    (),
    (-14.155112264123925,),
    (-17.9729603588595, -2.859693295451233),
    (147.12150275711718, -1.4122140271821435, 71.68940251302354),
    (165.43517024871682, -0.4592823456491118, 42.90938336958603, -5.961986721573235),
    (24.854864614689905, -3.0009227002831174, 47.49311100207675, 5.5814197821558, -0.6610691825249417),
    (
        30.91273214028597, -3.120824334993772, 77.79954646070891, 34.28646028294784, -19.097331116725638,
        -28.087943162872584,
    ),
    (
        37.80277123390554, -3.257196902907237, 112.26918849496323, 66.93472312440474, -40.06618937091004,
        -54.66780262877951, -9.488616523096239,
    ),
)  # fmt: skip


def _exact(rows: tuple[tuple[float, ...], ...]) -> tuple[tuple[Fraction, ...], ...]:
    return tuple(tuple(map(Fraction, row)) for row in rows)


A: Final = _exact(_A)
"""a_ij, j < i: where stage i evaluates f."""
C: Final = _exact(_C)
"""c_ij, j < i: what earlier stages add to the right side of stage i."""
M: Final = (*A[-1], Fraction(1))
"""m_i: the weights of the step."""
