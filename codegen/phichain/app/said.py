"""What a command says of its result: a few lines for people, one JSON object for programs, or nothing."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

if TYPE_CHECKING:
    from phichain.control import Gains
    from phichain.motion import Trajectory

NOT_THERE: Final = 3
"""Exit status of a run that ended before its end, and of a study some of whose tasks failed."""
_PATIENCE: Final = 1.0
"""Seconds before a bar is drawn: what is quicker needs none."""

Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")]


def say(text: str, data: Callable[[], Mapping[str, Any]], quiet: bool, as_json: bool) -> None:
    """Print a result in the form that was asked for."""
    if as_json:
        typer.echo(json.dumps(_plain(data()), sort_keys=True))
    elif not quiet:
        typer.echo(text)


def motion(found: Trajectory) -> dict[str, Any]:
    """What a simulation came to: its end, how it ended and why, and how far it can be trusted."""
    return {
        "name": found.name, "status": found.status, "method": found.method, "reason": found.reason, "t": found.t[-1],
        "q": dict(zip(found.q_names, found.q[-1], strict=True)), "v": dict(zip(found.v_names, found.v[-1], strict=True)),
        "counts": dict(found.counts), "tol": found.tol, "balance_error": found.balance_error, "holds_until": found.holds_until,
        "error": None if found.error is None else found.error[-1],
    }  # fmt: skip


def gains(found: Gains) -> dict[str, Any]:
    """A regulator: its gains by input and state, and how well it holds."""
    return {
        "name": found.name, "s": found.s, "sample": found.sample, "decay": found.decay, "margin": found.margin, "residual": found.residual,
        "K": {name: dict(zip(found.state_names, row, strict=True)) for name, row in zip(found.input_names, found.K, strict=True)},
        "poles": [[pole.real, pole.imag] for pole in found.poles.tolist()],
    }  # fmt: skip


def _plain(value: Any) -> Any:
    """A value as JSON has it: numbers that are none become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    plain = value.item() if hasattr(value, "item") else value
    return None if isinstance(plain, float) and plain - plain != 0 else plain


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
