"""One scene, generated and compiled by itself: its operations, its bytes of code, what it exports."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks import ours
from benchmarks.building import objects

if TYPE_CHECKING:
    from phichain import Scene

SMALL = ("-Os", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")


@dataclass(frozen=True)
class Measured:
    """What one scene comes to.

    Attributes:
        name: The scene.
        operations: Of every function, by its name, as the manifest counts them.
        text: Bytes of code of all of them.
        symbols: What the object exports.
    """

    name: str
    operations: dict[str, int]
    text: int
    symbols: tuple[str, ...]


def measure(scene: Scene) -> Measured:
    """Generates a scene in a scratch folder and reads manifest and object."""
    from phichain import generate

    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        folder = Path(generate(scene, Path(scratch)))
        compiled = objects.inspect(ours.source(folder), SMALL)
        operations = {name: ours.operations(folder, name) for name in ours.manifest(folder)["functions"]}
        return Measured(scene.name, operations, compiled.text, compiled.symbols)
