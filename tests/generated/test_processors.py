"""The same bytes on every processor: all committed scenes, generated as on this machine, with old kernels, with an old libm.

OpenBLAS takes the kernels of a Prescott and NumPy's loops those without AVX2 and FMA; then the C library leaves its own AVX and FMA
variants. Before numbers on the road were rounded once, 11 files of 5 scenes differed between the first two.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

import pytest

from tests.generated.processors import scenes

ROOT = Path(__file__).parents[2]
PLAIN = "as it is"
SETTINGS = {
    PLAIN: {"PYTHONHASHSEED": "0"},
    "old kernels": {
        "OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX2 FMA3",
        "PYTHONHASHSEED": "0",
    },
    "old libm": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX", "PYTHONHASHSEED": "20261129"},
}  # fmt: skip


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Path]]:
    """The folder of each setting; the three processes run side by side."""
    folders = {name: tmp_path_factory.mktemp("processor") for name in SETTINGS}
    path = os.pathsep.join([str(ROOT / "codegen"), str(ROOT)])
    running = [
        subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", "tests.generated.processors", str(folders[name])],
            cwd=ROOT, env={**os.environ, "PYTHONPATH": path, **setting}, stderr=subprocess.PIPE, text=True,
        )
        for name, setting in SETTINGS.items()
    ]  # fmt: skip
    try:
        for process in running:
            _, said = process.communicate(timeout=600)
            assert process.returncode == 0, said
    finally:
        for process in running:
            process.kill()
    yield folders


def files(folder: Path) -> dict[str, bytes]:
    """Every file by its path below the folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def first_difference(one: bytes, other: bytes) -> str:
    """The first line in which two texts differ."""
    pairs = zip_longest(one.decode().splitlines(), other.decode().splitlines())
    return next((f"line {i}: {a!r} against {b!r}" for i, (a, b) in enumerate(pairs, 1) if a != b), "line ends")


@pytest.mark.parametrize("setting", [name for name in SETTINGS if name != PLAIN])
def test_every_byte_is_the_same(setting: str, generated: dict[str, Path]) -> None:
    here, there = files(generated[PLAIN]), files(generated[setting])
    assert {Path(name).parts[0] for name in here} == {scene.name for scene in scenes()}
    assert set(here) == set(there)
    assert {name: first_difference(here[name], there[name]) for name in here if here[name] != there[name]} == {}
