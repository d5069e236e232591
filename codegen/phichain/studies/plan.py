"""Plan: the frozen record of what a study computes, before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, Final

import numpy as np

from phichain.errors import StudyError
from phichain.scene.scene import Scene
from phichain.studies.axis import MOST_VALUES, Axis, Value
from phichain.studies.point import KEY_SIZE, Base, Resolver
from phichain.studies.task import Output, Task, task_of

MOST_SCENES: Final = 1000
"""Chains that one study compiles; each takes seconds, and parameters of run time need none."""
_HANDLED: Final = 150
"""Bytes that a task takes of that process, besides its values."""


@dataclass(frozen=True)
class Plan:
    """A study: a task at every point of a grid, of samples, or of both.

    Attributes:
        name: Its name.
        base: What it holds fast.
        grid: Axes every combination of whose values is taken, the last one fastest.
        samples: Axes that take their values together, the k-th of each in the k-th sample; equally long.
        document: What it was made from, as tables; kept in the store.
    """

    name: str
    base: Base
    grid: tuple[Axis, ...]
    samples: tuple[Axis, ...]
    document: Mapping[str, Any]

    def __post_init__(self) -> None:
        if self.count > MOST_VALUES:
            raise StudyError(
                "study", self.count, f"has more tasks than the {MOST_VALUES} of one study",
                "split it: several studies, each with a part of one axis and a store of its own (docs/studies.md)",
            )  # fmt: skip
        if (chains := self.chains) > MOST_SCENES:
            raise StudyError(
                "study", chains, f"asks for more than {MOST_SCENES} chains to be compiled",
                'write "runtime" for the varied keys in the scene file, so that one compiled chain serves all values',
            )  # fmt: skip

    @property
    def keys(self) -> tuple[str, ...]:
        """What varies, the axes of the grid first."""
        return tuple(axis.key for axis in (*self.grid, *self.samples))

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the grid's axes and, where there are samples, their number."""
        return tuple(len(axis) for axis in self.grid) + ((len(self.samples[0]),) if self.samples else ())

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of those: a grid's axes by their keys, and "sample"."""
        return tuple(axis.key for axis in self.grid) + (("sample",) if self.samples else ())

    @property
    def count(self) -> int:
        """Number of tasks."""
        return math.prod(self.shape)

    @property
    def task(self) -> Task:
        """What is done at every point."""
        return task_of(self.base.task)

    @cached_property
    def resolver(self) -> Resolver:
        """Makes the points."""
        return Resolver(self.base, self.keys)

    @property
    def chains(self) -> int:
        """How many different chains are compiled, at most."""
        places = [self.base.place(axis.key) for axis in self.grid]
        grid = math.prod(len(axis) for axis, place in zip(self.grid, places, strict=True) if place.kind == "scene")
        drawn = [axis for axis in self.samples if self.base.place(axis.key).kind == "scene"]
        return grid * (len(set(zip(*(axis.values for axis in drawn), strict=True))) if drawn else 1)

    @cached_property
    def scenes(self) -> list[Scene]:
        """Every different chain, validated, with the functions that the task calls.

        Raises:
            SceneError: A value makes no chain.
        """
        resolver = self.resolver
        places = resolver.places[: len(self.grid)]
        grid = [axis.values for axis, place in zip(self.grid, places, strict=True) if place.kind == "scene"]
        drawn = [axis.values for axis, place in zip(self.samples, resolver.places[len(self.grid) :], strict=True) if place.kind == "scene"]
        together = sorted(set(zip(*drawn, strict=True)), key=repr) if drawn else [()]
        return [resolver.scene((*values, *sample))[0] for values in product(*grid) for sample in together]

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """What the task leaves, every dimension as long as the largest chain needs."""
        merged: dict[str, Output] = {}
        options = {**self.base.options, **self._largest}
        for scene in self.scenes:
            for name, output in self.task.outputs(scene, options).items():
                before = merged.get(name, output)
                dims = {dim: max(size, before.dims.get(dim, 0)) for dim, size in output.dims.items()}
                merged[name] = Output(output.text, dims, output.units, output.meanings)
        return merged

    @property
    def _largest(self) -> dict[str, Any]:
        """The largest value of every varied option that is a number, for which there must be room."""
        axes = zip((*self.grid, *self.samples), self.resolver.places, strict=True)
        return {place.name: max(axis.values) for axis, place in axes if place.kind == "option" and place.entry is None and axis.is_number}

    @property
    def labels(self) -> dict[str, list[Any]]:
        """Coordinates of the outputs' dimensions that all chains share."""
        found = [self.task.labels(scene, self.base.options) for scene in self.scenes]
        return {dim: list(values) for dim, values in found[0].items() if all(other.get(dim) == values for other in found)}

    def values(self, tasks: Sequence[int] | np.ndarray) -> Iterator[tuple[Value, ...]]:
        """The values of the axes at some tasks, by their number."""
        if not self.shape:
            yield from ((),) * len(tasks)
            return
        places = np.unravel_index(np.asarray(tasks, dtype=np.int64), self.shape)
        of_axis = [*places[: len(self.grid)], *[places[-1]] * len(self.samples)]
        columns = [[axis.values[k] for k in place.tolist()] for axis, place in zip((*self.grid, *self.samples), of_axis, strict=True)]
        yield from zip(*columns, strict=True)

    def point_keys(self) -> np.ndarray:
        """Keys of all tasks, (count, 32) bytes.

        Raises:
            PhichainError: A point makes no chain or holds an option that is none.
        """
        resolver = self.resolver
        joined = b"".join(resolver(values).key for values in self.values(range(self.count)))
        return np.frombuffer(joined, np.uint8).reshape(self.count, KEY_SIZE)

    @property
    def size(self) -> int:
        """Bytes of the results, uncompressed."""
        return self.count * (sum(output.size for output in self.outputs.values()) + KEY_SIZE + 8 * len(self.keys) + 1)

    @property
    def handled(self) -> int:
        """Bytes that this process takes to hand the tasks out."""
        return self.count * (_HANDLED + 32 * len(self.keys))

    def __str__(self) -> str:
        shape = " x ".join(f"{size} {dim}" for size, dim in zip(self.shape, self.dims, strict=True)) or "one point"
        return (
            f"{self.name}: {self.count} tasks of {self.task.name} ({shape}), {self.chains} chain(s) to compile, "
            f"results {size_words(self.size)}, {size_words(self.handled)} of memory here"
        )


def size_words(size: float) -> str:
    """A number of bytes as people read it."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} TB"
