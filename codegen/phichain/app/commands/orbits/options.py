"""What the commands that follow oscillations share: their options, said once, the line that tells how far a run is, and how it ends."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from phichain.app.outputs import out_option

if TYPE_CHECKING:
    from phichain.continuation import Reached
    from phichain.continuation.core import Progress
    from phichain.scene import Scene

_TICK: Final = 0.1
"""Seconds between two states of the progress line."""
_CLEAR: Final = "\r\x1b[K"
"""What wipes a line of a terminal."""
_ANGLE: Final = re.compile(r"(amplitude_)?theta_\d+")
"""Unknowns that are angles, or the amplitudes of angles."""
_INTERRUPTED: Final = 130
"""Exit code of what Ctrl-C ended."""

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links.")
]
OutFiles = Annotated[list[Path] | None, out_option("Write the family: .json (to go on with), .csv, .npz or .png by its name")]
Harmonic = Annotated[
    int | None, typer.Option(metavar="H", help="Highest harmonic of --method harmonics; by the tail of the spectrum unless given.")
]
StepMax = Annotated[float | None, typer.Option(metavar="S", help="Largest step, in arclength.")]
MaxPoints = Annotated[int | None, typer.Option(help="Points after which the run ends.")]


def in_double(scene: Scene, quiet: bool = False) -> Scene:
    """The same chain in double precision, said where that is another scene: orbits close to more digits than single precision has.

    What a controller's memory limits is none of it.
    """
    if scene.real == "double":
        return scene
    if not quiet:
        typer.echo(f"{scene.name} is a scene in single precision; its orbits are followed in double precision", err=True)
    return replace(scene, real="double", stack_max=None, flash_max=None)


def limits_of(step_max: float | None, max_points: int | None) -> dict[str, Any]:
    """The limits that were given, by the names that `Options` has for them."""
    return {name: value for name, value in (("step_max", step_max), ("max_points", max_points)) if value is not None}


def ticking(told: Callable[[Reached], str], quiet: bool = False) -> Progress | None:
    """A line that says how far a run is, on a terminal only.

    Args:
        told: Where a run has come to -> what is said of it.
        quiet: Whether nothing is to be said.
    """
    if quiet or not sys.stderr.isatty():
        return None
    state: dict[str, Any] = {"last": 0.0, "points": 0}

    def tell(point: Reached, step: float) -> None:
        state["points"] += 1
        if (now := time.monotonic()) - state["last"] < _TICK:
            return
        state["last"] = now
        sys.stderr.write(f"{_CLEAR}{state['points']} points, {told(point)}arclength {point.arclength:.4f}, step {step:.2g}")
        sys.stderr.flush()

    return tell


def progress_line(quiet: bool = False) -> Progress | None:
    """The same with the largest angle of the start, where its angles are unknowns, and the frequency."""
    return ticking(lambda point: amplitude(point) + frequency(point), quiet)


def amplitude(point: Reached) -> str:
    """The largest angle among the unknowns, in words; nothing where there is none."""
    angles = [abs(value) for name, value in zip(point.names, point.z, strict=True) if _ANGLE.fullmatch(name)]
    return f"amplitude {max(angles):.4f} rad, " if angles else ""


def frequency(point: Reached) -> str:
    """The frequency in words."""
    return f"omega {point.z[point.names.index('omega')]:.5g} rad/s, " if "omega" in point.names else ""


def clear_line() -> None:
    """Wipe what stands on a terminal's last line."""
    if sys.stderr.isatty():
        sys.stderr.write(_CLEAR)


def leave(status: str) -> None:
    """Leave with the exit code of Ctrl-C what that ended.

    Raises:
        Exit: It did.
    """
    if status == "interrupted":
        raise typer.Exit(_INTERRUPTED)
