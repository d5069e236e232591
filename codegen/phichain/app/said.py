"""What a command says of its result: a few lines for people, one JSON object for programs, or nothing."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Final

import typer

NOT_THERE: Final = 3
"""Exit status of a run that ended before its end, and of a study some of whose tasks failed."""
_PATIENCE: Final = 1.0
"""Seconds before a bar is drawn: what is quicker needs none."""

_LONG: Final = 3.0
"""Seconds after which somebody who waits is told why, and how long that may be."""

Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")]


def say(found: Any, quiet: bool, as_json: bool) -> None:
    """Print a result in the form that was asked for."""
    if as_json:
        from phichain.app.summaries import printed, summary

        typer.echo(printed(summary(found)))
    elif not quiet:
        typer.echo(str(found))


@contextmanager
def bar(name: str, quiet: bool = False) -> Iterator[Callable[[float, float], None] | None]:
    """A bar on a terminal's standard error for what takes more than a second; nothing in a pipe."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    began = time.monotonic()
    shown: list[Any] = []

    def tell(fraction: float, t: float) -> None:
        if not shown and time.monotonic() - began > _PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            progress = Progress(console=Console(stderr=True), transient=True)
            shown.extend([progress, progress.add_task(name, total=1.0)])
            progress.start()
        if shown:
            shown[0].update(shown[1], completed=fraction, description=f"{name}, t = {t:.4g} s")

    try:
        yield tell
    finally:
        if shown:
            shown[0].stop()


@contextmanager
def counted(what: str, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A bar on a terminal's standard error that says how many are done, and of how many; nothing where no one looks."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=quiet or not console.is_terminal) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@contextmanager
def explained(words: Callable[[], str], quiet: bool = False) -> Iterator[None]:
    """One line on standard error, in a pipe too, for what is still on its way after some seconds.

    Args:
        words: Makes the line, in a thread of its own.
        quiet: Whether to say nothing.
    """
    timer = threading.Timer(_LONG, lambda: typer.secho(f"phichain: {words()}", fg=typer.colors.YELLOW, err=True))
    timer.daemon = True
    if not quiet:
        timer.start()
    try:
        yield
    finally:
        timer.cancel()
