"""A scene from scratch: derived, lowered, proven and printed. Importing this costs SymPy; what is built already needs none of it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Protocol

from phichain._version import __version__
from phichain.emit import folder_files, library_files, with_proof
from phichain.files import MANIFEST
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.proof import prove as proven
from phichain.reading import parse_json
from phichain.scene import Scene


def folder_texts(scene: Scene, with_casadi_c: bool, prove: bool) -> dict[str, str]:
    """The texts of a scene's folder by file name; arguments and errors as in `pipeline.generate`."""
    lowered = lower(derive(scene))
    proof = proven(lowered.model, lowered).record if prove else None
    return folder_files(scene, lowered, with_casadi_c, proof)


class Kept(Protocol):
    """Where what was proven is kept."""

    def fetch(self, key: str) -> bytes | None: ...
    def store(self, key: str, payload: bytes) -> object: ...


def library_texts(scene: Scene, prove: bool, cache: Kept | None = None) -> dict[str, str]:
    """The texts that a System is compiled from by file name; arguments and errors as in `pipeline.build`.

    Args:
        scene: the scene.
        prove: whether its functions are proven.
        cache: where proofs are kept; None proves anew.
    """
    lowered = lower(derive(scene))
    files = library_files(scene, lowered)
    if not prove:
        return files
    key = _proof_key(scene, files)
    record = None if cache is None else _kept(cache.fetch(key), key)
    if record is None:
        record = dict(proven(lowered.model, lowered).record)
        if cache is not None:
            cache.store(key, json.dumps({"key": key, "proof": record}).encode())
    return files | {MANIFEST: with_proof(files[MANIFEST], record)}


def _kept(stored: bytes | None, key: str) -> dict[str, str] | None:
    """How each function was proven, as the cache holds it; None, to be proven again, where that is not what was stored."""
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
