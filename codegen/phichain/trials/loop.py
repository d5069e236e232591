"""Any law's C and a chain's C in one shared object, and the call that lets them run."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.emit.law.loop import LATEST, Called, loop_source, loop_symbol
from phichain.native import default_cache
from phichain.native.library import load_library, shared_object
from phichain.scene import Scene

Vector = NDArray[np.float64]
STEP: Final = 5e-4
"""Longest step of the chain, s."""
NEVER: Final = -2
"""No law says this of itself."""


@dataclass(frozen=True)
class Task:
    """What all runs share.

    Attributes:
        sample: From one call of the law to the next, s.
        calls: Calls.
        target: Where every run is to end (nx,).
        wraps: Entries whose deviation counts modulo a full turn (nx,).
        near: How near every entry must be (nx,).
        reads: Entries of the state that are measured (ny,).
        resolution: In which steps (ny,), 0 for exactly.
        every: Samples from one kept in the trace to the next.
        lost: What the law says where it gives up, and a run ends; NEVER where it says no such thing.
    """

    sample: float
    calls: int
    target: Vector
    wraps: tuple[bool, ...]
    near: Vector
    reads: tuple[int, ...]
    resolution: Vector
    every: int = 1
    lost: int = NEVER


@dataclass(frozen=True)
class Loop:
    """A law on a chain, compiled.

    Attributes:
        scene: The chain; its runtime parameters differ from run to run.
        law: The law.
        function: What is called.
    """

    scene: Scene
    law: Called
    function: Any

    @classmethod
    def of(cls, scene: Scene, texts: Mapping[str, str], law: Called, sources: Mapping[str, str]) -> Loop:
        """Compile them together.

        Args:
            scene: The chain, in double precision.
            texts: The files that were generated of it.
            law: How the law is called.
            sources: The law's header and source by file name.

        Raises:
            CompilerError: The compiler is missing or failed.
        """
        wanted = {name: texts[name] for name in (f"{scene.name}.h", f"{scene.name}.c")}
        every = {**wanted, **sources, f"{scene.name}_loop.c": loop_source(scene, law)}
        shared = shared_object(scene.name, {name: text.encode() for name, text in every.items()}, default_cache())
        function = load_library(shared)[loop_symbol(scene)]
        function.restype = None
        return cls(scene, law, function)

    def runs(
        self, task: Task, starts: Vector, parameters: Vector, late: Vector | NDArray[np.int64], trace: bool = False
    ) -> tuple[Vector, Vector, NDArray[np.int64], NDArray[np.intc], Vector | None]:
        """Let it run.

        Args:
            task: What all runs share.
            starts: Where each begins (n, nx).
            parameters: Its runtime parameters (n, np), as the struct has them.
            late: By how many calls its inputs come late (n,).
            trace: Whether to keep samples of the one run that there is.

        Returns:
            Ends (n, nx); largest distance of the first coordinate from 0 and largest size of every input (n, 1 + nu); after which call each
            did not leave the target any more (n,); what the law said of itself last (n,), 0 where it says nothing; states and inputs at the
            samples (m, nx + nu), where they are kept: NaN behind the sample at which it gave up.
        """
        ends = np.array(starts, dtype=float, order="C")
        n, nx, nu, ny = len(ends), ends.shape[1], self.scene.nu, len(task.reads)
        given = np.ascontiguousarray(parameters, dtype=float)
        delays = np.minimum(np.ascontiguousarray(late, dtype=ctypes.c_long), LATEST)
        largest, since = np.zeros((n, 1 + nu)), np.zeros(n, dtype=ctypes.c_long)
        phases = np.zeros(n, dtype=np.intc)
        kept = np.full((-(-task.calls // task.every), nx + nu), np.nan) if trace else None
        shared = _task_type(nx, ny)(
            task.calls, task.every, max(1, int(np.ceil(task.sample / STEP - 1e-9))), task.lost, task.sample, tuple(task.target),
            tuple(2 * np.pi if turns else 0.0 for turns in task.wraps), tuple(task.near), tuple(task.resolution), tuple(task.reads),
        )  # fmt: skip

        def address(array: Any) -> Any:
            return ctypes.c_void_p(None if array is None else array.ctypes.data)

        self.function(
            ctypes.c_long(n), ctypes.byref(shared), address(delays), address(given), address(ends), address(largest), address(since),
            address(phases), address(kept),
        )  # fmt: skip
        return ends, largest, since, phases, kept


def _task_type(nx: int, ny: int) -> Any:
    """NAME_loop_task, as `emit.law.loop` writes it."""
    state, seen = ctypes.c_double * nx, ctypes.c_double * ny
    fields = [
        ("calls", ctypes.c_long), ("every", ctypes.c_long), ("steps", ctypes.c_long), ("lost", ctypes.c_long), ("sample", ctypes.c_double), ("target", state),
        ("turns", state), ("near", state), ("resolution", seen), ("reads", ctypes.c_long * ny),
    ]  # fmt: skip
    return type("Task", (ctypes.Structure,), {"_fields_": fields})
