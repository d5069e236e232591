"""The command `phichain trace`: a family of limit cycles followed, written, interrupted and gone on with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app import said
from phichain.app.commands.orbits.options import (
    Harmonic,
    MaxPoints,
    OutFiles,
    SceneWord,
    StepMax,
    clear_line,
    in_double,
    leave,
    limits_of,
    progress_line,
)
from phichain.app.outputs import figures, named, write
from phichain.app.settings import Settings, with_values

if TYPE_CHECKING:
    from phichain.scene import Scene


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(trace)


def trace(
    scene: SceneWord,
    mode: Annotated[int, typer.Option(help="Mode to start from, from 1, by rising linear frequency; where a conical family begins.")] = 1,
    method: Annotated[
        str, typer.Option(
            help='"shooting" (whole orbits, with their stability), "harmonics" (Fourier series), "one harmonic", "conical" (a spatial chain '
            'turning about the vertical), "in a plane" (one swinging), "whirling" (one that comes back turned, from --start), "in space" (one at rest off any plane) and "unmirrored" (one without a reversal), from --start too, or auto: shooting '
            "or conical where they serve."
        ),
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
    switch: Annotated[
        bool, typer.Option("--switch", help="Follow the branches that events open, too: a network, written to .json or drawn as .png.")
    ] = False,
    generations: Annotated[
        int, typer.Option(min=1, help="How far from the first branch --switch goes: 2 follows what opens on what opens.")
    ] = 1,
    start: Annotated[
        str | None,
        typer.Option(
            metavar="ORBIT",
            help='Start from an orbit instead of a mode: FILE.json or FILE.json:POINT of a family (points and events count from 1), or "q=1,0.2; v=0,0; period=1.7"; a whirling '
            "family from a conical one or one in a plane, or FILE.json:event=K of it.",
        ),
    ] = None,
    hold: Annotated[
        str | None, typer.Option(metavar="WHAT", help="What a whirling family holds: momentum (unless given), energy or turn.")
    ] = None,
    harmonics: Harmonic = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="FILE.json", help="Go on with what an earlier run left.")
    ] = None,
    step_max: StepMax = None,
    max_points: MaxPoints = None,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Follow a family of limit cycles, or a conical family, from small amplitudes; Ctrl-C ends it, and what there is can be gone on with."""
    from phichain.orbits import trace as traced
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene

    files = named(out, (".json", ".png") if switch else (".json", ".csv", ".npz", ".png"))
    chosen = find_scene(scene)
    system = built(carrying(in_double(chosen, quiet), method, switch or start is not None))
    # The file is to name the scene that was given, whatever functions this command needed of it besides.
    system = replace(system, digest=chosen.digest)
    system = with_values(system, chosen, settings)
    # A conical family goes on to where its links lie flat.
    turns = not system.is_planar and method != "in a plane"
    is_free = until is not None or amplitude_max is not None or start is not None or turns
    branch = traced(
        system, mode, amplitude_max if is_free else 3.0, method=method, until=until, through=through, switch=switch, resume=resume,
        limits=limits_of(step_max, max_points),
        generations=generations, start=start, hold=hold, harmonics=harmonics,
        progress=progress_line(quiet),
    )  # fmt: skip
    clear_line()
    said.say(branch, quiet, as_json)
    write(branch, files, lambda: _drawn(branch), quiet=quiet or as_json)
    leave(branch.status)


def _drawn(found: Any) -> Any:
    """A family, or a network, drawn."""
    from phichain.orbits import Network

    if isinstance(found, Network):
        from phichain.report.orbits import plane

        return plane.network(found)
    return figures().family(found)


def carrying(scene: Scene, method: str = "shooting", beyond: bool = False) -> Scene:
    """The same chain with the functions that the method calls, its flow carrying derivatives along where that shoots.

    Args:
        scene: The scene.
        method: The method.
        beyond: Whether orbits without the symmetries of brake orbits are to be followed.
    """
    from phichain.orbits import conical, in_plane, shooting
    from phichain.orbits.harmonics import family
    from phichain.scene.load import with_functions

    turns = scene.space == "spatial" and method in ("auto", "conical") and scene.damping is None
    shoots = scene.space == "planar" and method in ("auto", "shooting", "harmonics") and scene.damping is None
    swings = scene.space == "spatial" and method in ("in a plane", "whirling", "in space", "unmirrored") and scene.damping is None
    needed = {*(conical.NEEDED if turns else in_plane.NEEDED if swings else shooting.NEEDED if shoots else ())}
    if shoots:
        needed |= {*(family.NEEDED if method == "harmonics" else ()), *(("forward_dynamics",) if beyond else ())}
    if needed <= {*scene.want} and (scene.variational or not (shoots or swings)):
        return scene
    return with_functions(scene, needed, variational=shoots or swings)
