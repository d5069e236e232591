"""The command `phichain vary`: an orbit of a family, or an event of one, followed in a parameter of the chain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from phichain.app import said
from phichain.app.commands.orbits.options import (
    MaxPoints,
    OutFiles,
    SceneWord,
    StepMax,
    clear_line,
    in_double,
    leave,
    limits_of,
    progress_line,
)
from phichain.app.outputs import named, write
from phichain.app.settings import Settings, values_given

if TYPE_CHECKING:
    from phichain.continuation import Branch
    from phichain.continuation.core import Progress
    from phichain.scene import Scene


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(vary)


def vary(
    scene: SceneWord,
    parameter: Annotated[
        str, typer.Option(metavar="NAME[K]", help='What is turned: "gravity", "mass[2]" of link 2; "amplitude" of the forcing, of driven orbits.')
    ],
    until: Annotated[float, typer.Option(metavar="VALUE", help="The parameter's value at the end, exactly.")],
    at: Annotated[
        str, typer.Option(metavar="WHAT=VALUE", help="The orbit of the mode's family to begin with, whose WHAT is held.")
    ] = "amplitude=1",
    mode: Annotated[int, typer.Option(min=1, help="Mode whose family the orbit is of, by rising linear frequency.")] = 1,
    method: Annotated[
        str, typer.Option(help='How that family is traced: "shooting", or "conical" and "in a plane" of a spatial chain; auto: what serves.')
    ] = "auto",
    event: Annotated[
        str | None, typer.Option(metavar="KIND", help='Follow the family\'s first event of this kind instead, such as "brake loss".')
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            metavar="ORBIT",
            help="Begin with an orbit that there is: FILE.json:POINT or FILE.json:event=K of a family or a response, both counted from 1, "
            'or "q=1,0.2; v=0,0; period=1.7".',
        ),
    ] = None,
    hold: Annotated[
        str | None,
        typer.Option(
            metavar="WHAT",
            help="What is held of it: amplitude, omega, energy, theta_K or another unknown, or the kind of an event that it is.",
        ),
    ] = None,
    resume: Annotated[Path | None, typer.Option(metavar="FILE", help="Go on with what an earlier run left, .json or .npz.")] = None,
    step_max: StepMax = None,
    max_points: MaxPoints = None,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Follow an orbit of held amplitude, energy or frequency, or an event of its family, in any parameter of the chain; Ctrl-C ends it, and it goes on."""
    from phichain.orbits.parameter import vary as varied
    from phichain.orbits.parameter.vary import SETTINGS, demand_reached
    from phichain.orbits.tracing import limited
    from phichain.pipeline import build
    from phichain.scene.library import find_scene

    files = named(out, (".json", ".csv", ".npz", ".png"))
    chosen = find_scene(scene)
    turned, values = turning(in_double(chosen, quiet), parameter.split("[")[0].strip())
    values = values_given(turned, settings, values)
    system = replace(build(turned), digest=chosen.digest)
    begun: Any = start
    if start is None and resume is None:
        family = _family(system, mode, method, at, values, progress_line(quiet))
        clear_line()
        if family.status == "interrupted":
            # Where it was ended is not the orbit that was asked for.
            said.say(family, quiet, as_json)
            leave(family.status)
        if event is None:
            demand_reached("at", family)
        begun, hold = (family, hold or at.partition("=")[0].strip()) if event is None else ((family, _event(family, event)), event)
    branch = varied(
        system, parameter, begun, until, hold=hold, p=values, resume=resume, options=limited(SETTINGS, limits_of(step_max, max_points)),
        progress=progress_line(quiet),
    )  # fmt: skip
    clear_line()
    said.say(branch, quiet, as_json)
    write(branch, files, lambda: _drawn(branch), quiet=quiet or as_json)
    leave(branch.status)


def _family(system: Any, mode: int, method: str, at: str, values: dict[str, Any], progress: Progress | None) -> Branch:
    from phichain.orbits import trace

    chosen = method if method != "auto" else "shooting" if system.is_planar else "conical"
    return cast("Branch", trace(system, mode, method=chosen, until=at, p=values, progress=progress))


def _drawn(branch: Branch) -> Any:
    from phichain.report.orbits.parameter import in_parameter

    return in_parameter(branch)


def turning(scene: Scene, name: str) -> tuple[Scene, dict[str, Any]]:
    """The same chain with a parameter that comes at run time, its flow carrying derivatives by it, and the number that it had."""
    from phichain.orbits import conical, in_plane, shooting
    from phichain.orbits.parameter.followed import AMPLITUDE
    from phichain.scene.keys import PARAMETERS, TABLES
    from phichain.scene.load import scene_from_dict

    _demand_parameter(scene, name)
    tables, values = scene.to_dict(), {}
    if name in PARAMETERS and getattr(scene, name) is not None and name not in scene.runtime:
        table = next(table for table, keys in TABLES.items() if name in keys)
        values[name] = tables[table][name]
        tables[table] = tables[table] | {name: "runtime"}
    is_planar = scene.space == "planar"
    # Orbits that need not stand still ask for the equations of motion, too.
    needed = {*shooting.NEEDED, "forward_dynamics"} if is_planar else {*conical.NEEDED, *in_plane.NEEDED}
    tables["functions"] = {"want": sorted({*scene.want, *needed})}
    known = name in values or name in scene.runtime
    by = "forcing" if name == AMPLITUDE and scene.forced is not None else name if known and is_planar else ""
    tables["flow"] = {"variational": ["state", by] if by else True}
    return scene_from_dict(tables), values


def _demand_parameter(scene: Scene, name: str) -> None:
    """Refuse what is no parameter of the scene.

    Raises:
        ArrayError: It is none.
    """
    from phichain.contract.words import nearest
    from phichain.errors import ArrayError
    from phichain.orbits.parameter.followed import AMPLITUDE
    from phichain.scene.keys import PARAMETERS

    own = [known for known in PARAMETERS if getattr(scene, known) is not None]
    if name == AMPLITUDE and scene.forced is None:
        raise ArrayError("parameter", name, "is the forcing's, and nothing is forced here", f"add [forcing], or use {', '.join(own)}")
    if name != AMPLITUDE and name not in own:
        problem = "has no value in this scene" if name in PARAMETERS else "is no parameter of a scene"
        best = nearest(name, own)
        raise ArrayError("parameter", name, problem, f"use {', '.join(own)}" + (f" (did you mean {best!r}?)" if best else ""))


def _event(family: Branch, kind: str) -> Any:
    from phichain.errors import ArrayError

    found = next((event for event in family.own_events if event.kind == kind), None)
    if found is None:
        met = ", ".join(dict.fromkeys(event.kind for event in family.own_events))
        remedy = f"it meets {met}; go further by --at, or take one of them" if met else "it meets none; go further by --at"
        raise ArrayError("event", kind, "is not met by the family on the way", remedy)
    return found
