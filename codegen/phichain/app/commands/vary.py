"""The command `phichain vary`: an orbit of a family, or an event of one, followed in a parameter of the chain."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from phichain.app import said
from phichain.app.commands.trace import _CLEAR, _INTERRUPTED, SceneWord, progress_line
from phichain.app.outputs import named, write

if TYPE_CHECKING:
    from phichain.continuation import Branch
    from phichain.scene import Scene


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(vary)


def vary(
    scene: SceneWord,
    parameter: Annotated[str, typer.Option(metavar="NAME[K]", help='What is turned: "gravity", "mass[2]" of link 2.')],
    until: Annotated[float, typer.Option(metavar="VALUE", help="The parameter's value at the end, exactly.")],
    at: Annotated[
        str, typer.Option(metavar="WHAT=VALUE", help="The orbit of the mode's family to begin with, whose WHAT is held.")
    ] = "amplitude=1",
    mode: Annotated[int, typer.Option(min=1, help="Mode whose family the orbit is of, by rising linear frequency.")] = 1,
    event: Annotated[
        str | None, typer.Option(metavar="KIND", help='Follow the family\'s first event of this kind instead, such as "brake loss".')
    ] = None,
    step_max: Annotated[float | None, typer.Option(metavar="S", help="Largest step, in arclength.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter's values; repeatable.")
    ] = None,
    out: Annotated[
        list[Path] | None, typer.Option("--out", "-o", metavar="FILE", help="Write the family: .csv or .npz by its name; repeatable.")
    ] = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Follow an orbit of held amplitude, energy or frequency, or an event of its family, in any parameter of the chain."""
    from phichain.orbits import trace
    from phichain.orbits.parameter import vary as varied
    from phichain.orbits.parameter.vary import SETTINGS
    from phichain.pipeline import build
    from phichain.scene.library import find_scene
    from phichain.system.starts import parameters

    files = named(out, (".csv", ".npz"))
    chosen = find_scene(scene)
    turned, values = turning(chosen, parameter.split("[")[0].strip())
    values |= parameters(settings or []) or {}
    system = replace(build(turned), digest=chosen.digest)
    family = cast("Branch", trace(system, mode, method="shooting", until=at, p=values))
    start, hold = (family, at.partition("=")[0].strip()) if event is None else (_event(family, event), event)
    options = SETTINGS if step_max is None else replace(SETTINGS, step_max=step_max, step=min(SETTINGS.step, step_max))
    branch = varied(system, parameter, start, until, hold=hold, p=values, options=options, progress=None if quiet else progress_line(system.cart_size))
    if sys.stderr.isatty():
        sys.stderr.write(_CLEAR)
    said.say(branch, quiet, as_json)
    write(branch, files, lambda: None, quiet=quiet or as_json)
    if branch.status == "interrupted":
        raise typer.Exit(_INTERRUPTED)


def turning(scene: Scene, name: str) -> tuple[Scene, dict[str, Any]]:
    """The same chain with a parameter that comes at run time, its flow carrying derivatives by it, and the number that it had."""
    from phichain.orbits.shooting import NEEDED
    from phichain.scene.keys import PARAMETERS, TABLES
    from phichain.scene.load import scene_from_dict

    tables, values = scene.to_dict(), {}
    if name in PARAMETERS and getattr(scene, name) is not None and name not in scene.runtime:
        table = next(table for table, keys in TABLES.items() if name in keys)
        values[name] = tables[table][name]
        tables[table] = tables[table] | {name: "runtime"}
    tables["functions"] = {"want": sorted({*scene.want, *NEEDED})}
    known = name in values or name in scene.runtime
    tables["flow"] = {"variational": ["state", name] if known else True}
    return scene_from_dict(tables), values


def _event(family: Branch, kind: str) -> Any:
    from phichain.errors import ArrayError

    found = next((event for event in family.events if event.kind == kind), None)
    if found is None:
        met = ", ".join(dict.fromkeys(event.kind for event in family.events))
        raise ArrayError("event", kind, "is not met by the family on the way", f"it meets {met}; go further by --at, or take one of them")
    return found
