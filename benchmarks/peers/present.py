"""Peers are optional: a bench without one says what to install and goes on."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Final

from benchmarks.harness import BenchmarkError

PACKAGES: Final = {
    "casadi": "casadi", "heyoka": "heyoka", "pinocchio": "pin", "cmeel": "pin", "mujoco": "mujoco", "jax": "jax",
    "diffrax": "diffrax", "pycaputo": "pycaputo", "differint": "differint", "control": "control",
    "pyHarm": "pyharm-os", "numba": "pyharm-os",
}  # fmt: skip
"""Import name -> name of the package that brings it."""


class PeerAbsent(BenchmarkError):
    """A peer is not installed.

    Attributes:
        package: What to install.
    """

    def __init__(self, package: str) -> None:
        super().__init__(f"{package} is not installed: pip install {package} (or 'phichain[bench]' for all peers)")
        self.package = package


def module(name: str) -> ModuleType:
    """Import a peer, or a module of ours that needs one.

    Raises:
        PeerAbsent: The peer is not installed.
    """
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        package = PACKAGES.get((missing.name or "").split(".")[0])
        if package is None:
            raise
        raise PeerAbsent(package) from missing
