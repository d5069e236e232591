"""Every example runs alone, from any folder, and leaves the figures it says."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.firmware.targets import HOST

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.long
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


def test_the_firmware_example_says_its_trace_on_this_machine_too(tmp_path: Path) -> None:
    """Single precision and trigonometry of its own: what the emulated Cortex-M4F says (`make firmware`), to the last bit."""
    specification = importlib.util.spec_from_file_location("firmware_run", EXAMPLES / "firmware" / "run.py")
    assert specification is not None and specification.loader is not None
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    assert example.trace(tmp_path, HOST) == (EXAMPLES / "firmware" / "trace.txt").read_text()
