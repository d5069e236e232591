"""Seconds from a scene to something callable, caches out of the way."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from phichain.emit import library_files
from phichain.files import write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native import build_folder
from phichain.native.cache import Cache
from phichain.scene import Scene, standard_scene
from phichain.system import System

_warm = False


def processor_seconds() -> float:
    """Processor time of this process and of the compilers it waited for."""
    return sum(os.times()[:4])


def built_afresh(scene: Scene) -> tuple[System, float]:
    """The scene's System, and the seconds it took to derive, lower, emit, compile and load it.

    A one-link chain goes first, once, so that imports are not counted; the compiled object comes from no cache.
    """
    global _warm
    if not _warm:
        _warm = True
        _built(standard_scene(1))
    return _built(scene)


def _built(scene: Scene) -> tuple[System, float]:
    begin = processor_seconds()
    files = library_files(scene, lower(derive(scene)))
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as folder:
        source = write_folder(Path(folder) / scene.name, files)
        system = build_folder(source, cache=Cache(Path(folder) / "cache"))
        return system, processor_seconds() - begin
