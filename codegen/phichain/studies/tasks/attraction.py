"""attraction at every point: from how far off a sampled regulator brings the chain back, by simulation of the emitted closed loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from phichain.errors import StudyError
from phichain.studies.regulator import SAMPLED, demand_inputs, regulator
from phichain.studies.task import Option, Output, Row, Task, above_zero, count, each

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

LONGEST: Final = 1e-3
"""Longest step of the chain, s."""
RADIUS: Final = "2-norm over the links' turns"


def _one(system: System, point: Point) -> Row:
    from phichain.control import gain_table
    from phichain.control.reach import attraction
    from phichain.pipeline import build_closed_loop

    asked = point.options
    gains = regulator(system, asked)
    laws = gain_table([gains], limit=asked["limit"])
    flown = build_closed_loop(point.scene, laws, point.scene.real, LONGEST)
    found = attraction(system, laws, flown, count=asked["directions"], seconds=asked["seconds"], seed=asked["seed"])
    return {name: getattr(found, name)[0] for name in ("radius", "beyond", "usual", "failed", "share", "runs")}


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    demand_inputs(scene, "attraction")
    if scene.runtime:
        raise StudyError("task.run", "attraction", f"compiles the chain's numbers, and {scene.runtime[0]} comes at run time", "write its value into the scene")
    return ("linearization", "forward_dynamics", "step")


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    return {
        "radius": Output(f"radius from which every direction came home, {RADIUS}"),
        "beyond": Output("least radius from which one did not; infinite where all came home"),
        "usual": Output("radius from which 98 of 100 directions came home"),
        "failed": Output("starts in the ball that did not come home"),
        "share": Output("with 95 % confidence no more than this share of the ball does not"),
        "runs": Output("simulations"),
    }


TASK: Final = Task(
    name="attraction",
    text="phichain.control.reach.attraction, one sampled regulator a point",
    options={
        **SAMPLED,
        "seconds": Option(15.0, above_zero, "time within which a start must come home, s"),
        "directions": Option(200, count(2, 100_000), "directions, and starts drawn from the ball"),
        "seed": Option(0, count(0, 2**31 - 1), "of directions and starts"),
    },
    needs=_needs,
    outputs=_outputs,
    labels=lambda scene, options: {},
    run=each(_one),
    chunk=16,
)
