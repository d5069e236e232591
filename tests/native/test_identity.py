"""What a cached library is known by: all that its text was made from."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]


def known_by(checkout: Path) -> str:
    return subprocess.run(
        [sys.executable, "-c", "from phichain.identity import generator; print(generator())"],
        env={**os.environ, "PYTHONPATH": str(checkout / "codegen")}, check=True, capture_output=True, text=True,
    ).stdout


@pytest.mark.parametrize("changed", ("stencils/flow/series.c", "templates", "codegen/phichain/lowering/momentum.py"))
def test_a_checkout_is_another_generator_when_a_file_changes_that_text_is_made_from(changed, tmp_path):
    for folder in ("codegen", "stencils", "templates"):
        shutil.copytree(TOP / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    before = known_by(tmp_path)
    file = tmp_path / changed
    file = file if file.is_file() else next(path for path in sorted(file.rglob("*.j2")))
    file.write_text(file.read_text() + "\n")
    assert known_by(tmp_path) != before
