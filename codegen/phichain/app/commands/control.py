"""The command that makes controllers: `phichain controller`, from a scene to C on the rig."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.app.settings import with_values
from phichain.errors import printable

if TYPE_CHECKING:
    from phichain.control import Gains
    from phichain.laws import Law
    from phichain.system import System

SceneWord = Annotated[
    str, typer.Argument(metavar="SCENE", help="A chain with inputs: a TOML file, a bundled scene's name, or planarN.")
]
Words = list[str] | None


def _named(option: str, metavar: str, text: str) -> Any:
    return typer.Option(option, metavar=metavar, help=text)


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(controller)


def controller(
    scene: SceneWord,
    up: Annotated[str, _named("--up", "LINKS", "Links that stand upright: all, none, or 2,3.")] = "all",
    sample: Annotated[
        float | None, typer.Option(metavar="S", help="Time between two calls, the input held; else in continuous time.")
    ] = None,
    limit: Annotated[str | None, typer.Option(metavar="U,...", help="Largest size of every input, or of all.")] = None,
    target: Annotated[str | None, typer.Option(metavar="X,...", help="Where the cart is to stand, m.")] = None,
    state_weight: Annotated[float, _named("--q", "W", "Weight of the state.")] = 1.0,
    input_weight: Annotated[float, _named("--r", "W", "Weight of the input.")] = 1.0,
    weights: Annotated[Words, _named("--weight", "NAME=W", "Weight of one entry of state or input, as theta_1=100; repeatable.")] = None,
    poles: Annotated[str | None, _named("--poles", "P,...", "Place the closed loop's poles here, 1/s, instead of weighing.")] = None,
    observer: Annotated[str | None, _named("--observer", "KIND", "Measure a part of the state: kalman, or reduced.")] = None,
    measured: Annotated[str | None, _named("--measured", "NAME,...", "What is measured; all positions unless given.")] = None,
    resolution: Annotated[Words, _named("--resolution", "[NAME=]STEP", "Step of a measurement; encoders of 4096 counts, 0.1 mm.")] = None,
    noise: Annotated[Words, _named("--noise", "[NAME=]SIGMA", "Standard deviation of a measurement beside that.")] = None,
    disturbance: Annotated[
        Words, _named("--disturbance", "[NAME=]D", "White noise on an acceleration or input, per sqrt(Hz); 1 on each acceleration.")
    ] = None,
    integral: Annotated[Words, _named("--integral", "NAME[=W]", "Integrate a position, with this weight; repeatable.")] = None,
    table: Annotated[str | None, _named("--table", "all|LINKS;...", 'Gains of several equilibria and a supervisor: all, or "none;2;1,2".')] = None,
    reach: Annotated[float | None, _named("--reach", "RAD", "Largest angle where an equilibrium of the table is taken up; 0.1.")] = None,
    leave: Annotated[float | None, _named("--leave", "LEVEL", "Level where an equilibrium of the table is let go; 4.")] = None,
    settings: Annotated[Words, _named("--set", "NAME=A,B,...", "A runtime parameter's values; repeatable.")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write into.")] = Path("generated"),
) -> None:
    """Write the linear regulator of an equilibrium as a controller in C, DIR/NAME_controller."""
    from phichain.app import control_words as words
    from phichain.laws import OutputTable
    from phichain.pipeline import build, generate_controller
    from phichain.scene.library import find_scene
    from phichain.system.starts import numbers, upright

    chosen = find_scene(scene)
    # Gains are made of double precision, whatever the C is to be.
    wanted = tuple(dict.fromkeys((*chosen.want, "linearization", "forward_dynamics")))
    system = build(replace(chosen, real="double", want=wanted))
    system = with_values(system, chosen, settings)
    bound = numbers(limit, "limit")
    frame = _Frame(
        system, upright(up, system.links), sample, numbers(target, "target"), bound[0] if bound is not None and len(bound) == 1 else bound,
        words.weighed(system, state_weight, input_weight, weights or []), None if poles is None else words.poles(poles),
    )  # fmt: skip
    sensors = {"measured": measured, "resolution": resolution, "noise": noise, "disturbance": disturbance}
    words.demand_together("observer", observer, sensors)
    words.demand_together("table", table, {"reach": reach, "leave": leave})
    if table is not None:
        law = _table(frame, table, {"reach": reach, "leave": leave}, observer, sensors, words.by_name("integral", integral or [], 1.0))
    elif observer is not None or integral:
        law = _output(frame, observer, sensors, words.by_name("integral", integral or [], 1.0))
    else:
        gains = frame.gains()
        typer.echo(str(gains))
        law = gains.law(frame.target, limit=frame.limit)
    law = law.of_scene(chosen.name, chosen.digest) if isinstance(law, OutputTable) else replace(law, name=chosen.name, digest=chosen.digest)
    folder = generate_controller(law, out, chosen.real)
    typer.echo(printable(f"wrote {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}"))


@dataclass(frozen=True)
class _Frame:
    """What every kind of controller is made with."""

    system: System
    signs: tuple[int, ...]
    sample: float | None
    target: Any
    limit: Any
    weights: tuple[list[float], list[float]]
    poles: list[complex] | None

    def gains(self, integrals: bool = False) -> Gains:
        """The regulator; with integrals poles are those of the whole, and are placed there."""
        from phichain.control import lqr, place

        if self.poles is not None and not integrals:
            return place(self.system, self.signs, self.poles, sample=self.sample)
        return lqr(self.system, self.signs, *self.weights, sample=self.sample)


def _table(
    frame: _Frame, text: str, levels: dict[str, float | None], kind: str | None, words: dict[str, Any], integrals: dict[str, float]
) -> Law:
    from phichain.app.control_words import equilibria, sensors_of
    from phichain.control import gain_table, output_table, place, regulators

    signs = equilibria(text, frame.system.links)
    every = regulators(frame.system, signs, *frame.weights, sample=frame.sample)
    if frame.poles is not None and not integrals:
        every = tuple(place(frame.system, one.s, frame.poles, sample=frame.sample) for one in every)
    for gains in every:
        typer.echo(str(gains))
    given: dict[str, Any] = {name: value for name, value in levels.items() if value is not None}
    if kind is None and not integrals:
        return gain_table(every, frame.target, limit=frame.limit, **given)
    table = output_table(every, kind, sensors_of(**words), integrals, frame.target, poles=frame.poles if integrals else None, limit=frame.limit, **given)
    typer.echo(str(table))
    return table


def _output(frame: _Frame, kind: str | None, words: dict[str, Any], integrals: dict[str, float]) -> Law:
    from phichain.app.control_words import sensors_of
    from phichain.control import estimator, output_law, with_integrals

    gains = frame.gains(bool(integrals))
    if frame.poles is None or not integrals:
        typer.echo(str(gains))
    estimate = None
    if kind is not None:
        estimate = estimator(gains, sensors_of(**words), kind)
        typer.echo(str(estimate))
    integrating = with_integrals(gains, integrals, frame.poles) if integrals else None
    if integrating is not None:
        typer.echo(str(integrating))
    return output_law(gains, estimate, integrating, frame.target, limit=frame.limit)
