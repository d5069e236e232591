"""The command that makes controllers: `phichain controller`, from a scene to C on the rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.contract.words import nearest
from phichain.errors import ArrayError, printable

if TYPE_CHECKING:
    from phichain.control import Gains
    from phichain.system import System

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A chain with inputs: a TOML file, a bundled scene's name, or planarN.")
]
Weights = Annotated[
    list[str] | None,
    typer.Option("--weight", metavar="NAME=W", help="Weight of one entry of state or input, as theta_1=100; repeatable."),
]


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(controller)


def controller(
    scene: SceneWord,
    up: Annotated[str, typer.Option(metavar="LINKS", help="Links that stand upright: all, none, or 2,3.")] = "all",
    sample: Annotated[
        float | None, typer.Option(metavar="S", help="Time between two calls, the input held; else in continuous time.")
    ] = None,
    limit: Annotated[str | None, typer.Option(metavar="U,...", help="Largest size of every input, or of all.")] = None,
    target: Annotated[str | None, typer.Option(metavar="X,...", help="Where the cart is to stand, m.")] = None,
    state_weight: Annotated[float, typer.Option("--q", metavar="W", help="Weight of the state.")] = 1.0,
    input_weight: Annotated[float, typer.Option("--r", metavar="W", help="Weight of the input.")] = 1.0,
    weights: Weights = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter's values; repeatable.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")] = Path("generated"),
) -> None:
    """Write the linear regulator of an equilibrium as a controller in C, DIR/NAME_controller."""
    from phichain.control import lqr
    from phichain.pipeline import build, generate_controller
    from phichain.scene.library import find_scene
    from phichain.system.starts import numbers, parameters, upright

    chosen = find_scene(scene)
    # Gains are made of double precision, whatever the C is to be.
    wanted = tuple(dict.fromkeys((*chosen.want, "linearization", "forward_dynamics")))
    system = build(replace(chosen, real="double", want=wanted))
    system = replace(system, params=parameters(settings or []) or None)
    signs = upright(up, system.links)
    Q, R = weighed(system, state_weight, input_weight, weights or [])
    gains = lqr(system, signs, Q, R, sample=sample)
    law = _law(gains, numbers(limit, "limit"), numbers(target, "target"))
    law = replace(law, name=chosen.name, digest=chosen.digest)
    folder = generate_controller(law, out, chosen.real)
    typer.echo(str(gains))
    typer.echo(printable(f"wrote {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}"))


def _law(gains: Gains, limit: Any, target: Any) -> Any:
    bound = limit[0] if limit is not None and len(limit) == 1 else limit
    return gains.law(target, limit=bound)


def weighed(system: System, state: float, push: float, words: Sequence[str]) -> tuple[list[float], list[float]]:
    """The diagonals of Q and R: one weight for all, others by name.

    Args:
        system: Whose state and inputs they weigh.
        state: Weight of every entry of the state.
        push: Weight of every input.
        words: NAME=W, the name of an entry of (q, v) in the plane, of the coordinates of (19) in space, or of an input.

    Raises:
        ArrayError: A word is not of that kind, or names nothing that is weighed.
    """
    from phichain.control import linearize

    names = linearize(system, (1,) * system.links).state_names
    alias = dict(zip((*system.q_names, *system.v_names), names, strict=True)) if system.is_planar else {}
    known = {**{name: (0, i) for i, name in enumerate(names)}, **{name: (1, i) for i, name in enumerate(system.u_names)}}
    diagonals = [state] * len(names), [push] * system.nu
    for word in words:
        name, _, text = word.partition("=")
        at = known.get(alias.get(name.strip(), name.strip()))
        if at is None:
            best = nearest(name, tuple(known))
            raise ArrayError("weight", word, "weighs nothing of this chain", f'did you mean "{best}"? There are {", ".join(known)}')
        try:
            diagonals[at[0]][at[1]] = float(text)
        except ValueError:
            raise ArrayError("weight", word, "has no number behind its name", f"write {name}=100") from None
    return diagonals
