"""Python scripts in processes of their own, to be raced and killed."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]


def python(script: str, *words: object) -> subprocess.Popen[bytes]:
    """Start a script that sees phichain and the tests."""
    command = [sys.executable, "-c", textwrap.dedent(script), *map(str, words)]
    paths = os.pathsep.join([str(CHECKOUT / "codegen"), str(CHECKOUT)])
    return subprocess.Popen(command, env={**os.environ, "PYTHONPATH": paths})
