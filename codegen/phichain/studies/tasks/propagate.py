"""propagate at every point, many motions in one call of the emitted batch flow: tens of microseconds each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.errors import UnsupportedError
from phichain.studies.task import Failure, Option, Output, Row, Task, above_zero, failed
from phichain.studies.tasks.simulate import STATE, ends, names, start
from phichain.system.propagation import OUTCOMES

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

ROUND_OFF: Final = 1e-15


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    if scene.real != "double":
        raise UnsupportedError("task.run", "propagate", 'serves scenes of doubles', 'use run = "simulate", or real = "double"')
    return ("propagate_batch",)


def _run(system: System, points: Sequence[Point]) -> list[Row | Failure]:
    """All points that share runtime parameters and everything but start, end and input in one call."""
    found: dict[int, Row | Failure] = {}
    groups: dict[str, list[int]] = {}
    for k, point in enumerate(points):
        shared = (point.parameters, *(point.options[name] for name in ("tol", "points", "max_steps")))
        alone = (point.options["t"],) if point.options["points"] else ()
        groups.setdefault(repr((shared, alone)), []).append(k)
    for members in groups.values():
        found |= zip(members, _together(system, [points[k] for k in members]), strict=True)
    return [found[k] for k in range(len(points))]


def _together(system: System, points: Sequence[Point]) -> list[Row | Failure]:
    """One call; where it is refused, each point alone, so that the refusal is recorded where it belongs."""
    try:
        return _called(system, points)
    except Exception as failure:  # noqa: BLE001 - recorded, as every failure of a task
        if len(points) == 1:
            return [failed(failure)]
        return [row for point in points for row in _together(system, [point])]


def _called(system: System, points: Sequence[Point]) -> list[Row | Failure]:
    asked = points[0].options
    starts = [start(system, point.options) for point in points]
    q, v = (np.array([one[k] for one in starts]) for k in (0, 1))
    t_end = np.array([point.options["t"] for point in points])
    times = np.linspace(0.0, asked["t"], asked["points"]) if asked["points"] else np.zeros(0)
    zero = [0.0] * system.nu
    u = np.array([zero if point.options["u"] is None else point.options["u"] for point in points]) if system.nu else None
    batch = system.propagate_batch(
        q, v, 0.0, t_end, asked["tol"], u=u, times=times, max_steps=asked["max_steps"], p=points[0].parameters, workers=1
    )
    columns: dict[str, Any] = {
        "t": batch.t, "q": batch.q, "v": batch.v, "steps": batch.steps, "outcome": [OUTCOMES.index(word) for word in batch.outcome]
    }  # fmt: skip
    if asked["points"]:
        columns |= {"q_at": batch.q_at, "v_at": batch.v_at}
    return [{name: values[k] for name, values in columns.items()} for k in range(len(points))]


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    return {**ends(scene, options), "outcome": Output("how the run ended", meanings=OUTCOMES)}


TASK: Final = Task(
    name="propagate",
    text="the emitted Taylor flow in its batch form",
    options={**STATE, "tol": Option(ROUND_OFF, above_zero, "relative tolerance of a step; round-off unless given")},
    needs=_needs,
    outputs=_outputs,
    labels=names,
    run=_run,
    chunk=4096,
)
