"""What tasks of one sampled regulator a point share: their options, what they ask of a scene, and the regulator itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from phichain.errors import StudyError
from phichain.studies.task import Option, above_zero, number, word

if TYPE_CHECKING:
    from phichain.control import Gains
    from phichain.scene import Scene
    from phichain.system import System

UP: Final = Option("all", word, "links that stand upright: all, none, or numbers like 2,3")
SAMPLED: Final[Mapping[str, Option]] = {
    "up": UP,
    "sample": Option(1e-3, above_zero, "time between two calls of the law, s"),
    "limit": Option(None, above_zero, "largest size of every input; none unless given"),
    "state_weight": Option(1.0, number, "weight of the state"),
    "input_weight": Option(1.0, number, "weight of the input"),
}


def demand_inputs(scene: Scene, task: str) -> None:
    """Refuse a scene that nothing can be regulated by.

    Raises:
        StudyError: It has no inputs.
    """
    if scene.nu == 0:
        raise StudyError("task.run", task, "regulates by inputs, and the scene has none", 'actuate it, such as actuated = "all" in [joints]')


def regulator(system: System, asked: Mapping[str, Any], p: Mapping[str, Any] | None = None) -> Gains:
    """The regulator that a point's options ask for."""
    from phichain.control import lqr
    from phichain.system.starts import upright

    return lqr(system, upright(asked["up"], system.links), asked["state_weight"], asked["input_weight"], sample=asked["sample"], p=p)
