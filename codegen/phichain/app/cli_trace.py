"""The command `phichain trace`: a family of limit cycles followed, written, interrupted and gone on with."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app.outputs import figures, named, write

if TYPE_CHECKING:
    from phichain.continuation import Point
    from phichain.scene import Scene

_TICK = 0.1
"""Seconds between two states of the progress line."""
_CLEAR = "\r\x1b[K"
"""What wipes a line of a terminal."""
_INTERRUPTED = 130
"""Exit code of what Ctrl-C ended."""
SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links.")
]
OutFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--out", "-o", metavar="FILE",
        help="Write the family: .json (to go on with), .csv, .npz or .png by its name; repeatable.",
    ),
]  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(trace)


def trace(
    scene: SceneWord,
    mode: Annotated[int, typer.Option(min=1, help="Mode to start from, by rising linear frequency.")] = 1,
    method: Annotated[
        str, typer.Option(help='"shooting" (whole orbits, with their stability), "one harmonic", or auto: shooting where it serves.')
    ] = "auto",
    until: Annotated[
        str | None,
        typer.Option(metavar="WHAT=VALUE", help="End exactly there: theta_K (of the start), amplitude (the largest), omega or energy."),
    ] = None,
    amplitude_max: Annotated[
        float | None, typer.Option(metavar="RAD", help="The same as --until amplitude=RAD; 3 unless --until is given.")
    ] = None,
    through: Annotated[
        float | None, typer.Option(metavar="WIDTH", help="Cross gaps up to this half width, in arclength, instead of turning.")
    ] = None,
    switch: Annotated[bool, typer.Option("--switch", help="Follow the branches that events open, too.")] = False,
    resume: Annotated[
        Path | None, typer.Option(metavar="FILE.json", help="Go on with what an earlier run left.")
    ] = None,
    step_max: Annotated[float | None, typer.Option(metavar="S", help="Largest step, in arclength.")] = None,
    max_points: Annotated[int | None, typer.Option(help="Points after which the run ends.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter's values; repeatable.")
    ] = None,
    out: OutFiles = None,
) -> None:
    """Follow a family of limit cycles from small amplitudes; Ctrl-C ends it, and what there is can be gone on with."""
    from phichain.orbits import trace as traced
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene
    from phichain.system.starts import parameters

    files = named(out, (".json", ".csv", ".npz", ".png"))
    chosen = find_scene(scene)
    system = built(carrying(chosen) if _shoots(chosen, method) else chosen)
    # The file is to name the scene that was given, whatever functions this command needed of it besides.
    system = replace(system, digest=chosen.digest)
    if (values := parameters(settings or [])) is not None:
        system = replace(system, params=values)
    end = 3.0 if until is None and amplitude_max is None else amplitude_max
    steps = {name: value for name, value in (("step_max", step_max), ("max_points", max_points)) if value is not None}
    branch = traced(
        system, mode, end, method=method, until=until, through=through, switch=switch, resume=resume, limits=steps,
        progress=progress_line(system.cart_size),
    )  # fmt: skip
    if sys.stderr.isatty():
        sys.stderr.write(_CLEAR)
    typer.echo(str(branch))
    write(branch, files, lambda: figures().family(branch))
    if branch.status == "interrupted":
        raise typer.Exit(_INTERRUPTED)


def carrying(scene: Scene) -> Scene:
    """The same chain with the functions that shooting calls, its flow carrying derivatives along."""
    from phichain.orbits.shooting import NEEDED
    from phichain.scene.load import with_functions

    return with_functions(scene, NEEDED, variational=True)


def _shoots(scene: Scene, method: str) -> bool:
    """Whether the method needs more than the scene wants of itself."""
    from phichain.orbits.shooting import NEEDED

    serves = scene.space == "planar" and scene.real == "double" and scene.damping is None
    has_all = scene.variational and {*NEEDED} <= {*scene.want}
    return serves and not has_all and method in ("auto", "shooting")


def progress_line(carts: int) -> Callable[[Point, float], None] | None:
    """A line that tells how far a run is, on a terminal only."""
    if not sys.stderr.isatty():
        return None
    told: dict[str, Any] = {"last": 0.0, "points": 0}

    def tell(point: Point, step: float) -> None:
        told["points"] += 1
        if (now := time.monotonic()) - told["last"] < _TICK:
            return
        told["last"] = now
        angles = point.y[carts:-1]
        largest = max(abs(angle) for angle in angles)
        line = f"{told['points']} points, amplitude {largest:.4f} rad, arclength {point.arclength:.4f}, step {step:.2g}"
        sys.stderr.write(f"{_CLEAR}{line}")
        sys.stderr.flush()

    return tell
