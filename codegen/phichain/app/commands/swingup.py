"""The command `phichain swingup`: from a scene to a motion, and to the C that leads the chain along it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app import said
from phichain.app.outputs import named, write
from phichain.app.settings import Settings, with_values
from phichain.errors import ArrayError, printable

if TYPE_CHECKING:
    from phichain.trials.search import Tried

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A planar chain with inputs: a TOML file, a bundled scene's name, or planarN.")
]
Errors = Annotated[
    list[str] | None,
    typer.Option("--error", metavar="NAME=E", help="Largest relative error of a parameter, as mass=0.1; repeatable."),
]
Files = Annotated[
    list[Path] | None,
    typer.Option("--save", metavar="FILE", help="Write the plan too: .npz (whole), .csv (a table) or .png (a strip); repeatable."),
]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(swingup)


def swingup(
    scene: SceneWord,
    limit: Annotated[str, typer.Option(metavar="U,...", help="Largest size of every input, or of all.")],
    rail: Annotated[float | None, typer.Option(metavar="X", help="How far the cart may go to either side, m.")] = None,
    start: Annotated[str, typer.Option("--from", metavar="LINKS", help="Links that stand at the start.")] = "none",
    target: Annotated[str, typer.Option("--to", metavar="LINKS", help="Links that stand at the end: all, none, or 2,3.")] = "all",
    places: Annotated[
        str | None, typer.Option("--places", metavar="X0,X1", help="Where the cart stands at the start and at the end, m.")
    ] = None,
    errors: Errors = None,
    spread: Annotated[float, typer.Option(metavar="RAD", help="Largest error of the angles at the start.")] = 0.05,
    sample: Annotated[float, typer.Option(metavar="S", help="Time between two calls of the law.")] = 1e-3,
    seconds: Annotated[float | None, typer.Option("--time", metavar="S", help="Duration of the motion; several are tried unless given.")] = None,
    runs: Annotated[int, typer.Option(min=2, help="Trials of the compiled law.")] = 200,
    enough: Annotated[float, typer.Option(metavar="SHARE", help="End the search with a law that holds in such a share of its runs.")] = 0.95,
    starts: Annotated[int, typer.Option(min=1, help="Starts of the search at most.")] = 12,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    observer: Annotated[
        str | None, typer.Option("--observer", metavar="KIND", help="Read positions alone, in steps, through an observer: kalman.")
    ] = None,
    resolution: Annotated[
        list[str] | None, typer.Option("--resolution", metavar="[NAME=]STEP", help="Step of a position; encoders of 4096 counts, 0.1 mm.")
    ] = None,
    noise: Annotated[
        list[str] | None, typer.Option("--noise", metavar="[NAME=]SIGMA", help="Standard deviation that the observer expects beside that.")
    ] = None,
    disturbance: Annotated[
        list[str] | None,
        typer.Option("--disturbance", metavar="[NAME=]D", help="White noise on an acceleration or input, per sqrt(Hz); 1 on each acceleration."),
    ] = None,
    solver: Annotated[str, typer.Option(help="fatrop or ipopt.")] = "fatrop",
    iterations: Annotated[int, typer.Option(min=1, help="Iterations that one start is worth.")] = 400,
    anyway: Annotated[bool, typer.Option("--anyway", help="Write what there is when no start converged; its header says so.")] = False,
    real: Annotated[str, typer.Option(help="Type of the C and its table: float or double.")] = "float",
    settings: Settings = None,
    save: Files = None,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")] = Path("generated"),
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Plan a swing-up, try the law along it on chains with wrong parameters, and write it as C, DIR/NAME_swingup."""
    from phichain.app.control_words import demand_together, sensors_of
    from phichain.pipeline import build, generate_swingup
    from phichain.scene.library import find_scene
    from phichain.system.starts import numbers, upright
    from phichain.trials import swing_up

    files = named(save, (".npz", ".csv", ".json", ".png"))
    demand_together("observer", observer, {"resolution": resolution, "noise": noise, "disturbance": disturbance})
    if observer not in (None, "kalman"):
        raise ArrayError("observer", observer, "is no observer along a motion", "say kalman")
    chosen = find_scene(scene)
    system = build(replace(chosen, real="double", variational=False, want=("forward_dynamics", "linearization")))
    system = with_values(replace(system, digest=chosen.digest), chosen, settings)
    sizes = errors_of(errors or [])
    with progress(starts, quiet) as tell:
        found = swing_up(
            system, limit=numbers(limit, "limit"), rail=rail, start=upright(start, system.links), target=upright(target, system.links),
            places=_places(numbers(places, "places")), errors=sizes, spread=spread, sample=sample, seconds=seconds, runs=runs,
            real=real, enough=enough, count=starts, jobs=jobs, solver=solver, most=iterations, anyway=anyway,
            sensors=None if observer is None else sensors_of(None, resolution, noise, disturbance), report=tell,
        )  # fmt: skip
    said.say(found, quiet, as_json)
    folder = generate_swingup(found.law, out, real)
    if not (quiet or as_json):
        typer.echo(printable(f"wrote {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}"))
    write(found.plan, files, lambda: _strip(system, found.plan), quiet=quiet or as_json)


def errors_of(words: Sequence[str], option: str = "error") -> dict[str, float]:
    """Numbers by name from words like mass=0.1.

    Args:
        words: The words.
        option: The option that they were given with.

    Raises:
        ArrayError: A word is not of that kind.
    """
    found = {}
    for word in words:
        name, equals, text = word.partition("=")
        try:
            found[name.strip()] = float(text)
        except ValueError:
            equals = ""
        if not equals:
            raise ArrayError(option, word, "is not NAME=NUMBER", f"write for example --{option} mass=0.1")
    return found


def _places(given: Any) -> tuple[float, float]:
    if given is None:
        return 0.0, 0.0
    if len(given) != 2:
        raise ArrayError("places", given.tolist(), "are not two places of the cart", "write for example --places -0.5,0.5")
    return float(given[0]), float(given[1])


def _strip(system: Any, plan: Any) -> Any:
    from phichain.report.laws.swing_up import strip

    return strip(system, plan)


@contextmanager
def progress(count: int, quiet: bool = False) -> Iterator[Callable[[Tried], None]]:
    """A line for every start that has ended, and on a terminal how many there are, on stderr; nothing where nothing but errors is wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True, highlight=False, soft_wrap=True)
    columns = (TextColumn("starts"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.fields[best]}"))
    with Progress(*columns, console=console, transient=True, disable=quiet or not sys.stderr.isatty()) as bar:
        task, best = bar.add_task("", total=count, best=""), 0.0

        def tell(one: Tried) -> None:
            nonlocal best
            best = max(best, one.share)
            if not quiet:
                console.print(str(one), markup=False)
            bar.update(task, advance=1, best=f"best {best:.1%}")

        yield tell
