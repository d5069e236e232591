"""Our own code as a candidate: generate, compile with the common flags, read the manifest."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.chains import Chain, scene_table
from benchmarks.harness import Candidate, compile_shared

#: What phichain's own build adds to the common flags; peers get the better of with and without it.
_OWN_FLAGS = ("-fno-tree-slp-vectorize",)


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


def candidate_from_c(path: Path, symbol: str, name: str, folder: Path) -> Candidate:
    """Any C file with ``symbol(q, v, [u,] a)``."""
    library = Path(tempfile.mkdtemp(dir=folder)) / "candidate.so"
    return Candidate(name, compile_shared(path, library, extra=_OWN_FLAGS), symbol, kind="ours")


def build(chain: Chain, folder: Path, code: str = "auto") -> Candidate:
    """phichain's forward dynamics of the chain."""
    generated = generate(chain, folder / code, code)
    entry = manifest(generated)["functions"]["forward_dynamics"]
    form = entry.get("code", code)
    return candidate_from_c(source(generated), entry["symbol"], f"phichain ({form})", folder)


def operations(folder: Path, function: str = "forward_dynamics") -> int:
    """Operations of one function as the manifest counts them: + - * / sqrt one each, sin and cos one each."""
    counts = manifest(folder)["functions"][function]["operations"]
    if isinstance(counts, dict):
        return int(counts["total"]) if "total" in counts else sum(int(n) for n in counts.values())
    return int(counts)
