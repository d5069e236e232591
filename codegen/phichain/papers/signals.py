"""Signal propagation of any planar scene, from its file to pictures: what `phichain propagation` draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import UnsupportedError
from phichain.files import write_file
from phichain.fractional import Propagation, propagation
from phichain.motion import simulate
from phichain.pipeline import build
from phichain.report.signals.propagation import paths, surfaces
from phichain.report.signals.viewer import viewer
from phichain.report.style import save
from phichain.scene import Scene, scene_from_dict
from phichain.system import Parameters, System
from phichain.system.starts import leaning

Vector = NDArray[np.float64]

P, ALPHA = np.linspace(0.0, 1.0, 31), np.linspace(-2.0, 0.0, 61)
SAMPLES = 4001
_WANTED = ("forward_dynamics", "coriolis", "gravity_torque", "energy")


def signal_system(scene: Scene, params: Parameters | None = None) -> System:
    """A planar scene compiled in double precision with the functions that its signals need.

    Args:
        scene: The chain; what else it wants is left out.
        params: Values of its runtime parameters.

    Raises:
        UnsupportedError: The scene is spatial.
    """
    if not scene.is_planar:
        raise UnsupportedError(
            "space",
            "spatial",
            "has no signal propagation: omega' has no second integral that is q",
            "use a planar scene",
        )
    wanted = scene.to_dict()
    wanted["functions"] = {"want": list(_WANTED)}
    wanted["target"] = {**wanted.get("target", {}), "real": "double"}
    system = build(scene_from_dict(wanted))
    return system if params is None else replace(system, params=params)


def released(
    system: System,
    seconds: float,
    samples: int = SAMPLES,
    order: int = 4,
    *,
    lean: float = 0.5,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    u: ArrayLike | None = None,
) -> Propagation:
    """The signals of a chain that is released and left to a constant input.

    Args:
        system: From `signal_system`.
        seconds: How long, s.
        samples: Samples of the motion.
        order: Order of the quadrature, 1 to 6.
        lean: Angle of the straight chain from the vertical at rest, rad, where q and v are not given.
        q: Configuration at the start (nq,).
        v: Rates at the start (nv,).
        u: Constant input (nu,).
    """
    rest = leaning(system, lean)
    start = [given if given is not None else default for given, default in zip((q, v), rest, strict=True)]
    motion = simulate(system, (start[0], start[1]), np.linspace(0.0, seconds, samples), tol=1e-11, u=u)
    parts = ["total", "coriolis", "gravity", "feedback"]
    if system.nu and motion.u is not None and np.any(motion.u):
        parts.append("input")
    if not system.joints.is_free:
        parts.append("joints")
    return propagation(system, motion, P, ALPHA, paths=parts, order=order)


def write_sheets(
    stem: str, mark: str, title: str, result: Propagation, out: Path, coordinates: int | None = None
) -> list[Path]:
    """The two sheets of one chain: STEM+MARK.png with the surfaces, STEM_feedback+MARK.png with the paths.

    The surfaces show as many coordinates as given, the paths all.
    """
    sheets = {
        f"{stem}{mark}.png": surfaces(result, f"{title}: from forces to angles", coordinates),
        f"{stem}_feedback{mark}.png": paths(result, f"{title}: the feedback path, part by part"),
    }
    return [save(sheet, out / name, of=result) for name, sheet in sheets.items()]


def write_viewer(name: str, title: str, lead: str, results: Mapping[str, Propagation], out: Path) -> Path:
    """The interactive page of one or more chains."""
    return write_file(out / f"{name}.html", viewer(title, lead, results))


def draw_signals(scene: Scene, result: Propagation, out: Path) -> list[Path]:
    """Both sheets and the page of a scene's signals; returns the files written.

    Raises:
        OutputError: The folder cannot be written.
    """
    stem = f"{scene.name}_propagation"
    lead = f"{scene.links} link(s), {scene.base} base, {scene.angles} angles; {result}."
    page = write_viewer(stem, f"Signal propagation: {scene.name}", lead, {scene.name: result}, out)
    return [*write_sheets(stem, "", scene.name, result, out), page]
