"""simulate at every point: where a motion ends, how well its energy was kept, and the way there if it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.studies.task import (
    Option,
    Output,
    Row,
    Task,
    above_zero,
    count,
    each,
    number,
    numbers,
    truth,
    word,
)

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

OUTCOMES: Final = ("complete", "doubtful", "event", "step budget")
MOST_POINTS: Final = 100_000

STATE: Final = {
    "t": Option(10.0, above_zero, "final time, s"),
    "points": Option(0, count(0, MOST_POINTS), "how many states on the way are kept, evenly spaced, start and end among them; 0 for none"),
    "lean": Option(0.5, number, "start at rest with every link tilted by this, rad, unless q is given"),
    "q": Option(None, numbers, "configuration at the start, nq numbers"),
    "v": Option(None, numbers, "rates at the start, nv numbers"),
    "u": Option(None, numbers, "constant input, nu numbers"),
    "max_steps": Option(1_000_000, count(1, 2**31), "step budget"),
}
"""What every task that moves a chain takes."""


def start(system: System, options: Mapping[str, Any]) -> tuple[Any, Any]:
    """Where a motion begins: as given, else leaning and at rest."""
    from phichain.system.starts import leaning

    rest = leaning(system, options["lean"])
    return tuple(kept if options[name] is None else np.array(options[name]) for name, kept in zip("qv", rest, strict=True))  # type: ignore[return-value]


def ends(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    """What every task that moves a chain leaves."""
    found = {
        "t": Output("time reached", units="s"),
        "q": Output("configuration at the end", {"q_name": scene.nq}),
        "v": Output("rates at the end", {"v_name": scene.nv}),
        "steps": Output("steps taken"),
    }
    if options["points"]:
        found["q_at"] = Output("configuration on the way", {"point": options["points"], "q_name": scene.nq})
        found["v_at"] = Output("rates on the way", {"point": options["points"], "v_name": scene.nv})
    return found


def names(scene: Scene, options: Mapping[str, Any]) -> dict[str, Sequence[Any]]:
    """Names of the entries of q and v."""
    return {"q_name": scene.q_names, "v_name": scene.v_names}


def _one(system: System, point: Point) -> Row:
    from phichain.motion import simulate

    asked = point.options
    points = asked["points"]
    times = np.linspace(0.0, asked["t"], points) if points else asked["t"]
    u = None if asked["u"] is None else np.array(asked["u"])
    motion = simulate(
        system, start(system, asked), times, asked["method"], asked["tol"], u=u, p=point.parameters, h=asked["step"],
        max_steps=asked["max_steps"], error_estimate=asked["error_estimate"],
    )  # fmt: skip
    row: Row = {
        "t": motion.t[-1], "q": motion.q[-1], "v": motion.v[-1], "steps": motion.counts.get("steps", len(motion.t) - 1),
        "outcome": OUTCOMES.index(motion.status), "balance": motion.balance_error, "holds_until": motion.holds_until,
        "error": np.nan if motion.error is None else motion.error[-1],
    }  # fmt: skip
    return row | ({"q_at": motion.q, "v_at": motion.v} if points else {})


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    return {
        **ends(scene, options),
        "outcome": Output("how the run ended", meanings=OUTCOMES),
        "balance": Output("largest departure of the energy's balance E - E_0 - work + loss from zero", units="J"),
        "error": Output("estimated error of the end, relative"),
        "holds_until": Output("last time up to which no error is above what was asked", units="s"),
    }


TASK: Final = Task(
    name="simulate",
    text="phichain.simulate, one motion a point",
    options={
        **STATE,
        "method": Option("auto", word, "auto, or a method by name"),
        "tol": Option(None, above_zero, "relative tolerance"),
        "step": Option(None, above_zero, "step of a fixed-step method, s"),
        "error_estimate": Option(True, truth, "whether the run says how large its errors are"),
    },
    needs=lambda scene, options: ("forward_dynamics",),
    outputs=_outputs,
    labels=names,
    run=each(_one),
    chunk=256,
)
