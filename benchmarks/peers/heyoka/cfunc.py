"""heyoka: an expert's O(N) recursion as a compiled function (cfunc), fast_math on.

heyoka compiles in memory. The object file that its LLVM made is taken as it is and linked into a shared
object, so the peer is called from C with no Python and no copying around it; what is timed is the machine
code that heyoka itself would run.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import heyoka as hy

from benchmarks.chains import Chain
from benchmarks.harness import Candidate, run_compiler
from benchmarks.peers import recursions

VERSION = hy.__version__


@dataclass(frozen=True)
class _Symbols:
    """Runtime parameters in the order of the emitted struct."""

    mass: list[Any]
    length: list[Any]
    com: list[Any]


def equations(chain: Chain, form: str) -> tuple[list[Any], list[Any]]:
    """(symbols of the state row, accelerations)."""
    names = [f"{letter}{i}" for letter, size in (("q", chain.nq), ("v", chain.nv), ("u", chain.nu)) for i in range(size)]
    symbols = list(hy.make_vars(*names)) if len(names) > 1 else [hy.make_vars(*names)]
    q, v, u = symbols[: chain.nq], symbols[chain.nq : chain.nq + chain.nv], symbols[chain.nq + chain.nv :]
    n = chain.links
    numbers = _Symbols(*([hy.par[i * n + k] for k in range(n)] for i in range(3))) if chain.runtime else None
    return symbols, recursions.accelerations(chain, form, q, v, u, hy.sin, hy.cos, numbers)


def compiled(chain: Chain, form: str, slp: bool = False) -> Any:
    """heyoka's own callable over the state row (q, v, u).

    Args:
        chain: the chain.
        form: one of ``recursions.forms``.
        slp: let LLVM's superword vectoriser try; which setting is better depends on the size.
    """
    symbols, outputs = equations(chain, form)
    return hy.cfunc(outputs, vars=symbols, fast_math=True, compact_mode=False, slp_vectorize=slp)


def build(chain: Chain, folder: Path, form: str | None = None, slp: bool = False) -> Candidate:
    """The scalar function of ``compiled`` as a shared object."""
    form = form or recursions.forms(chain)[0]
    function = compiled(chain, form, slp)
    name = f"heyoka cfunc{recursions.LABELS[form]}" + (", slp" if slp else "")
    stem = folder / name.replace(" ", "_").replace(",", "").replace("^", "")
    # the modules are: one evaluation, one evaluation with strides, a SIMD batch
    stem.with_suffix(".o").write_bytes(function.llvm_states[0].object_code)
    library = stem.with_suffix(".so")
    run_compiler(["cc", "-shared", str(stem.with_suffix(".o")), own_library(), "-o", str(library), "-lm"])
    return Candidate(name, library, "cfunc", kind="hybrid" if form in recursions.HYBRID else "peer")


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
    compiled(chain, recursions.forms(chain)[0])
    return time.perf_counter() - start
