"""Every example runs alone, from any folder, and leaves the figures it says."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from phichain.app.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("script", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_runs_alone(script: Path, tmp_path: Path, cache_folder: Path) -> None:
    environment = {**os.environ, "PHICHAIN_CACHE": str(cache_folder)}
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    for line in done.stdout.splitlines():
        if "wrote " in line:
            assert (tmp_path / line.split("wrote ")[1]).stat().st_size > 10_000


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler called cc")
def test_the_firmware_example_compiles_strictly_and_keeps_the_energy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    main_of_cli = ["generate", "planar4", "--out", "generated"]
    with pytest.raises(SystemExit) as leaving:
        main(main_of_cli)
    assert leaving.value.code == 0
    strict = ["-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2"]
    sources = [str(EXAMPLES / "firmware" / "main.c"), "generated/planar4/planar4.c"]
    subprocess.run(["cc", *strict, "-I", "generated/planar4", *sources, "-lm", "-o", "swing"], check=True)
    done = subprocess.run(["./swing"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("theta_1") == 5
