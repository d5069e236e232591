"""Benchmarks of phichain: every figure is measured beside its peers, in one run, on the machine at hand.

Linear algebra runs on one thread, ours and the peers', here and in whatever a benchmark starts: threads that wait in a spin for work count
as processor time, and two for a matrix of four rows are no faster. It has to be said before NumPy is loaded, so it is said here.
"""

from __future__ import annotations

import os
from typing import Final

ONE_THREAD: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Where libraries of linear algebra look for how many threads they may take; what is set already stays."""
for _name in ONE_THREAD:
    os.environ.setdefault(_name, "1")


def threads_told() -> str:
    """How many threads linear algebra takes, in words."""
    told = sorted({os.environ[name] for name in ONE_THREAD})
    return f"linear algebra on {' or '.join(told)} thread{'' if told == ['1'] else 's'}"
