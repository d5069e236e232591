"""Packages by the ecosystems' own tools (PlatformIO's; CMake for the M4F)."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.tools import run
from phichain.files import write_folder
from phichain.firmware.packages import packaged


def packages(folders: Mapping[str, Generated]) -> Iterator[str]:
    """Packages: PlatformIO packs one, CMake builds one with the M4F's compiler and installs it."""
    made = folders["fw_planar4_libm"]
    texts = product(made)
    root = made.folder.parent
    pio = write_folder(root / "packages" / "platformio", packaged("platformio", texts))
    done = subprocess.run(
        [Path(sys.executable).parent / "pio", "pkg", "pack", "-o", root / "library.tar.gz", "."], cwd=pio, capture_output=True, text=True,
        check=False, env={**os.environ, "PLATFORMIO_CORE_DIR": str(root / "pio")},
    )  # fmt: skip
    if done.returncode or not (root / "library.tar.gz").exists():
        yield f"PlatformIO refuses the package: {(done.stdout + done.stderr)[-400:]}"
    cmake = write_folder(root / "packages" / "cmake", packaged("cmake", texts))
    run(
        "cmake", "-S", cmake, "-B", root / "built", "-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_C_COMPILER=arm-none-eabi-gcc",
        "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY", "-DCMAKE_C_FLAGS=-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16",
        f"-DCMAKE_INSTALL_PREFIX={root / 'installed'}",
    )  # fmt: skip
    run("cmake", "--build", root / "built", "--target", made.scene.name)
    run("cmake", "--install", root / "built", expected=(0, 1))
    if not list((root / "built").rglob(f"lib{made.scene.name}.a")):
        yield "CMake built no library for the M4F"


def product(made: Generated) -> dict[str, str]:
    """The files that `phichain generate` wrote, without what the checks have put beside them."""
    files = [path for path in made.folder.iterdir() if path.name in _PRODUCT or path.stem == made.scene.name]
    return {path.name: path.read_text() for path in files if path.suffix in (".c", ".h", ".json", ".md")}


_PRODUCT = {"selftest.c", "README.md", "manifest.json"}
