"""Our own code as a candidate: generate, wrap into the common signature, compile with the common flags."""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.chains import Chain, scene_table
from benchmarks.harness import Candidate, compile_shared

#: What phichain's own build adds to the common flags; peers get the better of with and without it. The other one
#: lets the wrapper become the function itself, as in the peers.
_OWN_FLAGS = ("-fno-tree-slp-vectorize", "-fno-semantic-interposition")
_WRAPPER = """#include "{source}"

void bench_{name}(double *out, const double *state, const double *parameters, const double *time)
{{
    (void)parameters, (void)time;
    {symbol}({arguments});
}}
"""


def generate(
    chain: Chain, folder: Path, code: str = "auto", want: tuple[str, ...] = ("forward_dynamics",)
) -> Path:
    """Generates the chain's folder; returns it."""
    from phichain import generate as phichain_generate
    from phichain.scene import scene_from_dict

    return Path(phichain_generate(scene_from_dict(scene_table(chain, want, code)), folder))


def manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a generated folder."""
    content: dict[str, Any] = json.loads((folder / "manifest.json").read_text())
    return content


def source(folder: Path) -> Path:
    """The C file of a generated folder."""
    return folder / f"{manifest(folder)['name']}.c"


def wrapped(generated: Path, function: str, name: str, folder: Path) -> Candidate:
    """One function of a generated folder as ``f(out, state, parameters, time)``; its outputs one after the other."""
    entry = manifest(generated)["functions"][function]
    arguments, at = [], 0
    if entry["params"]:
        arguments.append(f"(const {manifest(generated)['name']}_params *)parameters")
    for argument in entry["inputs"]:
        arguments.append(f"state + {at}")
        at += math.prod(argument["shape"])
    at = 0
    for argument in entry["outputs"]:
        arguments.append(f"out + {at}")
        at += math.prod(argument["shape"])
    text = _WRAPPER.format(
        source=source(generated), name=function, symbol=entry["symbol"], arguments=", ".join(arguments)
    )
    return from_c(text, f"bench_{function}", name, folder)


def from_c(text: str, symbol: str, name: str, folder: Path) -> Candidate:
    """Any C text that defines ``symbol(out, state, parameters, time)``."""
    scratch = Path(tempfile.mkdtemp(dir=folder))
    path = scratch / "candidate.c"
    path.write_text(text)
    return Candidate(name, compile_shared(path, scratch / "candidate.so", extra=_OWN_FLAGS), symbol, kind="ours")


def build(chain: Chain, folder: Path, code: str = "auto", function: str = "forward_dynamics") -> Candidate:
    """phichain's function of the chain."""
    generated = generate(chain, folder / f"{code}_{function}", code, (function,))
    form = manifest(generated)["functions"][function].get("code", code)
    return wrapped(generated, function, f"phichain ({form})", folder)


_PREPARED = """#include "{source}"

static {name}_prepared prepared;
static const double *of;

void bench_prepared(double *out, const double *state, const double *parameters, const double *time)
{{
    (void)time;
    if (parameters != of) {{ /* at the first call alone: the rest goes on from there */
        {name}_prepare((const {name}_params *)parameters, &prepared);
        of = parameters;
    }}
    {name}_forward_dynamics_prepared(&prepared, state, state + {links}, out);
}}
"""


def build_prepared(chain: Chain, folder: Path) -> Candidate:
    """phichain's forward dynamics of an unforced chain whose runtime parameters stay: what they determine is kept."""
    generated = generate(chain, folder / "prepared", want=("forward_dynamics", "prepare"))
    text = _PREPARED.format(source=source(generated), name=manifest(generated)["name"], links=chain.links)
    return from_c(text, "bench_prepared", "phichain (prepared)", folder)


def operations(folder: Path, function: str = "forward_dynamics") -> int:
    """Operations of one function as the manifest counts them: + - * / sqrt one each, sin and cos one each."""
    counts = manifest(folder)["functions"][function]["operations"]
    if isinstance(counts, dict):
        return int(counts["total"]) if "total" in counts else sum(int(n) for n in counts.values())
    return int(counts)
