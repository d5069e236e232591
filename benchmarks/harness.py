"""Loads compiled candidates side by side into one process and times them from C (see harness.c)."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain

C_FLAGS = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
SAMPLE_NANOSECONDS = 2e5


class BenchmarkError(RuntimeError):
    """A candidate could not be built or run; the message says which and why."""


@dataclass(frozen=True)
class Candidate:
    """A compiled function ``f(out, state, parameters, time)`` of a state row (q, v, u).

    Attributes:
        name: its row in the tables.
        library: the shared object.
        symbol: the function in it.
        kind: "peer", "ours", or "hybrid" for a formula of ours in a peer's compiler: listed, but no
            yardstick.
    """

    name: str
    library: Path
    symbol: str
    kind: str = "peer"


class _Candidate(ctypes.Structure):
    _fields_ = [("function", ctypes.c_void_p), ("evaluations", ctypes.c_size_t), ("at", ctypes.c_size_t)]


class _Workload(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("states", "parameters")),
        *((name, ctypes.c_size_t) for name in ("count", "width", "outputs")),
    ]


def run_compiler(command: Sequence[str], seconds: float | None = None) -> None:
    """Runs a compiler; a failure becomes one error with the first lines of what it said.

    Args:
        command: Its words.
        seconds: Its limit; none by default.

    Raises:
        BenchmarkError: It is not there, it failed, or it took longer.
    """
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=seconds)
    except FileNotFoundError as missing:
        raise BenchmarkError(f"no compiler {command[0]} here: install it") from missing
    except subprocess.TimeoutExpired as late:
        raise BenchmarkError(f"its C did not compile in {seconds:g} s") from late
    if done.returncode != 0:
        raise BenchmarkError(f"{' '.join(command)} failed: " + "\n".join(done.stderr.splitlines()[:8]))


def compile_shared(
    source: Path, library: Path, standard: str = "c99", extra: Sequence[str] = (), seconds: float | None = None
) -> Path:
    """Compiles one C file with the flags every candidate gets, and more if asked."""
    flags = [f"-std={standard}", *C_FLAGS, *extra, "-fPIC", "-shared"]
    run_compiler(["cc", *flags, str(source), "-o", str(library), "-lm"], seconds)
    return library


@cache
def _harness() -> ctypes.CDLL:
    folder = Path(tempfile.mkdtemp(prefix="phichain-bench-"))
    library = compile_shared(Path(__file__).with_name("harness.c"), folder / "harness.so", "gnu99")
    return ctypes.CDLL(str(library))


class Arena:
    """Candidates of one chain, loaded together, over one set of random states.

    Args:
        chain: The chain.
        candidates: What is compared.
        states: One row (q, v, u) each.
        outputs: Numbers that every candidate writes; nv by default.
    """

    def __init__(
        self, chain: Chain, candidates: Sequence[Candidate], states: NDArray[np.float64], outputs: int | None = None
    ) -> None:
        self._outputs = chain.nv if outputs is None else outputs
        self._width = chain.width
        self._states = np.ascontiguousarray(states, dtype=np.float64)
        self._parameters = np.ascontiguousarray(chain.parameters)
        self._libraries = [ctypes.CDLL(str(c.library)) for c in candidates]
        self._workload = _Workload(
            self._states.ctypes.data, self._parameters.ctypes.data, len(states), chain.width, self._outputs
        )
        self._records = (_Candidate * len(candidates))()
        for record, candidate, library in zip(self._records, candidates, self._libraries, strict=True):
            record.function = ctypes.cast(getattr(library, candidate.symbol), ctypes.c_void_p).value
            record.evaluations, record.at = 1, 0

    def evaluate(self, index: int, count: int | None = None) -> NDArray[np.float64]:
        """What one candidate writes at the first ``count`` states (all by default), one row each."""
        rows = len(self._states) if count is None else count
        out = np.full((rows, self._outputs), np.nan)  # what is not written shows
        _harness().harness_evaluate(
            ctypes.byref(self._records[index]), ctypes.byref(self._workload), ctypes.c_size_t(rows), _at(out)
        )
        return out

    def measure(self, rounds: int, chained: bool = False) -> NDArray[np.float64]:
        """Nanoseconds per evaluation, shape (rounds, candidates); each sample lasts about 0.2 ms."""
        for record in self._records:
            record.evaluations = 8
        first = self._samples(3, chained).min(axis=0)
        for record, single in zip(self._records, first, strict=True):
            record.evaluations = max(8, int(SAMPLE_NANOSECONDS / single))
        return self._samples(rounds, chained)

    def _samples(self, rounds: int, chained: bool) -> NDArray[np.float64]:
        samples = np.empty((rounds, len(self._records)))
        scratch = np.zeros(self._outputs + self._width)
        _harness().harness_measure(
            self._records, ctypes.c_int(len(self._records)), ctypes.byref(self._workload), ctypes.c_int(rounds),
            ctypes.c_int(chained), _at(scratch), _at(samples),
        )  # fmt: skip
        return samples


def _at(array: NDArray[np.float64]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
