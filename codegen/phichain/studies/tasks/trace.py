"""trace at every point: a family of limit cycles, its amplitude, rate and energy from point to point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.studies.task import Option, Output, Row, Task, above_zero, count, each, word

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

STATUS: Final = ("event", "closed", "points", "step", "interrupted")
MOST_POINTS: Final = 5000


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    from phichain.orbits.shooting import NEEDED

    return ("phi", "phi_jacobian") if options["method"] == "one harmonic" else NEEDED


def _one(system: System, point: Point) -> Row:
    from phichain.orbits import trace

    asked = point.options
    limits = {name: asked[name] for name in ("max_points", "step_max") if asked[name] is not None}
    end = 3.0 if asked["until"] is None and asked["amplitude_max"] is None else asked["amplitude_max"]
    branch: Any = trace(
        system, asked["mode"], end, method=asked["method"], until=asked["until"], through=asked["through"],
        p=point.parameters, limits=limits,
    )  # fmt: skip
    room, kept = asked["max_points"], min(len(branch), asked["max_points"])
    angles = branch.points[:, :-1]

    def padded(values: Any) -> np.ndarray:
        column = np.full(room, np.nan)
        column[:kept] = values[:kept]
        return column

    return {
        "count": len(branch), "outcome": STATUS.index(branch.status), "events": len(branch.events),
        "arclength": padded(branch.arclength), "omega": padded(branch.column("omega")),
        "amplitude": padded(np.max(np.abs(angles), axis=1)),
        "energy": padded(np.full(kept, np.nan) if branch.energy is None else branch.energy),
    }  # fmt: skip


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    along = {"point": options["max_points"]}
    return {
        "count": Output("points of the family"),
        "outcome": Output("why the run ended", meanings=STATUS),
        "events": Output("events on the way"),
        "arclength": Output("arclength", along),
        "omega": Output("rate of the oscillation", along, "rad/s"),
        "amplitude": Output("largest angle at the start of the period", along, "rad"),
        "energy": Output("total energy", along, "J"),
    }


TASK: Final = Task(
    name="trace",
    text="phichain.trace, one family a point",
    options={
        "mode": Option(1, count(1, 4096), "mode to start from, by rising linear frequency"),
        "method": Option("auto", word, "shooting, one harmonic, or auto"),
        "until": Option(None, word, "end exactly there, WHAT=VALUE"),
        "amplitude_max": Option(None, above_zero, "end where the largest angle reaches this, rad; 3 unless until is given"),
        "through": Option(None, above_zero, "half width of gaps to cross, in arclength"),
        "step_max": Option(None, above_zero, "largest step, in arclength"),
        "max_points": Option(400, count(2, MOST_POINTS), "points after which a run ends, and the room that each family takes"),
    },
    needs=_needs,
    outputs=_outputs,
    labels=lambda scene, options: {},
    run=each(_one),
    chunk=16,
    is_variational=True,
)
