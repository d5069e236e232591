"""heyoka: an expert's O(N) recursion as a compiled function (cfunc), fast_math on.

heyoka compiles in memory. The object file that its LLVM made is taken as it is and linked into a shared
object, so the peer is called from C with no Python and no copying around it; what is timed is the machine
code that heyoka itself would run.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import heyoka as hy

from benchmarks.chains import Chain
from benchmarks.harness import Candidate, run_compiler
from benchmarks.peers import recursions

VERSION = hy.__version__


def compiled(chain: Chain, form: str = "tension", slp: bool = False) -> Any:
    """heyoka's own callable over the state row (q, v, u).

    Args:
        chain: the chain.
        form: spatial only, a key of ``recursions.SPATIAL``.
        slp: let LLVM's superword vectoriser try; which setting is better depends on the size.
    """
    names = (
        [f"q{i}" for i in range(chain.nq)]
        + [f"v{i}" for i in range(chain.nv)]
        + [f"u{i}" for i in range(chain.nu)]
    )
    symbols = list(hy.make_vars(*names))
    q, v, u = symbols[: chain.nq], symbols[chain.nq : chain.nq + chain.nv], symbols[chain.nq + chain.nv :]
    if chain.space == "planar":
        outputs = recursions.planar_link_frame(chain, q, v, u, hy.sin, hy.cos)
    else:
        outputs = recursions.SPATIAL[form](chain, q, v, u)
    return hy.cfunc(outputs, vars=symbols, fast_math=True, compact_mode=False, slp_vectorize=slp)


def build(chain: Chain, folder: Path, form: str = "tension", slp: bool = False) -> Candidate:
    """The scalar function of ``compiled`` as a shared object."""
    function = compiled(chain, form, slp)
    name = "heyoka cfunc" + (recursions.LABELS[form] if chain.space == "spatial" else "") + (", slp" if slp else "")
    stem = folder / name.replace(" ", "_").replace(",", "").replace("^", "")
    scalar = function.llvm_states[
        0
    ]  # the modules are: one evaluation, one evaluation with strides, a SIMD batch
    stem.with_suffix(".o").write_bytes(scalar.object_code)
    library = stem.with_suffix(".so")
    run_compiler(["cc", "-shared", str(stem.with_suffix(".o")), own_library(), "-o", str(library), "-lm"])
    return Candidate(name, library, "cfunc", abi="flat", kind="hybrid" if form == "twisted" else "peer")


def own_library() -> str:
    """Path of heyoka's library in this process, where the vector sine and cosine its code may call live."""
    paths = {
        line.split()[-1] for line in Path("/proc/self/maps").read_text().splitlines() if "libheyoka" in line
    }
    return min(paths)


def seconds_to_callable(chain: Chain) -> float:
    """Description to compiled callable, its caches in memory and on disk out of the way, seconds."""
    hy.llvm_state.clear_memcache()
    hy.llvm_state.set_diskcache_enabled(False)
    start = time.perf_counter()
    compiled(chain)
    return time.perf_counter() - start
