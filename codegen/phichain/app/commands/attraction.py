"""The command `phichain attraction`: how far the regulators of a chain hold it, by simulation of the emitted closed loop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from phichain.app import said
from phichain.app.outputs import named, out_option, write
from phichain.errors import ControlError

SceneWord = Annotated[str, typer.Argument(metavar="SCENE", help="A chain with inputs: a TOML file, a bundled scene's name, or planarN.")]
Words = list[str] | None
LONGEST = 1e-3
"""Longest step of the chain, s."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(attraction)


def attraction(
    scene: SceneWord,
    table: Annotated[str, typer.Option(metavar="all|LINKS;...", help='Equilibria: all, or by the links that stand, "none;2;1,2".')] = "all",
    sample: Annotated[float, typer.Option(metavar="S", help="Time between two calls of the law.")] = 1e-3,
    limit: Annotated[float | None, typer.Option(metavar="U", help="Largest size of every input; none unless given.")] = None,
    state_weight: Annotated[float, typer.Option("--q", metavar="W", help="Weight of the state.")] = 1.0,
    input_weight: Annotated[float, typer.Option("--r", metavar="W", help="Weight of the input.")] = 1.0,
    weights: Annotated[Words, typer.Option("--weight", metavar="NAME=W", help="Weight of one entry of state or input; repeatable.")] = None,
    seconds: Annotated[float, typer.Option("--t", metavar="S", help="Time within which a start must come home.")] = 15.0,
    count: Annotated[int, typer.Option("--directions", min=1, metavar="N", help="Directions, and starts drawn from the ball.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Of directions and starts.")] = 0,
    plane: Annotated[str | None, typer.Option("--map", metavar="XI,XI", help="Instead map two turns of links, as xi_1,xi_2, of one.")] = None,
    extent: Annotated[float | None, typer.Option(metavar="RAD", help="Largest turn of the map; three times the radius unless given.")] = None,
    points: Annotated[int, typer.Option(min=2, max=1001, help="Starts along each axis of the map.")] = 61,
    out: Annotated[list[Path] | None, out_option("Write the result: .csv, .npz or .png by its name")] = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Find from how far off the equilibria of a chain are reached, with the law as the controller has it, in the scene's type."""
    from phichain.app.control_words import equilibria, weighed
    from phichain.control import gain_table, regulators
    from phichain.control.reach import attraction as found
    from phichain.control.reach import attraction_map, demand_turns
    from phichain.pipeline import build, build_closed_loop
    from phichain.scene.library import find_scene
    from phichain.system.arrays import positive

    seconds = positive("t", seconds, "give the time within which a start must come home, s", ControlError)
    files, chosen = named(out), find_scene(scene)
    wanted = tuple(dict.fromkeys((*chosen.want, "linearization", "forward_dynamics")))
    system = build(replace(chosen, real="double", want=wanted))
    Q, R = weighed(system, state_weight, input_weight, weights or [])
    laws = gain_table(regulators(system, equilibria(table, system.links), Q, R, sample=sample), limit=limit)
    laws = replace(laws, name=chosen.name, digest=chosen.digest)
    flown = build_closed_loop(chosen, laws, chosen.real, LONGEST)
    if plane is not None and len(laws.signs) > 1:
        raise ControlError("table", table, "are several equilibria, and a map is of one", 'name one, as --table "1,2"')
    coordinates = None if plane is None else demand_turns(system, tuple(plane.replace(",", " ").split()))
    with said.counted("equilibria", quiet) as told:
        record = found(system, laws, flown, count=count, seconds=seconds, seed=seed, progress=told)
    said.say(record, quiet, as_json)
    if coordinates is None:
        write(record, files, lambda: _drawing().radii(record), quiet=quiet or as_json)
        return
    mapped = attraction_map(system, laws, flown, 0, coordinates, extent or min(3 * float(record.radius[0]), 0.9), points, seconds)
    said.say(mapped, quiet, as_json)
    write(mapped, files, lambda: _drawing().region(mapped, record), quiet=quiet or as_json)


def _drawing() -> Any:
    """The module that draws, imported when something is drawn."""
    from phichain.report.laws import attraction as drawing

    return drawing
