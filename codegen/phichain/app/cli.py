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
from typing import Annotated, Any

import typer

import phichain
from phichain.app import said
from phichain.app.outputs import MOVING, figures, named, write
from phichain.app.settings import with_values
from phichain.app.streams import print_anything
from phichain.app.words import Commands
from phichain.errors import ArrayError, PhichainError, printable

ORDER = ("trace", "vary", "response", "orbit", "figures", "control", "attraction", "swingup", "climb", "montecarlo", "fit", "connect", "fmu", "study")
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
OutFiles = Annotated[
    list[Path] | None,
    typer.Option("--out", "-o", metavar="FILE", help="Write the result: .csv, .npz, .png, .svg or .pdf by its name, of a motion .gif, .html or .mp4, too; repeatable."),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter's values; repeatable."),
]
Proof = Annotated[bool, typer.Option("--proof/--no-proof", help="Prove the functions against the Lagrangian first.")]
Lean = Annotated[float, typer.Option(metavar="RAD", help="Start at rest, the straight chain leaning by this angle.")]


TRIAL_STEPS = 5_000
"""A regulator that fails flings the chain about; its trial is not worth more steps than this."""


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

    files = named(out, (".csv", ".npz", ".png", ".svg", ".pdf", *MOVING))
    chosen = find_scene(scene)
    system = with_values(built(chosen), chosen, settings)
    rest = leaning(system, lean)
    start = [rest[k] if given is None else given for k, given in enumerate((numbers(q, "q"), numbers(v, "v")))]
    with np.errstate(invalid="ignore"):  # a time that is not finite is refused in words below
        grid = np.linspace(0.0, t, points)
    with said.bar(system.name, quiet) as told:
        trajectory = simulated(
            system, (start[0], start[1]), grid, method, tol, u=_input(system, u, table, linear), h=h, max_steps=max_steps, progress=told
        )
    said.say(trajectory, quiet, as_json)
    write(trajectory, files, lambda: figures().motion(system, trajectory), quiet=quiet or as_json)
    if trajectory.status == "step budget":
        typer.secho("phichain: the end was not reached; raise --max-steps, or loosen --tol", fg=typer.colors.YELLOW, err=True)
        raise typer.Exit(said.NOT_THERE)


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


@app.command()
def lqr(
    scene: SceneWord,
    up: Annotated[str, typer.Option(metavar="LINKS", help="Links that stand upright: all, none, or 2,3.")] = "all",
    state_weight: Annotated[float, typer.Option("--q", metavar="W", help="Weight of the state.")] = 1.0,
    input_weight: Annotated[float, typer.Option("--r", metavar="W", help="Weight of the input.")] = 1.0,
    lean: Annotated[float, typer.Option(metavar="RAD", help="Try it with every link this far off.")] = 1e-3,
    t: Annotated[float, typer.Option("--t", metavar="S", help="How long to try it.")] = 20.0,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Synthesise the linear regulator of an equilibrium, and try it on the nonlinear chain."""
    import numpy as np

    from phichain import control
    from phichain.motion import simulate as simulated
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene
    from phichain.system.starts import leaning, upright

    files = named(out)
    chosen = find_scene(scene)
    system = with_values(built(chosen), chosen, settings)
    gains = control.lqr(system, upright(up, system.links), state_weight, input_weight)
    said.say(gains, quiet, as_json)
    law = control.feedback(system, gains)
    start = leaning(system, lean, gains.s)
    motion = simulated(system, start, np.linspace(0.0, t, 1001), tol=1e-8, u=law, max_steps=TRIAL_STEPS)
    off, rate = control.errors(system, gains, motion.x)
    verdict = "brought back" if motion.status == "complete" and off[-1] < 0.1 * off[0] else "not brought back"
    said.say(
        f"tried from {lean:g} rad off: {verdict}, e_q = {off[0]:.3g} at first, {off[-1]:.3g} at {motion.t[-1]:g} s,"
        f" largest input {np.max(np.abs(np.asarray(motion.u))):.3g}",
        quiet or as_json, False,
    )  # fmt: skip
    write(gains, files, lambda: figures().closed_loop(system, motion, off, rate), quiet=quiet or as_json)


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
