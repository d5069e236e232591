"""The command `phichain simulate`: a motion from a start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from phichain.app import said
from phichain.app.outputs import MOVING, figures, named, out_option, write
from phichain.app.settings import Settings, with_values
from phichain.errors import ArrayError

SceneWord = Annotated[str, typer.Argument(metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links.")]
OutFiles = Annotated[list[Path] | None, out_option("Write the result: .csv, .npz, .json, .png, .svg or .pdf by its name, of a motion .gif, .html or .mp4, too")]
Lean = Annotated[float, typer.Option(metavar="RAD", help="Start at rest, the straight chain leaning by this angle.")]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(simulate)


def simulate(
    scene: SceneWord,
    t: Annotated[float, typer.Option("--t", metavar="S", help="Final time in seconds.")] = 10.0,
    points: Annotated[int, typer.Option(min=2, max=10_000_000, help="Output times, evenly spaced.")] = 1001,
    lean: Lean = 0.5,
    q: Annotated[str | None, typer.Option(metavar="A,B,...", help="Start here instead (nq numbers).")] = None,
    v: Annotated[str | None, typer.Option(metavar="A,B,...", help="Start with these rates (nv numbers).")] = None,
    u: Annotated[str | None, typer.Option(metavar="A,B,...", help="A constant input (nu numbers).")] = None,
    table: Annotated[
        str | None, typer.Option("--input", metavar="FILE", help="Inputs over time: a CSV file with columns t and inputs by name.")
    ] = None,
    linear: Annotated[bool, typer.Option("--linear", help="Straight lines between the rows of --input, not held values.")] = False,
    method: Annotated[str, typer.Option(help="auto, or a method by name.")] = "auto",
    tol: Annotated[float | None, typer.Option(help="Relative tolerance of a step.")] = None,
    h: Annotated[float | None, typer.Option("--step", metavar="S", help="Step of a fixed-step method.")] = None,
    max_steps: Annotated[int, typer.Option(metavar="N", help="Steps after which it ends; with status 3 where that is before the end.")] = 1_000_000,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Simulate a chain from a given start and say how well its energy was kept, or its balance with work and loss."""
    import numpy as np

    from phichain.motion import simulate as simulated
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene
    from phichain.system.starts import leaning, numbers

    files = named(out, (".csv", ".npz", ".json", ".png", ".svg", ".pdf", *MOVING))
    chosen = find_scene(scene)
    system = with_values(built(chosen), chosen, settings)
    rest = leaning(system, lean)
    start = [rest[k] if given is None else given for k, given in enumerate((numbers(q, "q"), numbers(v, "v")))]
    with np.errstate(invalid="ignore"):  # a time that is not finite is refused in words below
        grid = np.linspace(0.0, t, points)
    long = partial(_still, system, start, t, max_steps)
    with said.explained(long, quiet or as_json), said.bar(system.name, quiet) as told:
        trajectory = simulated(
            system, (start[0], start[1]), grid, method, tol, u=_input(system, u, table, linear), h=h, max_steps=max_steps, progress=told
        )
    said.say(trajectory, quiet, as_json)
    write(trajectory, files, lambda: figures().motion(system, trajectory), quiet=quiet or as_json)
    if trajectory.status == "step budget":
        typer.secho("phichain: the end was not reached; raise --max-steps, or loosen --tol", fg=typer.colors.YELLOW, err=True)
        raise typer.Exit(said.NOT_THERE)


def _still(system: Any, start: Sequence[Any], t: float, max_steps: int) -> str:
    """Why a run may be long, and how long at most."""
    from phichain.motion.choose import fastest

    rate = fastest(system, start)
    known = math.isfinite(rate) and rate > 0
    why = f"its fastest motion at the start is {rate:.2g} rad/s, {rate * abs(t) / math.tau:.2g} turns in {abs(t):g} s, each of which takes steps; " if known else ""
    return f"{system.name} is still on its way: {why}it ends after {max_steps} steps at most (--max-steps), or with Ctrl-C"


def _input(system: Any, u: str | None, table: str | None, linear: bool) -> Any:
    """A constant input, or a table of inputs from a file."""
    from phichain.motion.inputs.sheet import read_inputs
    from phichain.system.starts import numbers

    if table is None:
        if linear:
            raise ArrayError("linear", linear, "says what is between the rows of a table", "give --input too")
        return numbers(u, "u")
    if u is not None:
        raise ArrayError("u, input", (u, table), "are both given", "leave one of them out")
    return read_inputs(system, table, "linear" if linear else "held")
