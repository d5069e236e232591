"""The whole path in a few lines: scene -> model -> programs -> texts -> folder -> compiled System."""

from __future__ import annotations

import tempfile
from pathlib import Path

from phichain.emit import folder_files, library_files
from phichain.files import write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native import build_folder
from phichain.scene import Scene
from phichain.system import System


def generate(scene: Scene, out: Path | str = "generated", with_casadi_c: bool = False) -> Path:
    """Write the standalone C and CasADi folder of a scene.

    Args:
        scene: what to generate.
        out: the folder in which NAME/ is written, whole or not at all.
        with_casadi_c: also write NAME_casadi.c for CasADi's ``external`` (double scenes only).

    Returns:
        The folder OUT/NAME.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the scene does not fit its type.
    """
    files = folder_files(scene, lower(derive(scene)), with_casadi_c)
    return write_folder(Path(out) / scene.name, files)


def build(scene: Scene) -> System:
    """Derive, lower, emit, compile (or find compiled) and load a scene.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        CompilerError: the C compiler is missing, failed or hung.
    """
    files = library_files(scene, lower(derive(scene)))
    with tempfile.TemporaryDirectory(prefix="phichain-") as folder:
        return build_folder(write_folder(Path(folder) / scene.name, files))
