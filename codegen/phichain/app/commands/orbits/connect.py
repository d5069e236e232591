"""The command `phichain connect`: motions that lead from the upright chain back to it, whole turns on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from phichain.app import said
from phichain.app.commands.orbits.options import in_double
from phichain.app.outputs import named, out_option
from phichain.app.settings import Settings, with_values
from phichain.errors import ArrayError, printable

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A conservative planar chain of one or two links: a TOML file, a scene's name, or planarN.")
]
OutFiles = Annotated[list[Path] | None, out_option("Write them: .csv or .npz (numbered where there are several) or .png")]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(connect)


def connect(
    scene: SceneWord,
    turns: Annotated[str | None, typer.Option(metavar="N,...", help="Whole turns of every link, as 1,0; one of each unless given.")] = None,
    longest: Annotated[float | None, typer.Option(metavar="S", help="Half the time in which to look.")] = None,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Find homoclinic and heteroclinic connections of the upright chain that turn its links by whole turns."""
    from phichain.orbits.connections import connections
    from phichain.orbits.connections.connect import NEEDED
    from phichain.pipeline import build
    from phichain.scene.library import find_scene
    from phichain.scene.load import with_functions

    files = named(out, (".csv", ".npz", ".png"))
    wanted = None if turns is None else _turns(turns)
    chosen = find_scene(scene)
    system = build(with_functions(in_double(chosen, quiet), NEEDED, variational=True))
    # The file is to name the scene that was given, whatever functions this command needed of it besides.
    system = with_values(replace(system, digest=chosen.digest), chosen, settings)
    found = connections(system, wanted, longest=longest)
    for connection in found:
        said.say(connection, quiet, as_json)
    if not found:
        typer.secho(f"{system.name}: no symmetric connection with these turns within that time", err=as_json or quiet)
        return
    for path in files:
        if path.suffix == ".png":
            from phichain.report.orbits.connections import connections as drawing
            from phichain.report.style import save

            written = [save(drawing(system, found), path, of=found)]
        else:
            names = [path] if len(found) == 1 else [path.with_stem(f"{path.stem}_{k}") for k in range(1, len(found) + 1)]
            written = [c.to_csv(name) if path.suffix == ".csv" else c.to_npz(name) for c, name in zip(found, names, strict=True)]
        if not (quiet or as_json):
            typer.echo(printable("wrote " + ", ".join(map(str, written))))


def _turns(text: str) -> list[int]:
    try:
        return [int(word) for word in text.split(",")]
    except ValueError:
        raise ArrayError("turns", text, "is no list of whole numbers", "give one for every link, as --turns 1,0") from None
