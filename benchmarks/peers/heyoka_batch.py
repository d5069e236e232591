"""heyoka on batches: the compiled function of several states, and the Taylor integrator of eight trajectories."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain
from benchmarks.harness import run_compiler
from benchmarks.peers import heyoka_cfunc, recursions

Array = NDArray[np.float64]


def dynamics(chain: Chain, folder: Path, width: int) -> ctypes._CFuncPtr:
    """The vectorised function of `width` states a call, taken from heyoka's own object code."""
    symbols, accelerations = _equations(chain)
    function = hy.cfunc(accelerations, vars=symbols, fast_math=True, compact_mode=False, batch_size=width)
    stem = folder / f"heyoka_batch_{chain.links}_{width}"
    # the modules are: one evaluation, one evaluation with strides, a batch
    stem.with_suffix(".o").write_bytes(function.llvm_states[2].object_code)
    library = stem.with_suffix(".so")
    own = heyoka_cfunc.own_library()
    run_compiler(["cc", "-shared", str(stem.with_suffix(".o")), own, "-o", str(library), "-lm"])
    return ctypes.CDLL(str(library)).cfunc


def flows(chain: Chain, angles: Array, tolerance: float) -> list[Callable[[float], Array]]:
    """Propagations of the trajectories from rest to a time, one function per mode; each returns the angles there."""
    symbols, accelerations = _equations(chain)
    links = chain.links
    system = [
        *zip(symbols[:links], symbols[links:], strict=True),
        *zip(symbols[links:], accelerations, strict=True),
    ]
    start = np.zeros((2 * links, len(angles)))
    start[:links] = angles.T
    found = []
    for compact in (False, True):
        integrator = hy.taylor_adaptive_batch(system, start.copy(), tol=tolerance, compact_mode=compact)

        def run(t: float, integrator: Any = integrator) -> Array:
            integrator.set_time(0.0)
            integrator.state[:] = start
            integrator.propagate_until(t)
            return np.array(integrator.state[:links].T)

        found.append(run)
    return found


def reference(chain: Chain, angles: Array, t: float) -> Array:
    """The angles of one trajectory from rest in extended precision."""
    symbols, accelerations = _equations(chain)
    links = chain.links
    system = [
        *zip(symbols[:links], symbols[links:], strict=True),
        *zip(symbols[links:], accelerations, strict=True),
    ]
    start = np.zeros(2 * links, dtype=np.longdouble)
    start[:links] = angles
    integrator = hy.taylor_adaptive(
        system, start, tol=np.longdouble(1e-18), fp_type=np.longdouble, compact_mode=True
    )
    integrator.propagate_until(np.longdouble(t))
    return np.array(integrator.state[:links], dtype=float)


def _equations(chain: Chain) -> tuple[list[Any], list[Any]]:
    names = [f"q{i}" for i in range(chain.nq)] + [f"v{i}" for i in range(chain.nv)]
    symbols = list(hy.make_vars(*names))
    q, v = symbols[: chain.nq], symbols[chain.nq :]
    return symbols, recursions.planar_link_frame(chain, q, v, [], hy.sin, hy.cos)
