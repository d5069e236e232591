"""Powers of square matrices with real or complex exponents: equations (6)-(11) of paper A.

With A = V diag(lambda) V^-1 the power is

    A^p = V diag(lambda^p) V^-1,   lambda^p = exp(p Log lambda),  -pi < Im Log lambda <= pi.

The paper writes (8)-(11) for A^(1/p); its section 4 uses A^p, as here. The method is as good as V is conditioned: near
a defective matrix it loses log10(cond V) digits, a warning says so and the Schur-Pade algorithm takes over. For the
powers of a chain's inertia matrix use `inertia_powers`, which keeps small eigenvalues that this one cannot see.

A singular matrix has powers of exponents with Re p > 0 where its eigenvalue 0 is semisimple, that is, has as many
eigenvectors as its multiplicity: then 0^p = 0. With U an orthonormal basis of its range A = U (U^H A), and

    A^p = U C^(p-1) U^H A,   C = U^H A U,

where C is nonsingular exactly when 0 is semisimple (Higham 2008, theorem 1.35 with f(z) = z^p).

Sources: N. J. Higham, Functions of Matrices (2008); N. J. Higham and L. Lin, SIAM J. Matrix Anal. Appl. 34 (2013)
1341-1360, for the fallback in SciPy.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from phichain.errors import ArrayError, PhichainError
from phichain.records import Held

Matrix = NDArray[Any]

_EPS = float(np.finfo(float).eps)
_TINY = float(np.finfo(float).tiny)
# Above the first condition number of V the Schur-Pade result is taken; above the second no eigenvectors span the space.
CONDITION_LIMIT = 1e6
DEFECTIVE_LIMIT = 0.1 / _EPS


class NearDefectiveWarning(UserWarning):
    """The eigenvectors of a matrix are nearly dependent, so that equations (6)-(11) lose digits."""


class MatrixPowerError(PhichainError):
    """A matrix has no such power: it is singular, or has too few eigenvectors for the method asked for."""


@dataclass(frozen=True)
class Spectrum(Held):
    """A = V diag(values) V^-1.

    Attributes:
        values: Eigenvalues, shape (n,).
        vectors: V, shape (n, n).
        inverse: V^-1, shape (n, n).
        condition: Condition number of V, 1 for a normal matrix.
    """

    values: Matrix
    vectors: Matrix
    inverse: Matrix
    condition: float


def matrix_power(matrix: ArrayLike, p: ArrayLike, *, method: str = "auto") -> Matrix:
    """A^p for a real or complex p, or for many.

    Args:
        matrix: A, real or complex, shape (n, n).
        p: One exponent or an array of them.
        method: ``"auto"``: eigenvectors, and Schur-Pade with a warning where cond V > 1e6. ``"eigenvectors"``:
            equations (6)-(11) even there. ``"schur"``: Schur-Pade, also for defective matrices.

    Returns:
        The principal power, shape p.shape + (n, n). Real when A and p are and no eigenvalue is negative (or every p
        is an integer), else complex.

    Raises:
        ArrayError: A is not square, not finite or empty.
        MatrixPowerError: A is singular and a p, no natural number, has Re p <= 0 or 0 is not semisimple; A is
            defective elsewhere and the method is not "schur".

    Warns:
        NearDefectiveWarning: cond V > 1e6; says by how much the two methods differ.
    """
    a = _square(matrix)
    exponents = _exponents(p)
    if method not in ("auto", "eigenvectors", "schur"):
        raise ArrayError(
            "method", method, "there is no such method", 'choose "auto", "eigenvectors" or "schur"'
        )
    whole = (exponents.imag == 0) & (exponents.real == np.round(exponents.real))
    spectrum = eigenvectors(a)
    zero = np.zeros(len(a), dtype=bool)
    if not np.all(whole & (exponents.real >= 0)):
        zero = _zeros(a, spectrum)
        if np.any(zero) and np.any((exponents.real <= 0) & (exponents != 0)):
            raise _singular(a, "and 0^p has no meaning where Re p <= 0")
    results = np.empty((*exponents.shape, *a.shape), dtype=complex)
    for at in np.argwhere(whole):
        results[tuple(at)] = np.linalg.matrix_power(a, int(exponents[tuple(at)].real))
    if not np.all(whole):
        powers = _singular_powers if np.any(zero) else _powers
        results[~whole] = powers(a, spectrum, exponents[~whole], method)
    if not np.all(np.isfinite(results)):
        raise MatrixPowerError(
            "matrix", a, "its power overflows or does not exist", "scale it, or pass a smaller p"
        )
    if _is_real(a, spectrum.values[~zero], exponents):
        results = np.ascontiguousarray(results.real)
    return results


def eigenvectors(matrix: ArrayLike) -> Spectrum:
    """The decomposition A = V diag(lambda) V^-1 of (6)-(7); V is unitary for a Hermitian A.

    Raises:
        ArrayError: A is not square, not finite or empty.
    """
    a = _square(matrix)
    if np.array_equal(a, a.conj().T):
        values, vectors = linalg.eigh(a)
        return Spectrum(values, vectors, vectors.conj().T, 1.0)
    values, vectors = linalg.eig(a)
    condition = float(np.linalg.cond(vectors))
    inverse = linalg.inv(vectors) if condition < DEFECTIVE_LIMIT else np.full_like(vectors, np.nan)
    return Spectrum(values, vectors, inverse, condition)


def _powers(a: Matrix, spectrum: Spectrum, exponents: Matrix, method: str) -> Matrix:
    if method == "schur":
        return _schur_powers(a, exponents)
    if spectrum.condition >= DEFECTIVE_LIMIT:
        raise MatrixPowerError(
            "matrix",
            a,
            f"is defective: its eigenvectors do not span the space, cond V = {spectrum.condition:.2g}",
            'pass method="schur", which needs none',
            condition=spectrum.condition,
        )
    powers = _eigenvector_powers(spectrum, exponents)
    if spectrum.condition <= CONDITION_LIMIT:
        return powers
    check = _schur_powers(a, exponents)
    scale = np.max(np.abs(check), initial=_TINY)
    warnings.warn(
        f"the eigenvectors are nearly dependent, cond V = {spectrum.condition:.2g}: equations (6)-(11) and the "
        f"Schur-Pade algorithm differ by {np.max(np.abs(powers - check), initial=0.0) / scale:.2g}, relative; "
        + ("the latter is returned" if method == "auto" else "the former is returned, as asked"),
        NearDefectiveWarning,
        stacklevel=3,
    )
    return check if method == "auto" else powers


def _eigenvector_powers(spectrum: Spectrum, exponents: Matrix, zero: NDArray[np.bool_] | None = None) -> Matrix:
    values = spectrum.values.astype(complex)
    diagonals = np.zeros((exponents.size, values.size), dtype=complex)
    kept = np.full(values.size, True) if zero is None else ~zero
    diagonals[:, kept] = np.exp(np.multiply.outer(exponents, np.log(values[kept])))
    return (spectrum.vectors * diagonals[:, None, :]) @ spectrum.inverse


def _schur_powers(a: Matrix, exponents: Matrix) -> Matrix:
    powers = np.empty((exponents.size, *a.shape), dtype=complex)
    for k, p in enumerate(exponents):
        # SciPy's fractional_matrix_power takes real p only.
        powers[k] = (
            linalg.fractional_matrix_power(a, p.real) if p.imag == 0 else linalg.expm(p * linalg.logm(a))
        )
    return powers


def _singular_powers(a: Matrix, spectrum: Spectrum, exponents: Matrix, method: str) -> Matrix:
    """A^p of a singular A, Re p > 0: by eigenvectors where they are well conditioned, else on the range of A."""
    zero = _zeros(a, spectrum)
    if method != "schur" and spectrum.condition <= CONDITION_LIMIT:
        return _eigenvector_powers(spectrum, exponents, zero)
    rank = int(np.sum(~zero))
    directions, sizes, _ = linalg.svd(a)
    basis = directions[:, :rank]
    across = basis.conj().T @ a
    core = across @ basis
    if np.any(sizes[rank:] > len(a) * _EPS * sizes[0]):
        raise _singular(a, "and has too few eigenvectors there: a nilpotent part has no such power")
    if not rank:
        return np.zeros((exponents.size, *a.shape), dtype=complex)
    inner = eigenvectors(core)
    if np.any(_zeros(core, inner)):
        raise _singular(a, "and has too few eigenvectors there: a nilpotent part has no such power")
    result: Matrix = basis @ _powers(core, inner, exponents - 1, method) @ across
    return result


def _zeros(a: Matrix, spectrum: Spectrum) -> NDArray[np.bool_]:
    """Which eigenvalues cannot be told from zero: they lie within eps |w_i| |A| |v_i| / |w_i v_i|."""
    size = a.shape[0]
    if np.all(np.isfinite(spectrum.inverse)):
        uncertainty = np.sum((np.abs(spectrum.inverse) @ np.abs(a)) * np.abs(spectrum.vectors).T, axis=1)
    else:
        uncertainty = np.full(size, np.linalg.norm(a))
    doubtful: NDArray[np.bool_] = np.abs(spectrum.values) <= size * _EPS * uncertainty
    return doubtful


def _singular(a: Matrix, why: str) -> MatrixPowerError:
    return MatrixPowerError(
        "matrix",
        a,
        f"is singular to working precision: an eigenvalue cannot be told from 0, {why}",
        "use `inertia_powers` for an inertia matrix, or remove its null space",
    )


def _is_real(a: Matrix, values: Matrix, exponents: Matrix) -> bool:
    if np.iscomplexobj(a) or np.any(exponents.imag != 0):
        return False
    on_branch_cut = np.any((values.imag == 0) & (values.real < 0))
    return not on_branch_cut or bool(np.all(exponents.real == np.round(exponents.real)))


def _square(matrix: ArrayLike) -> Matrix:
    a = _numbers(matrix)
    if a.dtype.kind not in "biufc" or a.ndim != 2 or a.shape[0] != a.shape[1] or a.size == 0:
        raise ArrayError(
            "matrix", matrix, "must be a square matrix of numbers", "pass an array of shape (n, n)"
        )
    if not np.all(np.isfinite(a)):
        raise ArrayError("matrix", a, "holds entries that are not finite", "repair them first")
    return a.astype(complex if np.iscomplexobj(a) else float)


def _numbers(values: ArrayLike) -> Matrix:
    """The values as an array; ragged ones become an array of objects, which nobody takes."""
    try:
        return np.asarray(values)
    except Exception:  # noqa: BLE001  (a caller's object may fail in its own way)
        return np.empty(0, dtype=object)


def _exponents(p: ArrayLike) -> Matrix:
    exponents = _numbers(p)
    if exponents.dtype.kind not in "biufc" or not np.all(np.isfinite(exponents)):
        raise ArrayError(
            "p", p, "must be finite real or complex numbers", "pass one exponent or an array of them"
        )
    return exponents.astype(complex)
