"""What a worker does: the points of a batch on Systems that it builds once each, from their scenes, and keeps."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from phichain._version import __version__
from phichain.errors import StudyError
from phichain.studies.axis import Value
from phichain.studies.point import Base, Point, Resolver
from phichain.studies.task import Failure, Row, failed

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.system import System

MOST_SYSTEMS: Final = 64
"""Systems that a worker keeps."""
_SYSTEMS: Final[dict[str, System]] = {}


@dataclass(frozen=True)
class Batch:
    """Some points of a study, as they are sent to a worker.

    Attributes:
        base: What the study holds fast.
        keys: What varies.
        values: Values of the axes, a tuple a point.
        version: Of the phichain that hands them out.
        retries: How often a point that failed otherwise than by a refusal is tried again.
    """

    base: Base
    keys: tuple[str, ...]
    values: tuple[tuple[Value, ...], ...]
    version: str
    retries: int


@dataclass(frozen=True)
class Finished:
    """What became of a batch.

    Attributes:
        results: A row or a failure a point.
        busy: Seconds of computing.
        process: Who computed it.
    """

    results: list[Row | Failure]
    busy: float
    process: int


def run_batch(batch: Batch) -> Finished:
    """Compute the points of a batch; whatever fails leaves its reason.

    Raises:
        StudyError: Another version of phichain runs here.
    """
    if batch.version != __version__:
        raise StudyError("scheduler", __version__, f"has workers that run another phichain than {batch.version}", "install the same version on all")
    began = time.perf_counter()
    resolver = Resolver(batch.base, batch.keys)
    points = [resolver(values) for values in batch.values]
    results = computed(resolver, points)
    for _ in range(batch.retries):
        again = [k for k, result in enumerate(results) if isinstance(result, Failure) and not result.is_final]
        for k in again:
            results[k] = computed(resolver, [points[k]])[0]
    return Finished(results, time.perf_counter() - began, os.getpid())


def computed(resolver: Resolver, points: Sequence[Point]) -> list[Row | Failure]:
    """Results of points, those of one chain together."""
    found: dict[int, Row | Failure] = {}
    groups: dict[str, list[int]] = {}
    for k, point in enumerate(points):
        groups.setdefault(point.digest, []).append(k)
    for members in groups.values():
        chosen = [points[k] for k in members]
        try:
            results = resolver.task.run(system_of(chosen[0].scene, chosen[0].digest), chosen)
        except Exception as failure:  # noqa: BLE001 - a chain that cannot be built fails its own points alone
            results = [failed(failure)] * len(chosen)
        found |= zip(members, results, strict=True)
    return [found[k] for k in range(len(points))]


def system_of(scene: Scene, digest: str) -> System:
    """The compiled chain, built once by this process, or found in the machine's cache."""
    from phichain.pipeline import build

    if digest not in _SYSTEMS:
        if len(_SYSTEMS) >= MOST_SYSTEMS:
            del _SYSTEMS[next(iter(_SYSTEMS))]
        _SYSTEMS[digest] = build(scene)
    return _SYSTEMS[digest]
