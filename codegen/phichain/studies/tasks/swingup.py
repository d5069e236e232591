"""swingup at every point: a motion between equilibria, the law along it, and in which share of its trials that holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.errors import StudyError
from phichain.studies.task import Option, Output, Row, Task, above_zero, count, each, from_zero, share, word

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System


def _one(system: System, point: Point) -> Row:
    from dataclasses import replace

    from phichain.system.starts import upright
    from phichain.trials import swing_up

    asked = point.options
    if asked["limit"] is None:
        raise StudyError("task.limit", None, "says how large inputs may be, and is not given", "write limit = 20.0 under [task], or vary task.limit")
    errors = {"mass": asked["error_mass"]} if asked["error_mass"] else {}
    found = swing_up(
        replace(system, digest=point.digest, params=point.parameters), limit=asked["limit"], rail=asked["rail"],
        start=upright(asked["from"], system.links), target=upright(asked["to"], system.links), errors=errors, spread=asked["spread"],
        sample=asked["sample"], seconds=asked["seconds"], runs=asked["runs"], enough=asked["enough"], count=asked["starts"], solver=asked["solver"],
    )  # fmt: skip
    low, high = found.trials.interval
    return {
        "share": found.trials.share, "share_low": low, "share_high": high, "duration": found.plan.duration, "defect": found.plan.defect,
        "largest_u": np.max(np.abs(found.plan.u)), "farthest": np.max(np.abs(found.plan.x[:, 0])) if system.has_cart else np.nan,
        "cost": found.plan.cost, "starts": len(found.tried),
    }  # fmt: skip


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    if scene.nu == 0 or not scene.is_planar:
        raise StudyError("task.run", "swingup", "moves planar chains by their inputs", 'take a planar scene, such as actuated = "cart" in [joints]')
    return ("forward_dynamics", "linearization")


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    return {
        "share": Output("share of the trials that held the target"),
        "share_low": Output("lower end of its 95 % interval (Clopper and Pearson)"),
        "share_high": Output("its upper end"),
        "duration": Output("duration of the motion", units="s"),
        "defect": Output("how far the chain, led along the optimum, leaves it"),
        "largest_u": Output("largest input of the plan"),
        "farthest": Output("largest distance of the cart from 0", units="m"),
        "cost": Output("cost of the plan"),
        "starts": Output("starts of the search that were followed"),
    }


TASK: Final = Task(
    name="swingup",
    text="phichain.swing_up, one search a point",
    options={
        "limit": Option(None, above_zero, "largest size of every input"),
        "rail": Option(None, above_zero, "how far the cart may go to either side, m"),
        "from": Option("none", word, "links that stand at the start"),
        "to": Option("all", word, "links that stand at the end: all, none, or 2,3"),
        "error_mass": Option(0.0, share, "largest relative error of the masses"),
        "spread": Option(0.05, from_zero, "largest error of the angles at the start, rad"),
        "sample": Option(1e-3, above_zero, "time between two calls of the law, s"),
        "seconds": Option(None, above_zero, "duration of the motion, s; several are tried unless given"),
        "runs": Option(200, count(2, 100_000), "trials of the compiled law"),
        "enough": Option(0.95, share, "end the search with a law that holds in such a share of its runs"),
        "starts": Option(12, count(1, 10_000), "starts of the search at most"),
        "solver": Option("fatrop", word, "fatrop or ipopt"),
    },
    needs=_needs,
    outputs=_outputs,
    labels=lambda scene, options: {},
    run=each(_one),
    chunk=1,
)
