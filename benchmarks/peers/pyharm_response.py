"""One driven link in pyHarm: its mass and damper as a substructure, its weight as an element of its own, full Fourier series."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
from pyHarm.Elements.NodeToNodeElements.GeneralOrderElement import GeneralOrderElement
from pyHarm.Maestro import Maestro

from benchmarks.peers.harmonics_numpy import Link


class Weight(GeneralOrderElement):
    """k sin(theta) between a node and the ground, by alternating frequency-time with an exact Jacobian."""

    factory_keyword = "Weight"

    def __post_init__(self) -> None:
        self.dto, self.xo, self.k = 0, 3, self.data["k"]
        self.nabo = np.linalg.matrix_power(self.nabla, 0)
        self.flag_elemtype = -1

    def _evalResidual(self, x: Any, om: float) -> Any:
        pick = self.Pslave - self.Pmaster
        theta = (self.Pdir[0] @ pick @ x) @ self.D["ft"]
        return pick.T @ self.Pdir[0].T @ (self.k * np.sin(theta) @ self.D["tf"])

    def _evalJacobian(self, x: Any, om: float) -> tuple[Any, Any]:
        pick = self.Pslave - self.Pmaster
        theta = (self.Pdir[0] @ pick @ x) @ self.D["ft"]
        slope = (self.D["ft"] @ ((self.k * np.cos(theta)).reshape(-1, 1) * self.D["tf"])).T
        return pick.T @ self.Pdir[0].T @ slope @ self.Pdir[0] @ pick, np.zeros(len(x))


def study(link: Link, highest: int, ends: tuple[float, float]) -> Maestro:
    """The frequency response between two frequencies, ready to be operated."""
    one = {"matrix": {"M": np.array([[link.inertia]]), "C": np.array([[link.damping]]), "K": np.zeros((1, 1))}, "ndofs": 1}
    logging.disable(logging.INFO)
    return Maestro({
        "plugin": [Weight],
        "system": {"type": "Base", "nh": highest, "nti": 4 * (highest + 1)},
        "substructures": {"link": one},
        "connectors": {
            "weight": {"type": "Weight", "connect": {"link": [0]}, "dirs": [0], "k": link.weight},
            "drive": {"type": "CosinusForcing", "connect": {"link": [0]}, "dirs": [0], "amp": link.drive},
        },
        "analysis": {
            "frf": {
                "study": "frf", "solver": "NewtonRaphson", "corrector": "pseudo_arc_length", "puls_inf": ends[0], "puls_sup": ends[1],
                "ds_max": 0.1, "ds_min": 1e-8, "ds0": 0.01, "verbose": False,
            }
        },
    })  # fmt: skip


def response(link: Link, highest: int, ends: tuple[float, float]) -> np.ndarray:
    """(omega, cosine, sine of the first harmonic) of every point that was accepted (m, 3)."""
    maestro = study(link, highest, ends)
    maestro.operate()
    accepted = [solution for solution in maestro.nls["frf"].SolList if solution.flag_accepted]
    return np.array([(solution.x[-1], solution.x[1], solution.x[2]) for solution in accepted])
