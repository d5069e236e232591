"""montecarlo at every point: a sampled regulator in float C on compiled chains that are wrong in many ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from phichain.errors import StudyError
from phichain.studies.regulator import SAMPLED, demand_inputs, regulator
from phichain.studies.task import (
    Option,
    Output,
    Row,
    Task,
    above_zero,
    count,
    each,
    from_zero,
    share,
)

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

WRONG: Final = ("mass", "length", "com", "inertia", "damping")
"""Parameters that may be wrong, by `error_NAME`."""


def _one(system: System, point: Point) -> Row:
    from phichain.pipeline import generate_controller
    from phichain.trials import Disturbed, law_on_file, law_trials

    asked = point.options
    gains = regulator(system, asked)
    errors = {name: size for name in WRONG if (size := asked[f"error_{name}"])}
    with TemporaryDirectory() as folder:
        made = law_on_file(generate_controller(gains.law(limit=asked["limit"]), Path(folder), "float"))
        disturbed = Disturbed(errors, {}, asked["spread"], asked["late"], {})
        found = law_trials(point.scene, made, disturbed, seconds=asked["seconds"], hold=asked["hold"], runs=asked["runs"], seed=asked["seed"])
    low, high = found.interval
    return {"share": found.share, "share_low": low, "share_high": high}


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    demand_inputs(scene, "montecarlo")
    if scene.runtime:
        raise StudyError("task.run", "montecarlo", "varies the numbers of chains that say them", "write them into the scene, or use attraction")
    return ("linearization", "forward_dynamics")


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    return {
        "share": Output("share of the runs that held the target"),
        "share_low": Output("lower end of its 95 % interval (Clopper and Pearson)"),
        "share_high": Output("its upper end"),
    }


TASK: Final = Task(
    name="montecarlo",
    text="phichain.trials.law_trials, one sampled regulator in float C a point",
    options={
        **SAMPLED,
        **{f"error_{name}": Option(0.0, share, f"largest relative error of {name}") for name in WRONG},
        "spread": Option(0.05, from_zero, "largest error of the angles at the start, rad"),
        "late": Option(0.0, from_zero, "time by which inputs come late at most, s"),
        "seconds": Option(None, above_zero, "how long the law may take, s; by the chain unless given"),
        "hold": Option(2.0, above_zero, "how long the target must be held then, s"),
        "runs": Option(200, count(1, 1_000_000), "how many"),
        "seed": Option(1, count(0, 2**31 - 1), "of the draws"),
    },
    needs=_needs,
    outputs=_outputs,
    labels=lambda scene, options: {},
    run=each(_one),
    chunk=16,
)
