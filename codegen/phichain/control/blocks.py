"""Parts of a linear system that do not mix: the two vertical planes of a chain in space, above all.

The states and inputs of z' = A z + B u, weighed by Q and R, are the nodes of a graph whose edges are the entries that are
not zero. Its components are problems of their own. Components that differ by the signs of their coordinates alone, as the
two planes do (a rotation about e_1 swings towards -e_2), are one problem: each is brought to a canonical choice of signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phichain.records import Held
from phichain.system import Vector

Indices = NDArray[np.intp]
Tree = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Block(Held):
    """One component.

    Attributes:
        states: Its states (n,), rising.
        inputs: Its inputs (nu,), rising.
        state_signs: +-1 for each state: canonical coordinates are z times them.
        input_signs: +-1 for each input.
    """

    states: Indices
    inputs: Indices
    state_signs: Vector
    input_signs: Vector

    def square(self, matrix: Vector) -> Vector:
        """Its part of a matrix over the states, in canonical signs."""
        signs = self.state_signs
        return part(matrix, self.states, self.states) * (signs[:, None] * signs) + 0.0

    def across(self, matrix: Vector) -> Vector:
        """Its part of a matrix from the inputs to the states, in canonical signs."""
        return part(matrix, self.states, self.inputs) * (self.state_signs[:, None] * self.input_signs) + 0.0

    def over_inputs(self, matrix: Vector) -> Vector:
        """Its part of a matrix over the inputs, in canonical signs."""
        signs = self.input_signs
        return part(matrix, self.inputs, self.inputs) * (signs[:, None] * signs) + 0.0


def part(matrix: Vector, rows: Indices, columns: Indices) -> Vector:
    """Those rows and columns of a matrix."""
    result: Vector = matrix[rows][:, columns]
    return result


def blocks(states: Sequence[Vector], across: Vector, inputs: Vector | None = None) -> tuple[Block, ...]:
    """The components, by their first state; the whole system where one of them has no state or no input.

    Args:
        states: Matrices over the states (n, n).
        across: The matrix from the inputs to the states (n, nu).
        inputs: A matrix over the inputs (nu, nu); the identity unless given.
    """
    n, nu = across.shape
    edges = np.zeros((n + nu, n + nu))
    for matrix in reversed(states):
        for given in (matrix.T, matrix):
            np.copyto(edges[:n, :n], given, where=given != 0)
    edges[:n, n:], edges[n:, :n] = across, across.T
    if inputs is not None:
        edges[n:, n:] = inputs
    trees = _trees((edges != 0).tobytes(), n + nu)
    if any(tree[0][0] >= n or max(tree)[0] < n for tree in trees):
        return (Block(np.arange(n), np.arange(nu), np.ones(n), np.ones(nu)),)
    return tuple(_block(tree, edges, n) for tree in trees)


def _block(tree: Tree, edges: Vector, n: int) -> Block:
    """One component with the signs that make the edges of its tree positive."""
    signs = {tree[0][0]: 1.0}
    for node, parent in tree[1:]:
        signs[node] = signs[parent] if edges[parent, node] > 0 else -signs[parent]
    nodes = sorted(signs)
    states, inputs = [k for k in nodes if k < n], [k - n for k in nodes if k >= n]
    return Block(
        np.array(states),
        np.array(inputs),
        np.array([signs[k] for k in states]),
        np.array([signs[k + n] for k in inputs]),
    )


@lru_cache(maxsize=64)
def _trees(pattern: bytes, size: int) -> tuple[Tree, ...]:
    """A spanning tree of each component of a symmetric pattern, breadth first: (node, its parent) from the first node on."""
    joined = np.frombuffer(pattern, dtype=bool).reshape(size, size)
    seen: set[int] = set()
    trees = []
    for start in range(size):
        if start in seen:
            continue
        tree = [(start, start)]
        seen.add(start)
        for node, _ in tree:
            new = [k for k in np.flatnonzero(joined[node]).tolist() if k not in seen]
            seen.update(new)
            tree.extend((k, node) for k in new)
        trees.append(tuple(tree))
    return tuple(trees)
