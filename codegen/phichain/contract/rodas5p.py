"""Rodas5P (Steinebach 2023): a Rosenbrock method of order 5 with 8 stages, stiffly accurate and L-stable.

For an autonomous y' = f(y) with J = f'(y_0), in the form that needs no product with J (Hairer & Wanner, Solving ODEs II, IV.7):

    (I - gamma h J) U_i = gamma (h f(y_0 + sum_j a_ij U_j) + sum_j c_ij U_j),    y_1 = y_0 + sum_i m_i U_i

The last stages are a_7j = a_6j, a_76 = 1, a_8j = a_7j, a_87 = 1 and m_j = a_8j, m_8 = 1, so that U_8 is the difference to the
embedded method of order 4. Being stiffly accurate, the method has R(infinity) = 0.

Reference: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
Differential Equations package, BIT Numerical Mathematics 63 (2023). The coefficients are the published decimals.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Final

ORDER: Final = 5
"""Order of y_1."""
EMBEDDED_ORDER: Final = 4
"""Order of y_1 - U_8."""
STAGES: Final = 8

GAMMA: Final = Fraction("0.21193756319429014")

_SIXTH: Final = (
    "-7.502846399306121", "2.561846144803919", "-11.627539656261098", "-0.18268767659942256", "0.030198172008377946",
)  # fmt: skip
_A: Final = (
    (),
    ("3.0",),
    ("2.849394379747939", "0.45842242204463923"),
    ("-6.954028509809101", "2.489845061869568", "-10.358996098473584"),
    ("2.8029986275628964", "0.5072464736228206", "-0.3988312541770524", "-0.04721187230404641"),
    _SIXTH,
    (*_SIXTH, "1"),
    (*_SIXTH, "1", "1"),
)
_C: Final = (
    (),
    ("-14.155112264123755",),
    ("-17.97296035885952", "-2.859693295451294"),
    ("147.12150275711716", "-1.41221402718213", "71.68940251302358"),
    ("165.43517024871676", "-0.4592823456491126", "42.90938336958603", "-5.961986721573306"),
    ("24.854864614690072", "-3.0009227002832186", "47.4931110020768", "5.5814197821558125", "-0.6610691825249471"),
    (
        "30.91273214028599", "-3.1208243349937974", "77.79954646070892", "34.28646028294783", "-19.097331116725623",
        "-28.087943162872662",
    ),
    (
        "37.80277123390563", "-3.2571969029072276", "112.26918849496327", "66.9347231244047", "-40.06618937091002",
        "-54.66780262877968", "-9.48861652309627",
    ),
)  # fmt: skip


def _exact(rows: tuple[tuple[str, ...], ...]) -> tuple[tuple[Fraction, ...], ...]:
    return tuple(tuple(map(Fraction, row)) for row in rows)


A: Final = _exact(_A)
"""a_ij, j < i: where stage i evaluates f."""
C: Final = _exact(_C)
"""c_ij, j < i: what earlier stages add to the right side of stage i."""
M: Final = (*A[-1], Fraction(1))
"""m_i: the weights of the step."""
