"""The command `phichain orbit`: one orbit of a saved family, refined, printed, drawn and set in motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app import said
from phichain.app.commands.orbits.options import in_double
from phichain.app.commands.orbits.trace import carrying
from phichain.app.outputs import figures, named, out_option, write
from phichain.app.settings import Settings, with_values
from phichain.errors import ArrayError, PhichainError

if TYPE_CHECKING:
    from phichain.continuation import Branch
    from phichain.scene import Scene

OutFiles = Annotated[list[Path] | None, out_option("Write the orbit: .csv, .npz, .json, .png, or in motion .gif or .html, by its name")]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(orbit)


def orbit(
    family: Annotated[Path, typer.Argument(metavar="FILE.json", help="A family that `phichain trace` wrote.")],
    at: Annotated[
        str | None,
        typer.Option(
            metavar="WHAT=VALUE",
            help="Where the family first has it: theta_K, amplitude, omega or energy; or point=K or event=K. The last point unless given.",
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(metavar="SCENE", help="The scene's TOML file, where its name alone does not lead to it.")
    ] = None,
    samples: Annotated[int, typer.Option(min=2, max=1_000_000, help="Times over the period.")] = 241,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Pick an orbit of a saved family, refine it, and say its period, energy and multipliers."""
    from phichain.continuation import Branch
    from phichain.orbits import pick
    from phichain.pipeline import build as built

    files = named(out, (".csv", ".npz", ".json", ".png", ".gif", ".html"))
    branch = Branch.from_json(family)
    chosen = _scene_of(branch, scene)
    method = branch.method if chosen.space == "spatial" else "auto"
    system = replace(built(carrying(in_double(chosen, quiet), method)), digest=chosen.digest)
    # A family knows the values that it was traced with.
    system = replace(system, params=branch.p) if branch.p and not settings else with_values(system, chosen, settings)
    found = pick(system, branch, at, samples=samples)
    said.say(found, quiet, as_json)
    write(found, files, lambda: figures().orbit(system, found), _motions(system, found), quiet=quiet or as_json)


def _scene_of(branch: Branch, word: str | None) -> Scene:
    """The scene that a family belongs to.

    Raises:
        ArrayError: It cannot be found by the name that the family has, or it is another one.
    """
    from phichain.scene.library import find_scene

    try:
        found = find_scene(word or branch.scene)
    except PhichainError:
        if word is not None:
            raise
        raise ArrayError(
            "scene", branch.scene, "is the scene of that family, and is none of the bundled ones", "name its TOML file with --scene"
        ) from None
    if found.digest != branch.digest:
        raise ArrayError(
            "scene", found.name, f"is not the scene '{branch.scene}' that this family was traced with: their digests differ",
            "name that scene's TOML file with --scene, as it was then",
        )  # fmt: skip
    return found


def _motions(system: Any, found: Any) -> dict[str, Callable[[Path], Any]]:
    def written(name: str) -> Callable[[Path], Any]:
        def write_it(path: Path) -> Any:
            from phichain.report.orbits import animation

            return getattr(animation, name)(system, found, path)

        return write_it

    return {".gif": written("write_gif"), ".html": written("write_page")}
