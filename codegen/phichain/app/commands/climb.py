"""The command `phichain climb`: from a saved family of orbits to the C that leads a weakly driven chain up along it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from phichain.app import said
from phichain.app.outputs import named, write
from phichain.errors import printable

SceneWord = Annotated[str, typer.Argument(metavar="SCENE", help="A planar chain on a fixed base: a TOML file, a bundled scene's name, or planarN.")]
BranchFile = Annotated[Path, typer.Option("--branch", metavar="FILE.json", help="A family of brake orbits that `trace` wrote, of this scene.")]
Errors = Annotated[
    list[str] | None, typer.Option("--error", metavar="NAME=E", help="Largest relative error of a parameter in the trials, as mass=0.01; repeatable.")
]
Files = Annotated[
    list[Path] | None, typer.Option("--save", metavar="FILE", help="Write the trials: .npz (whole), .csv (a table) or .png (the climb); repeatable.")
]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(climb)


def climb(
    scene: SceneWord,
    branch: BranchFile,
    limit: Annotated[float, typer.Option(metavar="SHARE", help="Limit of the torque, in gravity torques about the driven joint.")] = 0.05,
    joint: Annotated[int | None, typer.Option(min=1, help="The driven joint; the first one that the scene drives unless given.")] = None,
    damping: Annotated[str | None, typer.Option(metavar="D,...", help="Dampers that the rig has and the scene does not, N m s/rad.")] = None,
    errors: Errors = None,
    spread: Annotated[float, typer.Option(metavar="RAD", help="Largest error of the angles at the start.")] = 0.05,
    sample: Annotated[float, typer.Option(metavar="S", help="Time between two calls of the law.")] = 1e-3,
    rungs: Annotated[int | None, typer.Option(min=4, help="Orbits in the table; the more the weaker the torque unless given.")] = None,
    nodes: Annotated[int | None, typer.Option(min=9, help="Nodes of half a period; likewise.")] = None,
    pace: Annotated[float | None, typer.Option(metavar="R", help="Rungs a second at most; by the limit unless given.")] = None,
    runs: Annotated[int, typer.Option(min=1, help="Trials of the compiled law.")] = 20,
    seconds: Annotated[float | None, typer.Option("--time", metavar="S", help="How long a trial is; by the rungs unless given.")] = None,
    real: Annotated[str, typer.Option(help="Type of the C and its table: float or double.")] = "float",
    save: Files = None,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")] = Path("generated"),
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Lead a weakly driven chain up along a family of orbits, try that on the compiled chain, and write it as C, DIR/NAME_climb."""
    from phichain.app.commands.swingup import errors_of
    from phichain.continuation import Branch
    from phichain.pipeline import generate_climb
    from phichain.scene.library import find_scene
    from phichain.system.arrays import positive
    from phichain.system.starts import numbers
    from phichain.trials import climb as climbed

    limit = positive("limit", limit, "give a part of the gravity torque, such as 0.05")
    files = named(save, (".npz", ".csv", ".png"))
    chosen, family = find_scene(scene), Branch.from_json(branch)
    with said.counted("trials", quiet) as told:
        found = climbed(
            chosen, family, share=limit, joint=joint, damping=numbers(damping, "damping"), errors=errors_of(errors or []), spread=spread,
            runs=runs, seconds=seconds, real=real, progress=told, sample=sample, rungs=rungs, nodes=nodes, pace=pace,
        )  # fmt: skip
    said.say(found, quiet, as_json)
    folder = generate_climb(found.climb.law, out, real)
    if not (quiet or as_json):
        typer.echo(printable(f"wrote {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}"))

    def drawn() -> object:
        from phichain.report.laws.climb import climbing

        return climbing(found.climb.law, found.t, found.x, found.u, found.energy)

    write(found.runs, files, drawn, quiet=quiet or as_json)
