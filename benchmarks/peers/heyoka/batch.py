"""heyoka on batches: the compiled function of several states a call, taken from its own object code."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import heyoka as hy

from benchmarks.chains import Chain
from benchmarks.harness import run_compiler
from benchmarks.peers import recursions
from benchmarks.peers.heyoka import cfunc


def dynamics(chain: Chain, folder: Path, width: int, form: str | None = None) -> Any:
    """The vectorised function of `width` states a call."""
    symbols, accelerations = cfunc.equations(chain, form or recursions.forms(chain)[0])
    function = hy.cfunc(accelerations, vars=symbols, fast_math=True, compact_mode=False, batch_size=width)
    stem = folder / f"heyoka_batch_{chain.space}{chain.links}_{width}"
    # the modules are: one evaluation, one evaluation with strides, a batch
    stem.with_suffix(".o").write_bytes(function.llvm_states[2].object_code)
    library = stem.with_suffix(".so")
    own = cfunc.own_library()
    run_compiler(["cc", "-shared", str(stem.with_suffix(".o")), own, "-o", str(library), "-lm"])
    return ctypes.CDLL(str(library)).cfunc
