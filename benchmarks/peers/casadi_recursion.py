"""CasADi: an expert's O(N) recursion in SX, emitted as C and compiled with the flags of our own code.

CasADi's generated entry takes arrays of pointers and tests each for NULL at every read. The wrapper below hands
it pointers that the compiler can see are not NULL, as an expert who cares for speed would, and the compiler is
allowed to inline the entry into it: the tests vanish, and up to a third of the time with them.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca

from benchmarks.chains import Chain
from benchmarks.harness import Candidate, compile_shared
from benchmarks.peers import recursions

VERSION = ca.CasadiMeta.version()
_WRAPPER = """
void peer_function(double *restrict out, const double *restrict state, const double *restrict p, const double *time)
{{
    const double *arg[] = {{{inputs}}};
    double *res[] = {{{outputs}}};
    (void)time;
    expert(arg, res, 0, 0, 0);
}}
"""


@dataclass(frozen=True)
class _Symbols:
    """Runtime parameters in the order of the emitted struct."""

    mass: list[Any]
    length: list[Any]
    com: list[Any]


def expert_function(chain: Chain, form: str | None = None, jacobian: bool = False) -> ca.Function:
    """The recursion as a CasADi function of one vector (q, v, u), and of the runtime parameters where there are any.

    Args:
        chain: The chain.
        form: One of ``recursions.forms``; the likely best by default.
        jacobian: d a/d q and d a/d v instead of a, dense and row-major.
    """
    form = form or recursions.forms(chain)[0]
    x, p = ca.SX.sym("x", chain.width), ca.SX.sym("p", 3 * chain.links if chain.runtime else 0)
    row, n = ca.vertsplit(x), chain.links
    numbers = _Symbols(*([p[i * n + k] for k in range(n)] for i in range(3))) if chain.runtime else None
    q, v, u = row[: chain.nq], row[chain.nq : chain.nq + chain.nv], row[chain.nq + chain.nv :]
    a = ca.vertcat(*recursions.accelerations(chain, form, q, v, u, ca.sin, ca.cos, numbers))
    if not jacobian:
        return ca.Function("expert", [x, p], [a])
    matrix = ca.densify(ca.jacobian(a, x))
    # CasADi stores by columns, so the transposed matrix is row-major
    outputs = [matrix[:, : chain.nq].T, matrix[:, chain.nq : chain.nq + chain.nv].T]
    return ca.Function("expert", [x, p], ca.cse(outputs))


def build(
    chain: Chain, folder: Path, form: str | None = None, slp: bool = True, jacobian: bool = False, seconds: float = 120.0
) -> Candidate:
    """Emits and compiles the expert's function; gcc's superword vectoriser (``slp``) often harms it.

    Raises:
        BenchmarkError: The compiler failed, or took longer than `seconds`.
    """
    form = form or recursions.forms(chain)[0]
    what = "CasADi, Jacobian of its C" if jacobian else "CasADi, emitted C"
    name = what + recursions.LABELS[form] + ("" if slp else ", no slp")
    source = folder / (name.replace(" ", "_").replace(",", "").replace("^", "") + ".c")
    generator = ca.CodeGenerator("expert.c")
    generator.add(expert_function(chain, form, jacobian))
    outputs = f"out, out + {chain.nv * chain.nq}" if jacobian else "out"
    source.write_text(generator.dump() + _WRAPPER.format(inputs="state, p", outputs=outputs))
    extra = ("-fno-semantic-interposition", *(() if slp else ("-fno-tree-slp-vectorize",)))
    library = compile_shared(source, source.with_suffix(".so"), "gnu99", extra, seconds)
    return Candidate(name, library, "peer_function", kind="hybrid" if form in recursions.HYBRID else "peer")


def seconds_to_callable(chain: Chain, folder: Path) -> float:
    """Description to compiled shared object, seconds."""
    start = time.perf_counter()
    build(chain, folder)
    return time.perf_counter() - start
