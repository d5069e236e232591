"""CasADi: an expert's O(N) recursion in SX, emitted as C and compiled with the flags of our own code.

CasADi's generated entry takes arrays of pointers and tests each for NULL at every read. The wrapper below hands
it pointers that the compiler can see are not NULL, as an expert who cares for speed would, and the compiler is
allowed to inline the entry into it: the tests vanish, and up to a third of the time with them.
"""

from __future__ import annotations

import time
from pathlib import Path

import casadi as ca

from benchmarks.chains import Chain
from benchmarks.harness import Candidate, compile_shared
from benchmarks.peers import recursions

VERSION = ca.CasadiMeta.version()
_WRAPPER = """
__attribute__((nonnull)) void peer_forward_dynamics({arguments}, double *restrict a)
{{
    const double *arg[] = {{{inputs}}};
    double *res[] = {{a}};
    expert(arg, res, 0, 0, 0);
}}
"""


def expert_function(chain: Chain, form: str = "tension") -> ca.Function:
    """The recursion as a CasADi function ``(q, v, [u]) -> a``."""
    q, v, u = ca.SX.sym("q", chain.nq), ca.SX.sym("v", chain.nv), ca.SX.sym("u", chain.nu)
    parts = ca.vertsplit(q), ca.vertsplit(v), ca.vertsplit(u) if chain.nu else []
    if chain.space == "planar":
        outputs = recursions.planar_link_frame(chain, *parts, ca.sin, ca.cos)
    else:
        outputs = recursions.SPATIAL[form](chain, *parts)
    return ca.Function("expert", [q, v, u] if chain.nu else [q, v], [ca.vertcat(*outputs)])


def build(chain: Chain, folder: Path, form: str = "tension", slp: bool = True) -> Candidate:
    """Emits and compiles the expert's function; gcc's superword vectoriser (``slp``) often harms it."""
    name = "CasADi, emitted C" + (recursions.LABELS[form] if chain.space == "spatial" else "") + ("" if slp else ", no slp")
    source = folder / (name.replace(" ", "_").replace(",", "").replace("^", "") + ".c")
    generator = ca.CodeGenerator("expert.c")
    generator.add(expert_function(chain, form))
    inputs = ["q", "v", "u"] if chain.nu else ["q", "v"]
    arguments = ", ".join(f"const double *restrict {x}" for x in inputs)
    source.write_text(generator.dump() + _WRAPPER.format(arguments=arguments, inputs=", ".join(inputs)))
    extra = ("-fno-semantic-interposition", *(() if slp else ("-fno-tree-slp-vectorize",)))
    library = compile_shared(source, source.with_suffix(".so"), "gnu99", extra)
    return Candidate(name, library, "peer_forward_dynamics", kind="hybrid" if form == "twisted" else "peer")


def seconds_to_callable(chain: Chain, folder: Path) -> float:
    """Description to compiled shared object, seconds."""
    start = time.perf_counter()
    build(chain, folder)
    return time.perf_counter() - start
