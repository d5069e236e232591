"""The one algebra of vectors and matrices of Program scalars: against NumPy in both dimensions, and nowhere said twice."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import phichain
from phichain.ir import evaluate
from phichain.ir.builder import Builder, Expr
from phichain.lowering.algebra import matrix as m
from phichain.lowering.algebra import vector as v
from phichain.lowering.algebra.compound import Compound

LOWERING = Path(phichain.__file__).parent / "lowering"


def computed(size: int, write: Callable[..., Sequence[Expr]], **given: np.ndarray) -> np.ndarray:
    """What a function of vectors and matrices computes: arrays of shape (size,), (size, size) or () in, entries out."""
    b = Builder("f", "")
    arguments: list[Any] = []
    for name, value in given.items():
        array = b.input(name, value.shape)
        if value.ndim == 2:
            arguments.append(m.load_matrix(array, 0, size))
        else:
            arguments.append(v.load(array, 0, size) if value.ndim else array[0])
    entries = write(*arguments)
    out = b.output("out", (len(entries),))
    v.store(out, 0, tuple(entries))
    return evaluate(b.finish(), given)["out"]


@pytest.fixture(params=[2, 3])
def size(request: pytest.FixtureRequest) -> int:
    return request.param


def drawn(*shape: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape)


def close(found: np.ndarray, expected: Any) -> None:
    assert np.allclose(found, np.ravel(expected), rtol=1e-14, atol=1e-14)


def test_vectors(size: int) -> None:
    a, b, s = drawn(size, seed=1), drawn(size, seed=2), np.array(0.7)
    close(computed(size, lambda a, b: [v.dot(a, b)], a=a, b=b), a @ b)
    crossed = np.cross(np.pad(a, (0, 3 - size)), np.pad(b, (0, 3 - size)))
    close(computed(size, v.cross, a=a, b=b), crossed if size == 3 else crossed[2])
    close(computed(size, v.add, a=a, b=b), a + b)
    close(computed(size, v.sub, a=a, b=b), a - b)
    for scaled in (v.scale, v.multiple):
        close(computed(size, scaled, s=s, a=a), 0.7 * a)
    builder = Builder("f", "")
    assert [x.constant for x in v.down(builder, size, 2)] == [0] * (size - 1) + [2]


def test_matrices(size: int) -> None:
    A, B, a, b, s = drawn(size, size, seed=3), drawn(size, size, seed=4), drawn(size), drawn(size, seed=2), np.array(-0.3)
    one = np.eye(size)
    for write, expected in (
        (lambda A, B: m.product(A, B), A @ B),
        (lambda A, B: m.plus(A, B, A), 2 * A + B),
        (lambda A, B: m.minus(A, B), A - B),
        (lambda A, B: m.transposed(A), A.T),
        (lambda A, B: m.complement(A), np.trace(A) * one - A),
    ):
        close(computed(size, lambda A, B, write=write: m.flat(write(A, B)), A=A, B=B), expected)
    close(computed(size, m.applied, A=A, a=a), A @ a)
    close(computed(size, lambda A: [m.trace(A)], A=A), np.trace(A))
    close(computed(size, lambda a, b: m.flat(m.outer(a, b)), a=a, b=b), np.outer(a, b))
    close(computed(size, lambda s, A: m.flat(m.scaled(s, A)), s=s, A=A), -0.3 * A)
    close(computed(size, lambda s, A: m.flat(m.combined(s, A, 2)), s=s, A=A), -0.3 * A + 2 * one)
    close(computed(size, lambda s: m.flat(m.scalar(s, size)), s=s), -0.3 * one)
    q = a / np.linalg.norm(a)
    P = one - np.outer(q, q)
    close(computed(size, lambda A, q: m.flat(m.across_rows(A, q)), A=A, q=q), P @ A)
    close(computed(size, lambda A, q: m.flat(m.across_columns(A, q)), A=A, q=q), A @ P)


def test_in_space_alone() -> None:
    a, b, q, A = drawn(3), drawn(3, seed=2), drawn(3, seed=5), drawn(3, 3, seed=3)
    hat = computed(3, lambda a: m.flat(m.hat(a[0].builder, a)), a=a).reshape(3, 3)
    close(hat @ b, np.cross(a, b))
    q /= np.linalg.norm(q)
    P = np.eye(3) - np.outer(q, q)
    flat = P @ A @ P
    found = computed(3, lambda M, q: m.flat(m.tangent_inverse(M, q)), M=flat, q=q).reshape(3, 3)
    assert np.allclose(found @ flat, P, atol=1e-13) and np.allclose(found @ q, 0, atol=1e-13)


def test_symmetric_ones() -> None:
    a, b, s = drawn(3), drawn(3, seed=2), np.array(0.4)
    dyads = computed(3, lambda a, b: m.flat(m.dyads(a, a, b, b)), a=a, b=b)
    close(dyads, np.outer(a, a) + np.outer(b, b))
    both = computed(3, lambda a, b, s: m.flat(m.combine((s, m.dyads(a, a)), (-1, m.dyads(b, b)))), a=a, b=b, s=s)
    close(both, 0.4 * np.outer(a, a) - np.outer(b, b))
    close(computed(3, lambda a, b: m.triangle(m.symmetric((*a, *b))), a=a, b=b), np.concatenate([a, b]))


def test_the_adjugate_of_small_ones() -> None:
    A = drawn(2, 2)
    close(computed(2, lambda A: m.flat(m.adjugate(A)), A=A), np.linalg.inv(A) * np.linalg.det(A))


def test_a_compound_is_a_record_of_tuples_whose_adjugate_goes_with_it() -> None:
    """Lambda adj(Lambda) = det I through every step of a sweep."""

    def swept(s: Expr) -> list[Expr]:
        body = Compound.zero(s.builder).with_mass(s + 2).stiffened(s + 3)  # type: ignore[arg-type]
        body = body.shifted(s + 1, (s, 2 * s)).with_mass(s).stiffened(s)
        assert isinstance(hash(body.matrix), int) and isinstance(hash(body.adjugate), int)
        turned = Compound.from_flat(body.flat()).turned(s.builder.sin(s), s.builder.cos(s))  # type: ignore[attr-defined]
        return turned.flat()

    found = computed(3, swept, s=np.array(0.3))
    matrix, adjugate, determinant = found[:9].reshape(3, 3), found[9:18].reshape(3, 3), found[18]
    assert np.allclose(matrix @ adjugate, determinant * np.eye(3), rtol=1e-13, atol=1e-12)
    assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-12)


def test_vectors_and_matrices_are_written_in_one_place() -> None:
    ours = {name for module in (v, m) for name in vars(module) if callable(getattr(module, name)) and name.islower()}
    assert {"dot", "cross", "product", "applied"} <= ours
    again = [
        f"{path.relative_to(LOWERING)}: {node.name}"
        for path in sorted(LOWERING.rglob("*.py"))
        if path.parent.name != "algebra"
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.FunctionDef) and node.name.strip("_") in ours | {"wedge", "times"}
        and any(word in ast.unparse(node.args) for word in ("Vector", "Matrix"))
    ]
    assert again == []
