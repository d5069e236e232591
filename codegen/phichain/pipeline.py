"""The whole path in a few lines: scene -> model -> programs -> texts -> folder -> compiled System."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from phichain._version import __version__
from phichain.emit import folder_files, library_files
from phichain.files import write_folder
from phichain.lowering import Lowered, lower
from phichain.mechanics import derive
from phichain.native import build_files, default_cache
from phichain.proof import prove as proven
from phichain.scene import Scene
from phichain.system import System


def generate(
    scene: Scene, out: Path | str = "generated", with_casadi_c: bool = False, prove: bool = True
) -> Path:
    """Write the standalone C and CasADi folder of a scene.

    Args:
        scene: what to generate.
        out: the folder in which NAME/ is written, whole or not at all.
        with_casadi_c: also write NAME_casadi.c for CasADi's ``external`` (double scenes only).
        prove: prove the Programs against the Lagrangian first; the manifest says which were proven, and how.

    Returns:
        The folder OUT/NAME.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        ProofError: a function does not meet the Lagrangian; nothing is written.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the scene does not fit its type.
    """
    lowered = lower(derive(scene))
    proof = proven(lowered.model, lowered).record if prove else None
    return write_folder(Path(out) / scene.name, folder_files(scene, lowered, with_casadi_c, proof))


def build(scene: Scene, prove: bool = True) -> System:
    """Derive, lower, prove, emit, compile (or find compiled) and load a scene.

    Args:
        scene: what to build.
        prove: prove the Programs against the Lagrangian, unless the cache holds that these were.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        ProofError: a function does not meet the Lagrangian; nothing is compiled.
        CompilerError: the C compiler is missing, failed or hung.
    """
    lowered = lower(derive(scene))
    return build_files(library_files(scene, lowered, _proof_once(lowered) if prove else None))


def _proof_once(lowered: Lowered) -> Mapping[str, str]:
    """How the Programs were proven: read from the cache of compiled objects, where these very Programs stand in it, or proven now.

    Raises:
        ProofError: a function does not meet the Lagrangian.
        CacheError: the cache's folder is not the owner's alone.
    """
    scene, cache = lowered.model.scene, default_cache()
    what = [_PROOF, __version__, scene.digest, repr(dict(lowered.wanted)), repr(dict(lowered.helpers))]
    key = hashlib.sha256("\0".join(what).encode()).hexdigest()
    stored = cache.fetch(key)
    if stored is not None:
        return dict(json.loads(stored)["proof"])
    record = dict(proven(lowered.model, lowered).record)
    cache.store(key, json.dumps({"key": key, "proof": record}).encode())
    return record


_PROOF = "phichain proof 1"
"""Changes when the proof does: what an older one let through is proven again."""
