"""A world without peers: what a bench sees where nothing but phichain is installed."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from benchmarks.peers.present import PACKAGES


@pytest.fixture
def no_peers(monkeypatch: pytest.MonkeyPatch) -> None:
    """No peer can be imported, and no module of ours that has imported one is remembered."""
    for name in [*sys.modules]:
        top = name.split(".")[0]
        if top in PACKAGES or (name.removeprefix("benchmarks.peers.") in NEEDING):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [_Absent(tuple(sys.meta_path))])


class _Absent:
    """Finds everything but the peers. (None in sys.modules would do for ours, but SciPy looks there for JAX.)"""

    def __init__(self, finders: tuple[Any, ...]) -> None:
        self._finders = finders

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name.split(".")[0] in PACKAGES:
            return None
        found = (finder.find_spec(name, path, target) for finder in self._finders)
        return next((spec for spec in found if spec is not None), None)


NEEDING = {
    "casadi_flows", "casadi_motion", "casadi_recursion", "diffrax_flow", "heyoka.batch", "heyoka.cfunc", "heyoka.flows",
    "mujoco_forward", "pinocchio_aba",
}  # fmt: skip
"""Modules of benchmarks/peers that import their peer at once."""
