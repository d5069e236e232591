"""A law's C and a chain's C in one shared object, and the call that lets them run."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.emit.law.trajectory import swingup_files
from phichain.emit.law.trials import trials_source, trials_symbol
from phichain.laws import TrajectoryLaw
from phichain.native import default_cache
from phichain.native.library import load_library, shared_object
from phichain.scene import Scene

Vector = NDArray[np.float64]
STEPS = 2
"""Steps of the classical Runge-Kutta method within a sample."""


@dataclass(frozen=True)
class Compiled:
    """A law on a chain, compiled.

    Attributes:
        scene: The chain; its runtime parameters differ from run to run.
        law: The law.
        function: What is called.
    """

    scene: Scene
    law: TrajectoryLaw
    function: Any

    @classmethod
    def of(cls, scene: Scene, texts: Mapping[str, str], law: TrajectoryLaw, real: str = "float") -> Compiled:
        """Compile them together.

        Args:
            scene: The chain, in double precision.
            texts: The files that were generated of it.
            law: The law, of a chain of the same name.
            real: The type of the law's C.

        Raises:
            CompilerError: The compiler is missing or failed.
            EmissionError: A number of the law does not fit the type.
        """
        folder = swingup_files(law, real)
        wanted = (f"{scene.name}.h", f"{scene.name}.c")
        led = {name: text for name, text in folder.items() if name.endswith((".h", ".c")) and name != "selftest.c"}
        sources = {**{name: texts[name] for name in wanted}, **led, f"{scene.name}_trials.c": trials_source(scene, law)}
        shared = shared_object(scene.name, {name: text.encode() for name, text in sources.items()}, default_cache())
        function = load_library(shared)[trials_symbol(scene)]
        function.restype = None
        return cls(scene, law, function)

    def runs(
        self, starts: Vector, parameters: Vector, seconds: float, trace: bool = False, resolution: Vector | None = None
    ) -> tuple[Vector, Vector, NDArray[np.intc], Vector | None]:
        """Let it run.

        Args:
            starts: Where each run begins (n, nx).
            parameters: Its runtime parameters (n, np), as the struct has them.
            seconds: How long.
            trace: Whether to keep every sample of the one run that there is.
            resolution: Step of every entry that the law reads, 0 for exact ones; all exact unless given.

        Returns:
            Ends (n, nx); largest distance of the first coordinate from 0 and largest size of every input (n, 1 + nu); last phases
            (n,); states and inputs at the samples (m, nx + nu), where they are kept: NaN behind the sample at which it gave up.
        """
        ends = np.array(starts, dtype=float, order="C")
        given = np.ascontiguousarray(parameters, dtype=float)
        n, nu = len(ends), self.scene.nu
        samples = round(seconds / self.law.catch.sample)
        largest, phases = np.zeros((n, 1 + nu)), np.zeros(n, dtype=np.intc)
        steps = np.zeros(self.law.measured) if resolution is None else np.array(np.broadcast_to(resolution, self.law.measured), dtype=float)
        kept = np.full((samples, ends.shape[1] + nu), np.nan) if trace else None

        def address(array: Any) -> Any:
            return ctypes.c_void_p(None if array is None else array.ctypes.data)

        self.function(
            ctypes.c_long(n), ctypes.c_long(samples), ctypes.c_double(self.law.catch.sample), ctypes.c_int(STEPS), address(steps),
            address(given), address(ends), address(largest), address(phases), address(kept),
        )  # fmt: skip
        return ends, largest, phases, kept
