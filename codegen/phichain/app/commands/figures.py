"""The commands that draw: `phichain figure` for the figures of both papers, `phichain propagation` for any planar scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from phichain.app.settings import Settings, values_given
from phichain.errors import printable

FigureNames = Annotated[
    list[str], typer.Argument(metavar="NAME...", help="A2 .. A7 of paper A, B2 .. B4 of paper B, E2 .. E4, G4, N2, C2 and U2 of families, or all.")
]
PlanarScene = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="A planar chain: a TOML file, a bundled scene's name, or planarN."),
]
Folder = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")]


def register(app: typer.Typer) -> None:
    """Add both commands to the command line."""
    app.command()(figure)
    app.command()(propagation)


def figure(names: FigureNames, out: Folder = Path("generated/figures")) -> None:
    """Draw figures of the two papers: PNG, and interactive HTML for signal propagation (A3 .. A6)."""
    from phichain.papers.figures import FIGURES, draw, known

    wanted = list(FIGURES) if "all" in names else [known(name) for name in names]
    for name in wanted:
        typer.echo(printable(f"{name}: wrote {', '.join(str(path) for path in draw(name, out))}"))


def propagation(
    scene: PlanarScene,
    t: Annotated[float, typer.Option("--t", metavar="S", help="Final time in seconds.")] = 2.0,
    samples: Annotated[
        int, typer.Option(min=21, help="Samples of the motion; the quadrature converges with them.")
    ] = 4001,
    order: Annotated[int, typer.Option(min=1, max=6, help="Order of the quadrature.")] = 4,
    lean: Annotated[
        float, typer.Option(metavar="RAD", help="Start at rest, the straight chain leaning by this angle.")
    ] = 0.5,
    q: Annotated[str | None, typer.Option(metavar="A,B,...", help="Start here instead (nq numbers).")] = None,
    v: Annotated[
        str | None, typer.Option(metavar="A,B,...", help="Start with these rates (nv numbers).")
    ] = None,
    u: Annotated[str | None, typer.Option(metavar="A,B,...", help="A constant input (nu numbers).")] = None,
    settings: Settings = None,
    out: Folder = Path("generated/figures"),
) -> None:
    """Follow a chain's signals from forces to angles, over (t, p) and (t, alpha): two PNG sheets and an interactive page."""
    from phichain.papers.signals import draw_signals, released, signal_system
    from phichain.scene.library import find_scene
    from phichain.system.starts import numbers

    chosen = find_scene(scene)
    start = {field: numbers(text, field) for field, text in (("q", q), ("v", v), ("u", u))}
    system = signal_system(chosen, values_given(chosen, settings) or None)
    result = released(system, t, samples, order, lean=lean, **start)
    typer.echo(str(result))
    typer.echo(printable(f"wrote {', '.join(str(path) for path in draw_signals(chosen, result, out))}"))
