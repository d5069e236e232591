"""The whole path in a few lines: scene -> model -> programs -> texts -> folder -> compiled System."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from phichain._version import __version__
from phichain.emit import folder_files, library_files, with_proof
from phichain.files import MANIFEST, write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native import build_files, default_cache
from phichain.proof import prove as proven
from phichain.reading import parse_json
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
    files = library_files(scene, lowered)
    if not prove:
        return build_files(files)
    key, cache = _proof_key(scene, files), default_cache()
    kept = _kept(cache.fetch(key), key)
    record = dict(proven(lowered.model, lowered).record) if kept is None else kept
    system = build_files(files | {MANIFEST: with_proof(files[MANIFEST], record)})
    if kept is None:
        cache.store(key, json.dumps({"key": key, "proof": record}).encode())
    return system


def _kept(stored: bytes | None, key: str) -> dict[str, str] | None:
    """How each function was proven, as the cache holds it; None, to be proven again, where that is not what `build` stored."""
    try:
        match parse_json(stored or b"null"):
            case {"key": str(own), "proof": dict(proof)} if own == key and all(isinstance(how, str) for how in proof.values()):
                return proof
    except ValueError:
        pass
    return None


def _proof_key(scene: Scene, files: Mapping[str, str]) -> str:
    """Under which key the cache of compiled objects keeps how the functions of this very text were proven."""
    text = "\0".join((_PROOF, __version__, scene.digest, files[f"{scene.name}.c"]))
    return hashlib.sha256(text.encode()).hexdigest()


_PROOF = "phichain proof 1"
"""Changes when the proof does: what an older one let through is proven again."""
