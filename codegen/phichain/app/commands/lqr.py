"""The command `phichain lqr`: a regulator, tried on the nonlinear chain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from phichain.app import said
from phichain.app.outputs import figures, named, out_option, write
from phichain.app.settings import Settings, with_values

SceneWord = Annotated[str, typer.Argument(metavar="SCENE", help="A TOML file, a bundled scene's name, or planarN: paper A's chain of N links.")]
OutFiles = Annotated[list[Path] | None, out_option("Write the result: .csv, .npz, .json, .png, .svg or .pdf by its name")]
TRIAL_STEPS = 5_000
"""A regulator that fails flings the chain about; its trial is not worth more steps than this."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(lqr)


def lqr(
    scene: SceneWord,
    up: Annotated[str, typer.Option(metavar="LINKS", help="Links that stand upright: all, none, or 2,3.")] = "all",
    state_weight: Annotated[float, typer.Option("--q", metavar="W", help="Weight of the state.")] = 1.0,
    input_weight: Annotated[float, typer.Option("--r", metavar="W", help="Weight of the input.")] = 1.0,
    lean: Annotated[float, typer.Option(metavar="RAD", help="Try it with every link this far off.")] = 1e-3,
    t: Annotated[float, typer.Option("--t", metavar="S", help="How long to try it.")] = 20.0,
    settings: Settings = None,
    out: OutFiles = None,
    quiet: said.Quiet = False,
    as_json: said.AsJson = False,
) -> None:
    """Synthesise the linear regulator of an equilibrium, and try it on the nonlinear chain."""
    import numpy as np

    from phichain import control
    from phichain.motion import simulate as simulated
    from phichain.pipeline import build as built
    from phichain.scene.library import find_scene
    from phichain.system.starts import leaning, upright

    files = named(out)
    chosen = find_scene(scene)
    system = with_values(built(chosen), chosen, settings)
    gains = control.lqr(system, upright(up, system.links), state_weight, input_weight)
    said.say(gains, quiet, as_json)
    law = control.feedback(system, gains)
    start = leaning(system, lean, gains.s)
    motion = simulated(system, start, np.linspace(0.0, t, 1001), tol=1e-8, u=law, max_steps=TRIAL_STEPS)
    off, rate = control.errors(system, gains, motion.x)
    verdict = "brought back" if motion.status == "complete" and off[-1] < 0.1 * off[0] else "not brought back"
    said.say(
        f"tried from {lean:g} rad off: {verdict}, e_q = {off[0]:.3g} at first, {off[-1]:.3g} at {motion.t[-1]:g} s,"
        f" largest input {np.max(np.abs(np.asarray(motion.u))):.3g}",
        quiet or as_json, False,
    )  # fmt: skip
    write(gains, files, lambda: figures().closed_loop(system, motion, off, rate), quiet=quiet or as_json)
