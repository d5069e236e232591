"""The command `phichain montecarlo`: a law on file, tried on chains that are wrong in many ways."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from phichain.app import said
from phichain.app.outputs import named, out_option, write

SceneWord = Annotated[str, typer.Argument(metavar="SCENE", help="The chain that the law was made for: a TOML file, a bundled scene's name, or planarN.")]
LawFolder = Annotated[Path, typer.Argument(metavar="LAWDIR", help="A folder that phichain controller, swingup or climb wrote.")]
Words = list[str] | None


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(montecarlo)


def montecarlo(
    scene: SceneWord,
    law: LawFolder,
    errors: Annotated[Words, typer.Option("--error", metavar="NAME=E", help="Largest relative error of a parameter, as mass=0.1; repeatable.")] = None,
    added: Annotated[
        Words, typer.Option("--add", metavar="NAME=D", help="Losses beyond the scene's, up to: damping, friction, cart_damping, cart_friction; repeatable.")
    ] = None,
    late: Annotated[float, typer.Option("--late", metavar="S", help="Time by which inputs come late, at most.")] = 0.0,
    resolution: Annotated[
        Words, typer.Option("--resolution", metavar="NAME=R", help="Step in which an entry of the state is read; repeatable.")
    ] = None,
    spread: Annotated[float, typer.Option(metavar="RAD", help="Largest error of the angles at the start; in space of the sines of tilts.")] = 0.05,
    up: Annotated[str | None, typer.Option(metavar="LINKS", help="Of a table of gains, or in space where the law does not see which way up links are: links that stand, all, none, or 2,3.")] = None,
    seconds: Annotated[float | None, typer.Option("--time", metavar="S", help="How long the law may take; by the law unless given.")] = None,
    hold: Annotated[float, typer.Option(metavar="S", help="How long the target must be held then.")] = 2.0,
    runs: Annotated[int, typer.Option(min=1, help="How many.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 1,
    out: Annotated[list[Path] | None, out_option("Write the runs: .csv, .npz or .png by its name")] = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Let a law's own C run on the compiled chain with wrong parameters, late inputs and sensors that read in steps."""
    from phichain.app.commands.swingup import errors_of
    from phichain.scene.library import find_scene
    from phichain.system.starts import upright
    from phichain.trials import Disturbed, law_on_file, law_trials

    files, chosen, made = named(out, (".csv", ".npz", ".png")), find_scene(scene), law_on_file(law)
    disturbed = Disturbed(errors_of(errors or []), errors_of(added or [], "add"), spread, late, errors_of(resolution or [], "resolution"))
    signs = None if up is None else upright(up, chosen.links)
    with said.counted("runs", quiet) as told:
        found = law_trials(chosen, made, disturbed, up=signs, seconds=seconds, hold=hold, runs=runs, seed=seed, progress=told)
    said.say(found, quiet, as_json)

    def drawn() -> object:
        from phichain.report.laws.runs import scattered

        return scattered(found)

    write(found, files, drawn, quiet=quiet or as_json)
