"""The command `phichain`: one subcommand per verb, each a few lines around a function that Python users call too.

Errors that phichain raises on purpose end as one line on stderr and exit code 2; anything else keeps its traceback,
because then the fault is ours and the traceback is what a report needs.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

import phichain
from phichain.app.streams import print_anything
from phichain.app.words import Commands
from phichain.errors import PhichainError, printable

ORDER = (
    "simulate", "lqr", "orbits.trace", "orbits.vary", "orbits.response", "orbits.orbit", "figures", "control", "attraction", "swingup", "climb", "montecarlo", "fit",
    "orbits.connect", "fmu", "study",
)  # fmt: skip
"""Commands of files of their own, as help lists them behind those here."""

app = typer.Typer(
    name="phichain",
    cls=Commands,
    help="From a Lagrangian to firmware: pendulum chains derived, emitted as C and CasADi, simulated and controlled.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # help in plain columns, as all that phichain prints, for half the time that Rich takes to be imported
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120},
)

SceneWord = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links."
    ),
]
OutFolder = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")]
Proof = Annotated[bool, typer.Option("--proof/--no-proof", help="Prove the functions against the Lagrangian first.")]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and leave with its exit code: 0 done, 2 refused with one line that says why, 3 not reached (`said`), 130 interrupted."""
    warnings.showwarning = _one_line
    print_anything()
    try:
        app(args=None if arguments is None else list(arguments), prog_name="phichain")
    except PhichainError as refusal:
        typer.secho(f"phichain: {refusal}", fg=typer.colors.RED, err=True)
        sys.exit(2)


def _one_line(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    typer.secho(f"phichain: warning: {printable(str(message))}", fg=typer.colors.YELLOW, err=True)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"phichain {phichain.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Say it and stop.")] = False,
) -> None:
    pass


@app.command()
def show(
    scene: SceneWord,
    phi: Annotated[bool, typer.Option("--phi", help="Also the single-harmonic balance Phi_k of paper A.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Equations as LaTeX.")] = False,
    symbols: Annotated[bool, typer.Option("--symbols", help="Letters m_k, l_k, ... instead of numbers.")] = False,
    full: Annotated[bool, typer.Option("--full", help="Write out chains of more than three links too.")] = False,
    program: Annotated[
        str | None, typer.Option(metavar="FUNCTION", help="Instead, the list of operations of one function.")
    ] = None,
) -> None:
    """Show a chain: its sketch, Lagrangian, mass matrix and equations of motion."""
    from phichain.app.show import equations, operations
    from phichain.scene.library import find_scene

    chosen = find_scene(scene)
    if program:
        typer.echo(operations(chosen, program))
    else:
        typer.echo(equations(chosen, latex=latex, phi=phi, symbols=symbols, full=full))


@app.command()
def generate(
    scene: SceneWord,
    out: OutFolder = Path("generated"),
    casadi_c: Annotated[
        bool, typer.Option("--casadi-c", help="Also NAME_casadi.c, for CasADi's external with exact Jacobians.")
    ] = False,
    proof: Proof = True,
    check: Annotated[bool, typer.Option("--check", help="Write nothing; exit 1 where the folder is not what would be written.")] = False,
    package: Annotated[
        str | None, typer.Option(metavar="KIND", help="Lay it out for cmake, zephyr, platformio or arduino, with a bill of materials.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that were edited by hand.")] = False,
) -> None:
    """Write the stand-alone C and CasADi folder of a scene, DIR/NAME."""
    from phichain.pipeline import check_folder
    from phichain.pipeline import generate as written
    from phichain.scene.library import find_scene

    if check:
        found = check_folder(find_scene(scene), out, with_casadi_c=casadi_c, prove=proof, package=package)
        typer.echo(printable(str(found)))
        raise typer.Exit(1 if found else 0)
    folder = written(find_scene(scene), out, with_casadi_c=casadi_c, prove=proof, force=force, package=package)
    typer.echo(printable(f"wrote {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}"))


@app.command()
def build(scene: SceneWord, proof: Proof = True) -> None:
    """Compile a scene, or find it compiled, and list the functions that can be called."""
    from phichain.app.console import callables
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene

    system = built(find_scene(scene), prove=proof)
    typer.echo(str(system).partition("; functions")[0])
    typer.echo(callables(system))


@app.command()
def prove(scene: SceneWord) -> None:
    """Prove a scene's functions against its Lagrangian, exactly, and say of each how."""
    from phichain.proof import prove as proven
    from phichain.scene.library import find_scene

    typer.echo(str(proven(find_scene(scene))))


@app.command()
def functions(
    scene: Annotated[
        str | None, typer.Argument(metavar="[SCENE]", help="Say of each whether this scene wants it, or why it has none.")
    ] = None,
) -> None:
    """List the functions that a scene can want: arguments, where they are, what they compute."""
    from phichain.app import console
    from phichain.scene.library import find_scene

    typer.echo(console.functions(find_scene(scene) if scene else None))


@app.command()
def tour(out: OutFolder = Path("generated")) -> None:
    """Take the whole path once with both papers' chains, and leave a report in DIR/report."""
    from phichain.app.tour import tour as taken

    typer.echo(printable(f"report: {taken(out)}"))


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files, by which editors complete and check them."""
    import json

    from phichain.scene.schema import scene_schema

    typer.echo(json.dumps(scene_schema(), indent=2))


@app.command()
def info() -> None:
    """Say which versions, compiler and cache are in use."""
    from phichain.app.console import columns, environment

    typer.echo(columns(environment()))


for name in ORDER:
    import_module(f"phichain.app.commands.{name}").register(app)
