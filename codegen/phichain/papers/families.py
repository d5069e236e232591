"""Families of orbits of paper A's chains, exact, and what becomes of its double pendulum in space: the figures E2 .. E4, G4, N2 and C2."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from phichain.continuation import Branch
from phichain.orbits import Network, conical_families, trace
from phichain.pipeline import build
from phichain.report.orbits import plane
from phichain.report.style import save
from phichain.scene import scene_from_dict
from phichain.system import System

FURTHEST = 3.0
"""Angle up to which families are followed, rad."""
_POINTS = 250
_THROUGH = 1e-4
"""Half width of gaps that are crossed: the one of four links' mode 1 at 0.336 rad, 5.5e-5."""


def shooting_chain(links: int) -> System:
    """Paper A's chain of N links without torques, with a flow that carries derivatives."""
    chain = {"links": links, "mass": 1 / links, "length": 1 / links, "com": 0.5 / links}
    want = ["propagate", "mass_matrix", "energy", "forward_dynamics"]
    return build(
        scene_from_dict(
            {"name": f"shot{links}", "chain": chain, "joints": {"actuated": "none"}, "functions": {"want": want}, "flow": {"variational": True}}
        )
    )


def exact_families(links: int) -> list[Branch]:
    """The families of all modes of paper A's chain by shooting, as far as 3 rad or 250 points."""
    system = shooting_chain(links)
    return [_family(system, mode, FURTHEST, through=_THROUGH, limits={"max_points": _POINTS}) for mode in range(1, links + 1)]


def _family(system: System, *words: Any, **more: Any) -> Branch:
    """One family, which `trace` gives where it does not switch."""
    found = trace(system, *words, **more)
    assert isinstance(found, Branch)
    return found


def energies(links: int) -> Callable[[Path], list[Path]]:
    """What draws frequency over energy of all modes into a folder."""

    def write(out: Path) -> list[Path]:
        title = f"N = {links}: the families of all modes (thick: stable)"
        found = exact_families(links)
        return [save(plane.energies(found, title), out / f"E{links}.png", of=found)]

    return write


def double_network() -> Network:
    """What opens along mode 1 of two links up to theta_1 = -2.5."""
    found = trace(shooting_chain(2), 1, until="theta_1=-2.5", switch=True, generations=1)
    assert isinstance(found, Network)
    return found


def network(out: Path) -> list[Path]:
    """Draw what opens along mode 1 of two links into a folder."""
    found = double_network()
    return [save(plane.network(found), out / "N2.png", of=found)]


def gap(out: Path) -> list[Path]:
    """Draw the first gap of four links' mode 1, followed and crossed, into a folder."""
    system = shooting_chain(4)
    turned = _family(system, 1, FURTHEST, limits={"max_points": 80})
    crossed = _family(system, 1, until="theta_1=0.36", through=_THROUGH)
    return [save(plane.gap(turned, crossed), out / "G4.png", of=[turned, crossed])]


def conical(out: Path) -> list[Path]:
    """Draw all relative equilibria of a double spherical pendulum, the second link twice as long, into a folder."""
    chain = {"links": 2, "space": "spatial", "mass": [1.0, 0.5], "length": [1.0, 2.0]}
    want = ["forward_dynamics", "state_jacobian", "energy", "mass_matrix"]
    system = build(scene_from_dict({"name": "double_spherical", "chain": chain, "functions": {"want": want}}))
    found = conical_families(system)
    return [save(plane.conical(found), out / "C2.png", of=found)]
