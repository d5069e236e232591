"""No family wakes the threads of linear algebra: a matrix of a few rows is none of their business, and what they wait in a spin is processor time."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

_SCRIPT = """
import os, time
from pathlib import Path
import numpy as np
from phichain.orbits import trace
from tests.orbits.shot import uniform

def switches():
    tasks = (task for task in Path("/proc/self/task").iterdir() if int(task.name) != os.getpid())
    return [line for task in sorted(tasks) for line in (task / "status").read_text().splitlines() if "ctxt" in line]

system = uniform(2)
trace(system, until="theta_1=0.02")
time.sleep(0.2)  # until whoever was woken sleeps
before = switches()
trace(system, until="theta_1=1.2")
print(before == switches())
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="threads are counted where Linux shows them")
def test_a_family_wakes_no_thread() -> None:
    plain = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    done = subprocess.run([sys.executable, "-c", _SCRIPT], capture_output=True, text=True, check=True, env=plain)
    assert done.stdout.split() == ["True"]
