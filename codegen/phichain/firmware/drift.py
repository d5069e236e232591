"""A generated folder against what would be generated now: whether it has drifted, and whether somebody edited it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from phichain.errors import OutputError
from phichain.files import LARGEST_MANIFEST, MANIFEST
from phichain.reading import parse_json, read_regular


@dataclass(frozen=True)
class Drift:
    """How a folder differs from what would be written into it.

    Attributes:
        missing: files that are not there.
        edited: files that are not what the folder's own manifest says was generated.
        outdated: files as they were generated, but not as they would be now.
    """

    missing: tuple[str, ...]
    edited: tuple[str, ...]
    outdated: tuple[str, ...]

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(self.missing or self.edited or self.outdated)

    def __str__(self) -> str:
        """One line a kind, or that there is none."""
        kinds = (("missing", self.missing), ("edited by hand", self.edited), ("out of date", self.outdated))
        return "\n".join(f"{kind}: {', '.join(names)}" for kind, names in kinds if names) or "up to date"


def drift(folder: Path, texts: Mapping[str, str], digest: str) -> Drift:
    """Compare a folder with the texts that would be written.

    Args:
        folder: DIR/NAME.
        texts: what `generate` would write, by file name.
        digest: that of the scene.

    Raises:
        OutputError: the folder holds another scene, or no manifest of ours, or a file of it cannot be read.
    """
    if not folder.exists():
        return Drift(tuple(sorted(texts)), (), ())
    recorded = _manifest(folder)
    if recorded.get("digest") != digest:
        raise OutputError(
            "check", str(folder), "holds another scene, or another version of this one, of the digest"
            f" {str(recorded.get('digest'))[:16]}", f"check it with its own scene file, or generate the scene {digest[:16]} into it",
        )  # fmt: skip
    edited = set(edited_files(folder))
    found = {name: _content(folder / name) for name in texts}
    return Drift(
        tuple(sorted(name for name, content in found.items() if content is None)),
        tuple(sorted(edited & set(texts))),
        tuple(sorted(name for name, content in found.items() if content not in (None, texts[name].encode()) and name not in edited)),
    )  # fmt: skip


def edited_files(folder: Path) -> tuple[str, ...]:
    """Files of a generated folder that are not what its manifest says was generated; none where there is no such folder."""
    if not (folder / MANIFEST).exists():
        return ()
    hashes = _manifest(folder).get("files")
    recorded = hashes if isinstance(hashes, dict) else {}
    return tuple(
        sorted(name for name, value in recorded.items() if (content := _content(folder / name)) is not None and value != _hash(content))
    )


def _hash(content: bytes) -> str:
    return "sha256:" + hashlib.sha256(content).hexdigest()


def _content(path: Path) -> bytes | None:
    """A file's content; None where there is none.

    Raises:
        OutputError: It cannot be read.
    """
    try:
        return read_regular(path, LARGEST_MANIFEST)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError("check", str(path), f"cannot be read, {error.strerror}", "remove it and generate again") from error


def _manifest(folder: Path) -> dict[str, Any]:
    """The folder's manifest.

    Raises:
        OutputError: There is none, or it is no JSON object.
    """
    content = _content(folder / MANIFEST)
    try:
        found = parse_json(content) if content is not None else None
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise OutputError("check", str(folder), "has no manifest.json of ours", "give the folder that generate wrote")
    return found
