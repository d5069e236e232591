"""The text of the flow: strict compilers, names, length, and vector code."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from phichain.emit.flow.propagate import flow
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.flow.flows import CHAINS, STRICT, planar, unit


@pytest.mark.long
@pytest.mark.parametrize(
    "chain",
    [*CHAINS.values(), planar(1, "single_one", target={"real": "float"})],
    ids=lambda chain: chain.name,
)
def test_strict_compilers_have_nothing_to_say(chain: Scene, tmp_path: Path) -> None:
    (tmp_path / "flow.c").write_text(unit(chain)[0])
    done = subprocess.run(
        ["cc", *STRICT, "-O2", "-c", "flow.c"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and not done.stderr, done.stderr[:3000]


@pytest.mark.parametrize("chain", CHAINS.values(), ids=lambda chain: chain.name)
def test_lines_are_short_and_every_name_at_file_scope_has_the_prefix(chain: Scene) -> None:
    made = flow(derive(chain))
    text = made.declarations + made.definitions
    assert max(map(len, text.splitlines())) <= 120
    for line in text.splitlines():
        if line.startswith(("static ", "int ", "#define ")):
            assert chain.name in line or chain.name.upper() in line, line


def test_the_text_is_the_same_every_time() -> None:
    assert unit(CHAINS["cart"])[0] == unit(CHAINS["cart"])[0]


def test_code_in_loops_does_not_grow_with_the_chain() -> None:
    few, many = (unit(planar(n, "chain"))[0].count("\n") for n in (16, 64))
    assert many <= few + 10


def test_sums_are_vectorised(tmp_path: Path) -> None:
    """The convolutions are where the time goes: gcc must turn them into vector code under the flags of `build`."""
    version = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True).stdout
    if "Free Software Foundation" not in version:
        pytest.skip("reads gcc's own notes")
    text = unit(planar(2))[0]
    (tmp_path / "flow.c").write_text(text)
    flags = [
        "-std=c99",
        "-O3",
        "-fno-trapping-math",
        "-fno-tree-slp-vectorize",
        "-fopt-info-vec",
        "-c",
        "flow.c",
    ]
    notes = subprocess.run(["cc", *flags], cwd=tmp_path, capture_output=True, text=True, check=True).stderr
    lines = text.splitlines()
    vectorised = [
        lines[int(note.split(":")[1]) - 1] for note in notes.splitlines() if "loop vectorized" in note
    ]
    assert any("chain2_flow_lefts" in line for line in vectorised), notes
