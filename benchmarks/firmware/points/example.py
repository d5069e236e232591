"""The example that runs: examples/firmware on the emulated M4F."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from benchmarks.firmware.scenes import Generated

_SCRIPT: Final = Path(__file__).resolve().parents[3] / "examples" / "firmware" / "run.py"


def example(folders: Mapping[str, Generated]) -> Iterator[str]:
    """The example closes its loop on the M4F and says the committed trace."""
    root = next(iter(folders.values())).folder.parent
    done = subprocess.run([sys.executable, _SCRIPT, "--check"], cwd=root, capture_output=True, text=True, check=False)
    if done.returncode:
        yield (done.stdout + done.stderr)[-600:]
