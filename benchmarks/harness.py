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
_ABI = {"plain": 0, "flat": 1}


class BenchmarkError(RuntimeError):
    """A candidate could not be built or run; the message says which and why."""


@dataclass(frozen=True)
class Candidate:
    """A compiled forward dynamics.

    Attributes:
        name: its row in the tables.
        library: the shared object.
        symbol: the function in it.
        abi: "plain" is ``f(q, v, [u,] a)``; "flat" is heyoka's ``f(a, state, parameters, time)``.
        kind: "peer", "ours", or "hybrid" for a formula of ours in a peer's compiler: listed, but no
            yardstick.
    """

    name: str
    library: Path
    symbol: str
    abi: str = "plain"
    kind: str = "peer"


@dataclass(frozen=True)
class Timing:
    """Nanoseconds per evaluation of one candidate and how it compares within the same rounds.

    Attributes:
        median, minimum: over the rounds, ns.
        ratio: median over the rounds of this candidate's time over that of the best peer, which is the one
            with
            the smallest median; None without peers.
        error: largest relative error against the reference, max norm over max norm.
    """

    name: str
    kind: str
    median: float
    minimum: float
    ratio: float | None
    error: float


class _Candidate(ctypes.Structure):
    _fields_ = [("function", ctypes.c_void_p), ("abi", ctypes.c_int), ("passes", ctypes.c_int)]


class _Workload(ctypes.Structure):
    _fields_ = [
        ("states", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
        ("nq", ctypes.c_size_t),
        ("nv", ctypes.c_size_t),
        ("nu", ctypes.c_size_t),
    ]


def run_compiler(command: Sequence[str]) -> None:
    """Runs a compiler; a failure becomes one error with the first lines of what it said."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BenchmarkError(f"{' '.join(command)} failed: " + "\n".join(done.stderr.splitlines()[:8]))


def compile_shared(source: Path, library: Path, standard: str = "c99", extra: Sequence[str] = ()) -> Path:
    """Compiles one C file with the flags every candidate gets, and more if asked."""
    flags = [f"-std={standard}", *C_FLAGS, *extra, "-fPIC", "-shared"]
    run_compiler(["cc", *flags, str(source), "-o", str(library), "-lm"])
    return library


@cache
def _harness() -> ctypes.CDLL:
    folder = Path(tempfile.mkdtemp(prefix="phichain-bench-"))
    library = compile_shared(Path(__file__).with_name("harness.c"), folder / "harness.so", "gnu99")
    return ctypes.CDLL(str(library))


class Arena:
    """Candidates of one chain, loaded together, over one set of random states."""

    def __init__(self, chain: Chain, candidates: Sequence[Candidate], states: NDArray[np.float64]) -> None:
        self._chain = chain
        self._candidates = tuple(candidates)
        self._states = np.ascontiguousarray(states, dtype=np.float64)
        self._libraries = [ctypes.CDLL(str(c.library)) for c in candidates]
        self._workload = _Workload(self._states.ctypes.data, len(states), chain.nq, chain.nv, chain.nu)
        self._records = (_Candidate * len(candidates))()
        for record, candidate, library in zip(self._records, candidates, self._libraries, strict=True):
            record.function = ctypes.cast(getattr(library, candidate.symbol), ctypes.c_void_p).value
            record.abi, record.passes = _ABI[candidate.abi], 1

    def evaluate(self, index: int, count: int | None = None) -> NDArray[np.float64]:
        """Accelerations of one candidate at the first ``count`` states (all by default), one row each."""
        rows = len(self._states) if count is None else count
        work = _Workload(self._states.ctypes.data, rows, self._chain.nq, self._chain.nv, self._chain.nu)
        out = np.full((rows, self._chain.nv), np.nan)  # what is not written shows
        _harness().harness_evaluate(
            ctypes.byref(self._records[index]), ctypes.byref(work), out.ctypes.data_as(ctypes.c_void_p)
        )
        return out

    def measure(self, rounds: int) -> NDArray[np.float64]:
        """Nanoseconds per evaluation, shape (rounds, candidates); each sample lasts about 0.2 ms."""
        first = self._samples(3).min(axis=0)
        for record, single in zip(self._records, first, strict=True):
            record.passes = max(1, int(SAMPLE_NANOSECONDS / (single * len(self._states))))
        return self._samples(rounds)

    def _samples(self, rounds: int) -> NDArray[np.float64]:
        samples = np.empty((rounds, len(self._candidates)))
        scratch = np.empty(self._chain.nv)
        _harness().harness_measure(
            self._records,
            ctypes.c_int(len(self._candidates)),
            ctypes.byref(self._workload),
            ctypes.c_int(rounds),
            scratch.ctypes.data_as(ctypes.c_void_p),
            samples.ctypes.data_as(ctypes.c_void_p),
        )
        return samples

    def timings(self, rounds: int, errors: Sequence[float]) -> list[Timing]:
        """Measures all candidates and relates each to the best peer of the run."""
        samples = self.measure(rounds)
        medians = np.median(samples, axis=0)
        peers = [i for i, c in enumerate(self._candidates) if c.kind == "peer"]
        best = min(peers, key=lambda i: float(medians[i])) if peers else None
        return [
            Timing(
                name=c.name,
                kind=c.kind,
                median=float(medians[i]),
                minimum=float(samples[:, i].min()),
                ratio=None if best is None else float(np.median(samples[:, i] / samples[:, best])),
                error=errors[i],
            )
            for i, c in enumerate(self._candidates)
        ]
