"""An FMU of a scene: its C with FMI 3.0 around it, described, compiled for this machine, in one file."""

from __future__ import annotations

import io
import platform
import sys
import zipfile
from os import PathLike, fspath
from pathlib import Path
from typing import Final

from phichain.emit.fmu.description import build_description, model_description
from phichain.emit.fmu.source import flow_of, fmu_source
from phichain.errors import OutputError
from phichain.files import write_file
from phichain.native import CompilerOptions, default_cache
from phichain.native.library import shared_object
from phichain.scene import Scene, given_scene
from phichain.scene.load import with_functions
from phichain.scratch import library_texts

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""The time of every entry: the same scene is the same file."""
_ARCHITECTURES: Final = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}
_SYSTEMS: Final = {"linux": ("linux", "so"), "darwin": ("darwin", "dylib")}


def write_fmu(scene: Scene, out: str | PathLike[str] | None = None, prove: bool = True) -> Path:
    """Write a scene as an FMU of FMI 3.0, for Model Exchange and, on its own flow, for Co-Simulation.

    States are q and v, inputs u, parameters those of run time, outputs the states and, where the scene wants `energy`, both
    energies. In Co-Simulation inputs are held from one communication point to the next, and the emitted flow takes steps of its own in between:
    at round-off, or the tolerance that the importer names. Its C comes along, for machines of other kinds.

    Args:
        scene: The scene.
        out: The file; NAME.fmu unless given.
        prove: Prove the functions against the Lagrangian first.

    Returns:
        The file.

    Raises:
        OutputError: The file is not called .fmu, or cannot be written.
        CompilerError: The C compiler is missing or failed.
    """
    scene = given_scene(scene)
    path = Path(f"{scene.name}.fmu" if out is None else fspath(out))
    if path.suffix != ".fmu":
        raise OutputError("out", str(path), "has no suffix that says what to write", "name it .fmu")
    wanted = with_functions(scene, ("forward_dynamics", flow_of(scene)))
    texts = library_texts(wanted, prove, default_cache())
    sources = {name: texts[name] for name in (f"{scene.name}.c", f"{scene.name}.h")} | {"fmu.c": fmu_source(wanted)}
    options = CompilerOptions().portable()
    library = shared_object(scene.name, {name: text.encode() for name, text in sources.items()}, default_cache(), options)
    entries: dict[str, bytes] = {"modelDescription.xml": model_description(wanted, True).encode()}
    entries |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    entries |= {"sources/buildDescription.xml": build_description(wanted).encode(), "documentation/scene.toml": wanted.to_toml().encode()}
    entries[f"binaries/{platform_tuple()}/{scene.name}.{_SYSTEMS.get(sys.platform, ('', 'so'))[1]}"] = library.read_bytes()
    return write_file(path, _zipped(entries))


def platform_tuple() -> str:
    """What FMI calls this machine, such as x86_64-linux."""
    machine = platform.machine().lower()
    return f"{_ARCHITECTURES.get(machine, machine)}-{_SYSTEMS.get(sys.platform, (sys.platform, ''))[0]}"


def _zipped(entries: dict[str, bytes]) -> bytes:
    """An archive without times and owners."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(entries.items()):
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()
