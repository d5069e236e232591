"""One function under proof at one random point, and which plain function proves which function of the contract."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, TypeVar

from phichain.contract.registry import ANY, Registry
from phichain.ir.nodes import Program
from phichain.proof.lagrange import Judge
from phichain.proof.modular.compiled import FAULTS, Compiled, Given, compiled
from phichain.proof.modular.contracted import Contracted, contracted
from phichain.proof.modular.field import PRIME, Vector, dot, plus
from phichain.proof.modular.points import Point
from phichain.proof.positions import Chain
from phichain.scene import Scene


class Wrong(Exception):
    """An identity does not hold; says of which output, at which index."""


@dataclass(frozen=True)
class Subject:
    """A Program, compiled when it is first run."""

    program: Program

    @cached_property
    def values(self) -> Compiled:
        """It without derivatives."""
        return compiled(self.program)

    @cached_property
    def slopes(self) -> Compiled:
        """It with the derivative along one direction."""
        return compiled(self.program, level=1)

    @cached_property
    def columns(self) -> tuple[Compiled, Contracted] | None:
        """A Jacobian times vectors, where it is made of loops over seeds."""
        found = contracted(self.program)
        return None if found is None else (compiled(found.program), found)


@dataclass(frozen=True)
class Case:
    """What a proof sees: the Program under proof, the judge, a point.

    Attributes:
        subject: the function under proof.
        other: the other Programs of the same scene by name; the forward dynamics is proven before what leans on it.
        judge: the Model's Lagrangian.
        chain: the scene's numbers at the point.
    """

    subject: Subject
    other: Callable[[str], Subject]
    judge: Judge
    chain: Chain

    @property
    def scene(self) -> Scene:
        """The chain."""
        return self.point.scene

    @property
    def forward(self) -> Subject:
        """The forward dynamics."""
        return self.other("forward_dynamics")

    def of(self, name: str) -> Case:
        """The same with another function under proof."""
        return replace(self, subject=self.other(name))

    @property
    def point(self) -> Point:
        """Where."""
        return self.chain.point

    def run(self, given: Given | None = None) -> dict[str, Vector]:
        """The outputs of the function under proof, at the point itself where nothing else is given.

        Raises:
            Wrong: it computes nothing there.
        """
        return self._made(self.subject.values, given or self.point.given())

    def times(self, given: Given, vectors: Mapping[str, Vector]) -> dict[str, Vector]:
        """The matrices under proof, each times a vector: sums over columns, a loop over seeds run once where it can be.

        Raises:
            Wrong: it computes nothing there.
        """
        if self.subject.columns is None:
            found = self.run(given)
            return {
                name: [dot(found[name][i : i + len(vector)], vector) for i in range(0, len(found[name]), len(vector))]
                for name, vector in vectors.items()
            }
        program, plan = self.subject.columns
        weights: dict[str, Vector] = {}
        for block in plan.blocks:
            if block.weights is None:
                continue
            entries = [0] * block.weights.size
            entries[block.first : block.first + block.count] = vectors[block.output][block.column :][: block.count]
            weights[block.weights.name] = entries
        made = self._made(program, replace(given, values={**given.values, **weights}))
        total: dict[str, Vector] = {}
        for block in plan.blocks:
            rows, weight = made[block.rows], 1 if block.weights else vectors[block.output][block.column]
            total[block.output] = plus(total.get(block.output, [0] * len(rows)), rows, weight)
        return total

    def _made(self, program: Compiled, given: Given) -> dict[str, Vector]:
        try:
            made = program(given, self.point)
        except FAULTS as fault:
            raise Wrong(f"no result at all, for {nothing(fault)}") from fault
        return {name: parts[0] for name, parts in made.items()}

    def same(self, name: str, found: Sequence[int], true: Sequence[int]) -> None:
        """Hold an output against what it must be, entry by entry.

        Raises:
            Wrong: they differ.
        """
        for i, (one, other) in enumerate(zip(found, true, strict=True)):
            if (one - other) % PRIME:
                raise Wrong(f"{name}[{i}]")

    def zero(self, name: str, residual: Callable[[Vector], int], turn: Vector) -> None:
        """Hold that a linear functional vanishes along a random vector of rates.

        Raises:
            Wrong: it does not; names the first coordinate that shows it.
        """
        if residual(turn) % PRIME == 0:
            return
        for first, size in self._blocks():
            alone = [entry if first <= i < first + size else 0 for i, entry in enumerate(turn)]
            if residual(alone) % PRIME:
                raise Wrong(f"{name}[{first}]" if size == 1 else f"{name}[{first}] to [{first + size - 1}]")
        raise Wrong(name)

    def _blocks(self) -> list[tuple[int, int]]:
        """(first, size) of every coordinate of the cart and of the angles, or of every link's rotation."""
        carts, nv = self.point.carts, self.scene.nv
        step = 1 if self.scene.is_planar else 3
        return [*((i, 1) for i in range(carts)), *((i, step) for i in range(carts, nv, step))]


def nothing(fault: Exception) -> str:
    """Why a Program computed nothing."""
    match fault:
        case ZeroDivisionError():
            return "it divides by zero"
        case IndexError():
            return f"it writes {fault.args[0]}"
    return "it reads what was never written"


Prove = TypeVar("Prove", bound=Callable[[Case], None])

IDENTITIES: Final[Registry[Callable[[Case], None]]] = Registry("phichain.proof", "identity")


def proves(name: str, space: str = ANY, is_helper: bool = False) -> Callable[[Prove], Prove]:
    """Register the identity that proves a function of the contract, or of what these call: it returns, or raises `Wrong`."""

    def register(identity: Prove) -> Prove:
        IDENTITIES.add(name, identity, space, needs_row=not is_helper)
        return identity

    return register

