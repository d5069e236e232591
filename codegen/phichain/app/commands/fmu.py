"""The command `phichain fmu`: a scene as a file that simulation tools open."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from phichain.errors import printable


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(fmu)


def fmu(
    scene: Annotated[
        str, typer.Argument(metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links.")
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.fmu", help="The file; the scene's name unless given.")] = None,
    proof: Annotated[bool, typer.Option("--proof/--no-proof", help="Prove the functions against the Lagrangian first.")] = True,
) -> None:
    """Write a scene as an FMU of FMI 3.0, for Model Exchange and Co-Simulation."""
    from phichain.app.outputs import named
    from phichain.exchange import write_fmu
    from phichain.scene.library import find_scene

    named([out] if out else None, (".fmu",))
    typer.echo(printable(f"wrote {write_fmu(find_scene(scene), out, proof)}"))
