"""The coefficients of Rodas5P against the theory of Rosenbrock methods: order conditions, stability function, stiff accuracy."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import combinations_with_replacement
from math import factorial, prod

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.contract.rodas5p import EMBEDDED_ORDER, GAMMA, ORDER, STAGES, A, C, M

Tree = tuple["Tree", ...]
#: Some coefficients exceed 100, and these conditions are evaluated in doubles.
ROUNDED = 2e-13


def square(rows: tuple[tuple[Fraction, ...], ...]) -> NDArray[np.float64]:
    full = np.zeros((STAGES, STAGES))
    for i, row in enumerate(rows):
        full[i, : len(row)] = [float(entry) for entry in row]
    return full


@cache
def rosenbrock_form() -> tuple[NDArray[np.float64], ...]:
    """alpha, Gamma, b and b-hat of k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j, from U = Gamma k."""
    gamma_matrix = np.linalg.inv(np.eye(STAGES) / float(GAMMA) - square(C))
    weights = np.array([float(entry) for entry in M])
    embedded = weights.copy()
    embedded[-1] = 0.0
    return square(A) @ gamma_matrix, gamma_matrix, weights @ gamma_matrix, embedded @ gamma_matrix


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """Rooted trees with so many vertices."""
    found = set()
    for parts in _partitions(order - 1):
        choices = [
            combinations_with_replacement(trees(size), parts.count(size)) for size in sorted(set(parts))
        ]
        found |= {tuple(sorted(sum(choice, ()))) for choice in _products(choices)}
    return tuple(sorted(found))


def _partitions(total: int, least: int = 1) -> list[list[int]]:
    if total == 0:
        return [[]]
    return [[part, *rest] for part in range(least, total + 1) for rest in _partitions(total - part, part)]


def _products(choices: list) -> list:
    if not choices:
        return [()]
    rest = _products([list(choice) for choice in choices[1:]])
    return [(first, *other) for first in choices[0] for other in rest]


def size(tree: Tree) -> int:
    return 1 + sum(map(size, tree))


def density(tree: Tree) -> int:
    return size(tree) * prod(map(density, tree))


def elementary_weight(tree: Tree) -> NDArray[np.float64]:
    """Phi_i: a vertex with one branch passes beta = alpha + Gamma on, one with more passes alpha (Hairer & Wanner, IV.7)."""
    alpha, gamma_matrix, _, _ = rosenbrock_form()
    passed = alpha + gamma_matrix if len(tree) == 1 else alpha
    return (
        np.prod([passed @ elementary_weight(branch) for branch in tree], axis=0) if tree else np.ones(STAGES)
    )


def residual(tree: Tree, weights: NDArray[np.float64]) -> float:
    return abs(float(weights @ elementary_weight(tree)) - 1 / density(tree))


def test_there_are_as_many_trees_as_cayley_counted() -> None:
    assert [len(trees(n)) for n in range(1, 7)] == [1, 1, 2, 4, 9, 20]


@pytest.mark.parametrize("order", range(1, ORDER + 1))
def test_order_conditions(order: int) -> None:
    _, _, weights, embedded = rosenbrock_form()
    assert max(residual(tree, weights) for tree in trees(order)) < ROUNDED
    if order <= EMBEDDED_ORDER:
        assert max(residual(tree, embedded) for tree in trees(order)) < ROUNDED


def test_neither_method_is_of_a_higher_order() -> None:
    _, _, weights, embedded = rosenbrock_form()
    assert max(residual(tree, weights) for tree in trees(ORDER + 1)) > 1e-5
    assert max(residual(tree, embedded) for tree in trees(EMBEDDED_ORDER + 1)) > 1e-4


def stability(z: complex, weights: NDArray[np.float64]) -> complex:
    """R(z) = 1 + z b^T (I - z beta)^-1 1."""
    alpha, gamma_matrix, _, _ = rosenbrock_form()
    return 1 + z * complex(
        weights @ np.linalg.solve(np.eye(STAGES) - z * (alpha + gamma_matrix), np.ones(STAGES))
    )


def test_stability_function_vanishes_at_infinity() -> None:
    """|R(inf)| = |1 - b^T beta^-1 1|, of both methods: L-stable, and the error estimate of a stiff component dies out as well."""
    alpha, gamma_matrix, weights, embedded = rosenbrock_form()
    for row in (weights, embedded):
        assert abs(1 - row @ np.linalg.solve(alpha + gamma_matrix, np.ones(STAGES))) < 1e-12
        assert abs(stability(-1e8, row)) < 1e-6


def test_the_left_half_plane_is_stable() -> None:
    """|R| <= 1 on the imaginary axis; all poles are at 1 / gamma > 0, so the maximum principle does the rest."""
    _, _, weights, _ = rosenbrock_form()
    assert max(abs(stability(1j * y, weights)) for y in np.logspace(-3, 6, 400)) < 1 + 1e-12
    assert GAMMA > 0


def test_it_is_stiffly_accurate() -> None:
    alpha, gamma_matrix, weights, _ = rosenbrock_form()
    assert np.max(np.abs((alpha + gamma_matrix)[-1] - weights)) < ROUNDED
    assert abs(alpha[-1].sum() - 1) < ROUNDED


def published() -> dict[tuple[str, int, int], float]:
    """Some of the published decimals, the largest and the smallest among them (Steinebach 2023)."""
    return {
        ("A", 2, 0): 2.849394379747939, ("A", 5, 4): 0.030198172008377946, ("C", 3, 0): 147.12150275711716,
        ("C", 4, 0): 165.43517024871676, ("C", 5, 4): -0.6610691825249471, ("C", 7, 2): 112.26918849496327, ("C", 7, 6): -9.48861652309627,
    }  # fmt: skip


def test_coefficients_are_doubles_next_to_the_published_decimals() -> None:
    entries = [GAMMA, *(entry for row in (*A, *C) for entry in row)]
    assert all(Fraction(float(entry)) == entry for entry in entries)
    for (name, i, j), value in published().items():
        assert abs(float({"A": A, "C": C}[name][i][j]) / value - 1) < 1e-13


def exponential(terms: int) -> list[Fraction]:
    """k! times the coefficient k of R(z), exactly, of the doubles that the C has: 1 up to the order."""
    stages: list[list[Fraction]] = []
    for row, column in zip(A, C, strict=True):
        at = [sum((a * u[k] for a, u in zip(row, stages, strict=False)), Fraction(k == 0)) for k in range(terms)]
        right = [GAMMA * ((at[k - 1] if k else 0) + sum(c * u[k] for c, u in zip(column, stages, strict=False))) for k in range(terms)]
        found: list[Fraction] = []
        for k in range(terms):
            found.append(right[k] + (GAMMA * found[k - 1] if k else 0))
        stages.append(found)
    ends = [sum((m * u[k] for m, u in zip(M, stages, strict=True)), Fraction(k == 0)) for k in range(terms)]
    return [end * factorial(k) for k, end in enumerate(ends)]


def test_time_runs_as_it_should() -> None:
    """The decimals themselves leave 5.5e-15 and 3.2e-15 in orders 1 and 2, whatever the step."""
    off = [abs(float(entry - 1)) for entry in exponential(ORDER + 1)]
    assert max(off[1:3]) < 1e-17 and max(off) < 3e-14
