"""Sines and cosines of straight-line code, gathered so that one call computes as many as possible."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.nodes import Local, Op, Operand, Statement


@dataclass(frozen=True)
class TrigBatch:
    """The angles of one generation, in the order of their first use."""

    number: int
    angles: list[Operand]


class TrigBatches:
    """Sines and cosines grouped by how many sines lie beneath their angle.

    Attributes:
        definitions: the operation that computes each value, by its name.
        results: (name, "sin" or "cos") of every value wanted of an angle.
    """

    def __init__(self, statements: tuple[Statement, ...]) -> None:
        self.definitions = {s.result: s for s in statements if isinstance(s, Op)}
        self.results: dict[Operand, list[tuple[str, str]]] = {}
        self._batches: dict[int, TrigBatch] = {}
        self._of_angle: dict[Operand, TrigBatch] = {}
        generation: dict[str, int] = {}
        for op in self.definitions.values():
            named = (arg.name for arg in op.args if isinstance(arg, Local))
            below = max((generation.get(name, 0) for name in named), default=0)
            generation[op.result] = below
            if op.kind in ("sin", "cos"):
                generation[op.result] = below + 1
                self._gather(op, below)

    def batch_of(self, op: Op) -> TrigBatch:
        """The batch of the angle of a sine or cosine."""
        return self._of_angle[op.args[0]]

    def suffix(self, batch: TrigBatch) -> str:
        """What tells a batch's arrays `sine`, `cosine` and `angle` from others, and from values of such names."""
        suffix = "" if batch.number == 0 else f"_{batch.number + 1}"
        named = {name for name, op in self.definitions.items() if op.kind not in ("sin", "cos")}
        while any(f"{stem}{suffix}" in named for stem in ("sine", "cosine", "angle")):
            suffix = f"_of_batch{suffix}"
        return suffix

    def _gather(self, op: Op, below: int) -> None:
        batch = self._batches.setdefault(below, TrigBatch(len(self._batches), []))
        angle = op.args[0]
        if angle not in self.results:
            batch.angles.append(angle)
            self._of_angle[angle] = batch
        self.results.setdefault(angle, []).append((op.result, op.kind))
