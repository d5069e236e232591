"""The same bytes on every processor: all committed scenes, generated as on this machine, and as on one of twenty years ago.

There OpenBLAS takes the kernels of a Prescott, NumPy's loops are those without AVX2 and FMA, the C library leaves its own AVX and
FMA variants, and the hash seed is another. Before numbers on the road were rounded once, 11 files of 5 scenes differed.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import pytest

from phichain.scene import Scene
from tests.generated.processors import scenes

ROOT = Path(__file__).parents[2]
OLD = {
    "OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX2 FMA3",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX", "PYTHONHASHSEED": "20261129",
}  # fmt: skip
"""The environment of that machine's process."""


def files(folder: Path) -> dict[str, bytes]:
    """Every file by its path below the folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def first_difference(one: bytes, other: bytes) -> str:
    """The first line in which two texts differ."""
    pairs = zip_longest(one.decode().splitlines(), other.decode().splitlines())
    return next((f"line {i}: {a!r} against {b!r}" for i, (a, b) in enumerate(pairs, 1) if a != b), "line ends")


@pytest.mark.long
def test_every_byte_is_the_same(generated_once: Callable[[Scene], Path], tmp_path: Path) -> None:
    """This process and the other one write side by side."""
    path = os.pathsep.join([str(ROOT / "codegen"), str(ROOT)])
    command = [sys.executable, "-W", "ignore", "-m", "tests.generated.processors", str(tmp_path)]
    other = subprocess.Popen(
        command, cwd=ROOT, env={**os.environ, "PYTHONPATH": path, **OLD}, stderr=subprocess.PIPE, text=True
    )
    try:
        here = {scene.name: files(generated_once(scene)) for scene in scenes()}
        _, said = other.communicate(timeout=600)
    finally:
        other.kill()
    assert other.returncode == 0, said
    there = {folder.name: files(folder) for folder in tmp_path.iterdir()}
    assert {name: set(texts) for name, texts in here.items()} == {name: set(texts) for name, texts in there.items()}
    differing = {(name, file) for name, texts in here.items() for file, text in texts.items() if text != there[name][file]}
    assert {key: first_difference(here[key[0]][key[1]], there[key[0]][key[1]]) for key in differing} == {}
