"""Parts of a linear system that do not mix: the two vertical planes of a chain in space, above all.

The states and inputs of z' = A z + B u, weighed by Q and R, are the nodes of a graph whose edges are the entries that are
not zero. Its components are problems of their own. Components that differ by the signs of their coordinates alone, as the
two planes do (a rotation about e_1 swings towards -e_2), are one problem: each is brought to a canonical choice of signs.

Matrices come in stacks (count, n, n), one for each equilibrium of a chain: those whose graphs are the same go together.
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


@dataclass(frozen=True, eq=False)
class Block(Held):
    """One component, the same of every system of a stack.

    Attributes:
        states: Its states (n,), rising.
        inputs: Its inputs (nu,), rising.
        state_signs: +-1 for each state (count, n): canonical coordinates are z times them.
        input_signs: +-1 for each input (count, nu).
    """

    states: Indices
    inputs: Indices
    state_signs: Vector
    input_signs: Vector

    def only(self, items: list[int]) -> Block:
        """The same of some of the stack."""
        return Block(self.states, self.inputs, self.state_signs[items], self.input_signs[items])

    def square(self, matrix: Vector) -> Vector:
        """Its part of matrices over the states, in canonical signs."""
        return part(matrix, self.states, self.states) * _outer(self.state_signs, self.state_signs) + 0.0

    def across(self, matrix: Vector) -> Vector:
        """Its part of matrices from the inputs to the states, in canonical signs."""
        return part(matrix, self.states, self.inputs) * _outer(self.state_signs, self.input_signs) + 0.0

    def over_inputs(self, matrix: Vector) -> Vector:
        """Its part of matrices over the inputs, in canonical signs."""
        return part(matrix, self.inputs, self.inputs) * _outer(self.input_signs, self.input_signs) + 0.0


@dataclass(frozen=True, eq=False)
class Alike(Held):
    """Systems of a stack whose parts correspond.

    Attributes:
        items: Which of the stack they are.
        blocks: Their components.
        problems: The matrices of every distinct component, stacks in canonical signs: those over the states, the one from
            the inputs to the states, and the one over the inputs where there is one.
        members: Which of the problems each component is.
    """

    items: Indices
    blocks: tuple[Block, ...]
    problems: tuple[tuple[Vector, ...], ...]
    members: tuple[int, ...]


def part(matrix: Vector, rows: Indices, columns: Indices) -> Vector:
    """Those rows and columns of matrices, contiguous."""
    result: Vector = matrix.take(rows, axis=-2).take(columns, axis=-1)
    return result


def turned(matrix: NDArray[np.floating]) -> NDArray[np.floating]:
    """The transposes of a stack of matrices."""
    return matrix.swapaxes(-1, -2)


def _outer(left: Vector, right: Vector) -> Vector:
    return left[..., :, None] * right[..., None, :]


def blocks(states: Sequence[Vector], across: Vector, inputs: Vector | None = None) -> list[tuple[Indices, tuple[Block, ...]]]:
    """The components of a stack of systems: which of the stack have the same ones, and these, by their first state.

    The whole system is one block where a component has no state or no input.

    Args:
        states: Matrices over the states, (count, n, n) or one for all (n, n).
        across: The matrices from the inputs to the states (count, n, nu).
        inputs: The matrix over the inputs (nu, nu); the identity unless given.
    """
    count, n, nu = across.shape
    edges = np.zeros((count, n + nu, n + nu))
    inner = edges[:, :n, :n]
    for matrix in reversed(states):
        for given in (turned(matrix), matrix):
            np.copyto(inner, given, where=given != 0)
    edges[:, :n, n:], edges[:, n:, :n] = across, turned(across)
    if inputs is not None:
        edges[:, n:, n:] = inputs
    patterns: dict[bytes, list[int]] = {}
    for k, pattern in enumerate(edges != 0):
        patterns.setdefault(pattern.tobytes(), []).append(k)
    return [(np.array(items), _components(key, edges[items], n)) for key, items in patterns.items()]


def alike(states: Sequence[Vector], across: Vector, inputs: Vector | None = None) -> list[Alike]:
    """The systems of a stack by what they are made of; arguments as in `blocks`."""
    groups = []
    for items, found in blocks(states, across, inputs):
        parts = []
        for block in found:
            matrices = [block.square(matrix[items] if matrix.ndim > 2 else matrix) for matrix in states]
            over = () if inputs is None else (block.over_inputs(inputs),)
            parts.append((*matrices, block.across(across[items]), *over))
        rows: dict[tuple[int, ...], list[int]] = {}
        for k, row in enumerate(_firsts(parts).tolist()):
            rows.setdefault(tuple(row), []).append(k)
        for members, these in rows.items():
            distinct = sorted(set(members))
            groups.append(
                Alike(
                    items[these],
                    tuple(block.only(these) for block in found),
                    tuple(tuple(matrix[these] for matrix in parts[k]) for k in distinct),
                    tuple(distinct.index(k) for k in members),
                )
            )
    return groups


def _firsts(parts: Sequence[tuple[Vector, ...]]) -> Indices:
    """For every system of a stack the first component that is the same as each (count, components)."""
    firsts = np.tile(np.arange(len(parts)), (len(parts[0][0]), 1))
    for k, own in enumerate(parts):
        for earlier in reversed(range(k)):
            if all(mine.shape == theirs.shape for mine, theirs in zip(own, parts[earlier], strict=True)):
                pairs = zip(own, parts[earlier], strict=True)
                same = np.logical_and.reduce([np.all(mine == theirs, axis=(1, 2)) for mine, theirs in pairs])
                firsts[same, k] = earlier
    return firsts


def _components(pattern: bytes, edges: Vector, n: int) -> tuple[Block, ...]:
    """The components of graphs of one pattern, with the signs that make the edges of their trees positive."""
    found = []
    for tree in _trees(pattern, edges.shape[1], n):
        # A node's sign changes with every edge below zero on its way from the root.
        turns = (edges[:, tree.parents, tree.children] < 0) @ tree.ways % 2
        signs = 1.0 - 2.0 * turns
        found.append(Block(tree.states, tree.inputs, signs[:, : len(tree.states)], signs[:, len(tree.states) :]))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class _Tree(Held):
    """A spanning tree of one component: its states and inputs, its edges, and which of these lead to each of its nodes."""

    states: Indices
    inputs: Indices
    parents: Indices
    children: Indices
    ways: NDArray[np.float64]


@lru_cache(maxsize=64)
def _trees(pattern: bytes, size: int, n: int) -> tuple[_Tree, ...]:
    """The components of a symmetric pattern, the first n nodes of which are states."""
    joined = np.frombuffer(pattern, dtype=bool).reshape(size, size)
    seen: set[int] = set()
    found = []
    for start in range(size):
        if start in seen:
            continue
        seen.add(start)
        ways: dict[int, tuple[int, ...]] = {start: ()}
        edges: list[tuple[int, int]] = []
        for node in (order := [start]):
            for child in np.flatnonzero(joined[node]).tolist():
                if child not in seen:
                    seen.add(child)
                    order.append(child)
                    ways[child] = (*ways[node], len(edges))
                    edges.append((node, child))
        found.append(_tree(ways, edges, n))
    if any(not (len(tree.states) and len(tree.inputs)) for tree in found):
        # What has no input, or no state, stays with the whole.
        return (_tree({node: () for node in range(size)}, [], n),)
    return tuple(found)


def _tree(ways: dict[int, tuple[int, ...]], edges: list[tuple[int, int]], n: int) -> _Tree:
    nodes = sorted(ways)
    leads = np.array([[float(edge in ways[node]) for node in nodes] for edge in range(len(edges))])
    parents, children = np.array(edges, dtype=np.intp).reshape(-1, 2).T
    states, inputs = (np.array([k for k in nodes if (k < n) == inner], dtype=np.intp) for inner in (True, False))
    return _Tree(states, inputs - n, parents, children, leads.reshape(len(edges), len(nodes)))
