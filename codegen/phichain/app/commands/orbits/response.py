"""The command `phichain response`: amplitude of a driven chain against the forcing's frequency, through folds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from phichain.app import said
from phichain.app.commands.orbits.options import (
    Harmonic,
    MaxPoints,
    SceneWord,
    StepMax,
    clear_line,
    frequency,
    in_double,
    leave,
    limits_of,
    ticking,
)
from phichain.app.outputs import named, out_option, write
from phichain.app.settings import Settings, with_values

if TYPE_CHECKING:
    from phichain.scene import Scene


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(response)


def response(
    scene: SceneWord,
    amplitude: Annotated[
        float | None, typer.Option(metavar="A", help="A of A cos(omega t): N m at a joint, N on a cart, m/s^2 of a base.")
    ] = None,
    start: Annotated[float | None, typer.Option("--from", metavar="W", help="First frequency, rad/s.")] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="W", help="Last frequency, rad/s.")] = None,
    at: Annotated[
        str | None, typer.Option(metavar="PLACE", help="What is driven: a joint such as 1, cart or base; the scene's [forcing] unless given.")
    ] = None,
    axis: Annotated[int | None, typer.Option(help="Axis of a driven base: 1 horizontally, 2 down.")] = None,
    method: Annotated[str, typer.Option(help='"harmonics" (Fourier series), or "shooting" (over the period).')] = "harmonics",
    harmonics: Harmonic = None,
    beyond: Annotated[
        list[int] | None,
        typer.Option(metavar="K", help="Then follow what event K opens (lost symmetry, doubled period) instead; repeated, an event of that."),
    ] = None,
    resume: Annotated[Path | None, typer.Option(metavar="FILE.json", help="Go on with what an earlier run left.")] = None,
    step_max: StepMax = None,
    max_points: MaxPoints = None,
    settings: Settings = None,
    out: Annotated[list[Path] | None, out_option("Write the response: .json, .csv, .npz or .png by its name")] = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Follow the periodic motions under A cos(omega t) from one frequency to another, through folds, with their stability; Ctrl-C ends it, and it goes on."""
    from phichain.orbits.forced import respond
    from phichain.orbits.forced.forcing import amplitude_of, demand_planar, range_of
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene

    files = named(out, (".json", ".csv", ".npz", ".png"))
    chosen = find_scene(scene)
    ends = range_of(None if start is None or end is None else (start, end))
    size = amplitude_of(amplitude)
    demand_planar(chosen.name, chosen.space)
    place = int(at) if at is not None and at.isdecimal() else at
    system = built(driven(in_double(chosen, quiet), place, axis))
    # The file is to name the scene that was given, whatever functions this command needed of it besides.
    system = replace(system, digest=chosen.digest)
    system = with_values(system, chosen, settings)
    steps, progress = limits_of(step_max, max_points), ticking(frequency, quiet)
    found = respond(
        system, place, size, ends, axis=axis, method=method, harmonics=harmonics, resume=resume, limits=steps, progress=progress
    )
    for event in beyond or []:
        if found.status == "interrupted":
            break
        said.say(found, quiet or as_json, False)
        found = respond(system, place, size, ends, axis=axis, beyond=(found, event), limits=steps, progress=progress)
    clear_line()
    said.say(found, quiet, as_json)

    def drawn() -> object:
        from phichain.report.orbits.responses import response as drawing

        return drawing(found)

    write(found, files, drawn, quiet=quiet or as_json)
    leave(found.status)


def driven(scene: Scene, place: int | str | None, axis: int | None) -> Scene:
    """The same chain with the balance's functions and, where it can have one, a flow that is forced there and carries derivatives."""
    from phichain.contract.functions import ROWS
    from phichain.orbits.harmonics import balance
    from phichain.scene.load import scene_from_dict

    tables = scene.to_dict()
    tables["functions"] = {"want": sorted({*scene.want, *balance.NEEDED})}
    flows = ROWS["propagate"].absence(scene) is None and scene.real == "double" and "propagate_stiff" not in scene.want
    here = scene.forced if place is None else place
    if flows and here is not None and _is_there(scene, here):
        tables["functions"] = {"want": sorted({*scene.want, *balance.NEEDED, "propagate"})}
        tables["flow"] = {"variational": True}
        along = scene.axis if axis is None else axis
        tables["forcing"] = {"forced": here} | ({"axis": along} if along is not None and not isinstance(here, int) else {})
    return scene_from_dict(tables)


def _is_there(scene: Scene, place: int | str) -> bool:
    """Whether the chain has the place at all; what has not is refused by `respond`, in its words."""
    if isinstance(place, int):
        return 1 <= place <= scene.links
    return place == scene.base_law.place
