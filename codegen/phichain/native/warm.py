"""What a proven build wrote, kept under the scene's digest and the generator, so that no other build writes it again.

The cache is not believed: what comes from it is a manifest that its own scene, contract, header and hashes bear out, of the very
scene that was asked for, every function of which was proven; anything else is dropped and made anew.
"""

from __future__ import annotations

import hashlib
import json
import warnings
import zlib
from collections.abc import Mapping
from typing import Final

from phichain.errors import PhichainError
from phichain.files import MANIFEST
from phichain.identity import generator
from phichain.native.agreement import demand_agreement
from phichain.native.cache import Cache, CacheWarning
from phichain.native.signature import manifest_of
from phichain.reading import MEBIBYTE, parse_json
from phichain.scene import Scene

_FORMAT: Final = "phichain texts 1"
_LARGEST: Final = 1024 * MEBIBYTE


def texts_key(scene: Scene) -> str:
    """Under which key the cache keeps the texts of a scene."""
    return hashlib.sha256(f"{_FORMAT} {generator()} {scene.digest}".encode()).hexdigest()


def remember(scene: Scene, texts: Mapping[str, str], cache: Cache) -> None:
    """Keep the texts of a proven build.

    Raises:
        CacheError: The cache's folder is not the owner's alone.
        OutputError: The disk is full.
    """
    key = texts_key(scene)
    cache.store(key, key.encode() + zlib.compress(json.dumps(dict(texts)).encode()))


def recalled(scene: Scene, cache: Cache) -> dict[str, str] | None:
    """The texts of a scene as a proven build wrote them, or None where they have to be written.

    Warns:
        CacheWarning: What stood there was not that; it is gone now.

    Raises:
        CacheError: The cache's folder is not the owner's alone.
    """
    key = texts_key(scene)
    stored = cache.fetch(key)
    if stored is None:
        return None
    try:
        return _checked(scene, _unpacked(stored.removeprefix(key.encode())))
    except (PhichainError, ValueError, zlib.error) as fault:
        cache.drop(key)
        problem = f"dropped the cache's texts of {scene.name} ({fault}); they are written again"
        warnings.warn(problem, CacheWarning, stacklevel=3)
        return None


def _unpacked(packed: bytes) -> dict[str, str]:
    """The texts by file name.

    Raises:
        ValueError: They are none.
    """
    text = zlib.decompressobj().decompress(packed, _LARGEST)
    match parse_json(text):
        case dict(texts) if all(isinstance(content, str) for content in texts.values()):
            return texts
    raise ValueError("it holds no texts by file name")


def _checked(scene: Scene, texts: dict[str, str]) -> dict[str, str]:
    """The same, borne out.

    Raises:
        OutputError: Scene, contract, header or hashes say something else.
        ValueError: It is of another scene, or not proven whole.
    """
    manifest = manifest_of({name: text.encode() for name, text in texts.items()})
    demand_agreement(manifest)
    if manifest.digest != scene.digest:
        raise ValueError("it is of another scene")
    for name in manifest.files:
        manifest.source(name)
    proof = parse_json(texts[MANIFEST]).get("proof")
    if not isinstance(proof, dict) or not set(scene.want) <= proof.keys() or not all(isinstance(how, str) for how in proof.values()):
        raise ValueError("it does not say how its functions were proven")
    return texts
