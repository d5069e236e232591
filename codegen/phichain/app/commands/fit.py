"""The command `phichain fit`: a scene's runtime parameters from a measured motion."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app import said
from phichain.app.outputs import figures, named, out_option, write
from phichain.errors import ArrayError, printable
from phichain.files import write_file

if TYPE_CHECKING:
    from phichain.identification import Fit
    from phichain.scene import Scene

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A chain with runtime parameters: a TOML file, a bundled scene's name, or planarN.")
]
DataFile = Annotated[
    Path, typer.Argument(metavar="DATA.csv", help="Columns by name: t, angles theta_1 .., rates theta_dot_1 .., a cart's x, inputs.")
]
OutFiles = Annotated[list[Path] | None, out_option("Write the result: .json (all numbers), .csv (data, fit, residuals), .png or .toml (the scene with them)")]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(fit)


def fit(
    scene: SceneWord,
    data: DataFile,
    start: Annotated[
        list[str] | None, typer.Option("--start", metavar="NAME=A,B,...", help="Fit this parameter, from here; repeatable.")
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter that is known; repeatable.")
    ] = None,
    fixed: Annotated[
        list[str] | None, typer.Option("--fix", metavar="NAME_K", help="A number of --start that is known, as mass_1; repeatable.")
    ] = None,
    state: Annotated[
        str | None, typer.Option("--x0", metavar="A,B,...", help="Guess of the first state (q, v), else from the first rows.")
    ] = None,
    fit_start: Annotated[bool, typer.Option("--fit-state/--keep-state", help="Fit the first state, or take --x0 as known.")] = True,
    linear: Annotated[bool, typer.Option("--linear", help="Straight lines between the rows of inputs, not held values.")] = False,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Fit a chain's runtime parameters to a measured motion, and say how well the data tell them."""
    from phichain.app.summaries import printed
    from phichain.identification import fit as fitted
    from phichain.identification import read_measurement
    from phichain.origin import origin
    from phichain.pipeline import build
    from phichain.scene.library import find_scene
    from phichain.system.starts import numbers, parameters

    files = named(out, (".json", ".csv", ".png", ".toml"))
    if not fit_start and state is None:
        raise ArrayError("keep-state", True, "keeps a first state that was not given", "give --x0 too")
    chosen = find_scene(scene)
    sought = parameters(start or []) or {}
    system = replace(build(followed(chosen, sought)), digest=chosen.digest)
    measured = read_measurement(system, data)
    found = fitted(
        system, measured, sought, fixed=fixed or [], p=parameters(settings or []),
        x0=numbers(state, "x0"), fit_start=fit_start, between="linear" if linear else "held",
    )  # fmt: skip
    said.say(found, quiet, as_json)
    scenes = [path for path in files if path.suffix == ".toml"]
    text = f"# {printed(origin(found))}\n{filled(chosen, found).to_toml()}" if scenes else ""
    write(found, [path for path in files if path not in scenes], lambda: figures().fitted(found), quiet=quiet or as_json)
    for path in scenes:
        write_file(path, text)
        if not (quiet or as_json):
            typer.echo(printable(f"wrote {path}"))


def followed(scene: Scene, sought: Iterable[str] = ()) -> Scene:
    """The same chain in double precision, with the functions by which its motion is followed, derivatives by what is sought included."""
    from phichain.contract.functions import ROWS
    from phichain.identification.model import TOLERANCES
    from phichain.scene.load import scene_from_dict

    tables: dict[str, Any] = scene.to_dict()
    flow = next((name for name in TOLERANCES if ROWS[name].absence(scene) is None), "forward_dynamics")
    tables["functions"] = {"want": ["forward_dynamics", flow]}
    tables.pop("flow", None)
    if flow == "propagate" and scene.is_planar and (varied := [name for name in sought if name in scene.runtime]):
        tables["flow"] = {"variational": ["state", *varied]}
    tables["target"] = {**tables.get("target", {}), "real": "double"}
    return scene_from_dict(tables)


def filled(scene: Scene, found: Fit) -> Scene:
    """The scene with the fitted values in the place of "runtime".

    Raises:
        SceneError: They make no scene, as where a centre of mass without inertia came to lie beyond its link.
    """
    from phichain.scene.load import scene_from_dict

    tables = scene.to_dict()
    for name, value in found.p.items():
        table = next(entries for entries in tables.values() if isinstance(entries, dict) and name in entries)
        table[name] = value if isinstance(value, float) else [float(entry) for entry in value]
    return scene_from_dict(tables)
