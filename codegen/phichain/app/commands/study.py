"""The command `phichain study`: one task at every point of a grid or of samples."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from phichain.app.outputs import named
from phichain.app.said import NOT_THERE
from phichain.errors import printable

if TYPE_CHECKING:
    from phichain.studies.run import Progress

INTERRUPTED = 130
"""Exit status of what Ctrl-C ended."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(study)


def study(
    plan: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="What to compute: scene, task, grid, samples.")],
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="DIR.zarr", help="The store; the study's name unless given.")] = None,
    workers: Annotated[int | None, typer.Option(metavar="N", help="Processes on this machine, one a core; 0 computes in this one.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler whose workers compute, as tcp://host:8786.")
    ] = None,
    batch: Annotated[int | None, typer.Option(metavar="N", help="Points sent to a worker at a time.")] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Compute again what failed in an earlier run.")] = False,
    plan_only: Annotated[bool, typer.Option("--plan", help="Say how large it is, and compute nothing.")] = False,
    netcdf: Annotated[Path | None, typer.Option("--netcdf", metavar="FILE.nc", help="Write the results as NetCDF, too.")] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw one output.")] = None,
    of: Annotated[str | None, typer.Option(metavar="NAME", help="Which one, as q[2]; the first unless given.")] = None,
) -> None:
    """Compute a study into its store; run again, it computes only what is new or was left over.

    Ends with 3 where tasks failed, and with 130 where Ctrl-C ended it: what there is is kept.
    """
    from phichain.studies import load_plan, write_netcdf
    from phichain.studies import study as studied

    named([picture] if picture else None, (".png",))
    named([netcdf] if netcdf else None, (".nc",))
    asked = load_plan(plan)
    typer.echo(printable(str(asked)))
    if plan_only:
        return
    with progress_bar(asked.name) as tell:
        found = studied(asked, out, workers=workers, scheduler=scheduler, batch=batch, retry=retry, progress=tell)
    for line in str(found).splitlines():
        typer.echo(printable(line))
    typer.echo(printable(f"wrote {found.path}"))
    if netcdf:
        typer.echo(printable(f"wrote {write_netcdf(found.dataset(), netcdf)}"))
    if picture:
        from phichain.report.studies import study_picture
        from phichain.report.style import save

        typer.echo(printable(f"wrote {save(study_picture(dataset := found.dataset(), of), picture, of=dataset.attrs)}"))
    if found.status == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if found.failures:
        raise typer.Exit(NOT_THERE)


@contextmanager
def progress_bar(name: str) -> Iterator[Progress]:
    """A bar on a terminal's standard error, with what failed and how long it will take; nothing in a pipe."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[failed]}"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        line = bar.add_task(printable(name), total=None, failed="")

        def tell(done: int, failed: int, total: int) -> None:
            bar.update(line, completed=done + failed, total=total, failed=f"{failed} failed" if failed else "")

        yield tell
