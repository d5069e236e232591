"""lqr at every point: the regulator of an equilibrium, its slowest pole and its margin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.studies.regulator import UP, demand_inputs, regulator
from phichain.studies.task import Option, Output, Row, Task, above_zero, each, number

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System


def _weight(name: str, value: Any) -> float | list[float]:
    if isinstance(value, list | tuple):
        return [number(f"{name}[{k}]", entry) for k, entry in enumerate(value, 1)]
    return number(name, value)


def _freedoms(scene: Scene) -> int:
    """Length of z = (x, x'): two tangent coordinates for a link in space, one in the plane, and the cart's."""
    cart = (1 if scene.is_planar else 2) * scene.has_cart
    return 2 * (cart + scene.links * (1 if scene.is_planar else 2))


def _one(system: System, point: Point) -> Row:
    asked = point.options
    gains = regulator(system, asked, point.parameters)
    return {
        "K": gains.K, "decay": gains.decay, "margin": gains.margin, "residual": gains.residual, "gain": np.max(np.abs(gains.K)),
        "pole_re": gains.poles.real, "pole_im": gains.poles.imag,
    }  # fmt: skip


def _needs(scene: Scene, options: Mapping[str, Any]) -> Sequence[str]:
    demand_inputs(scene, "lqr")
    return ("linearization", "forward_dynamics")


def _outputs(scene: Scene, options: Mapping[str, Any]) -> dict[str, Output]:
    state = _freedoms(scene)
    return {
        "K": Output("gains of u = -K z", {"u_name": scene.nu, "state": state}),
        "decay": Output("slowest decay rate of the closed loop", units="1/s"),
        "margin": Output("smallest controllability margin"),
        "residual": Output("relative residual of the Riccati equation"),
        "gain": Output("largest gain"),
        "pole_re": Output("poles of the closed loop, slowest first, real part", {"pole": state}, "1/s"),
        "pole_im": Output("their imaginary part", {"pole": state}, "rad/s"),
    }


def _labels(scene: Scene, options: Mapping[str, Any]) -> dict[str, Sequence[Any]]:
    return {"u_name": scene.u_names}


TASK: Final = Task(
    name="lqr",
    text="phichain.lqr, one regulator a point",
    options={
        "up": UP,
        "state_weight": Option(1.0, _weight, "weight of the state: a number or the diagonal"),
        "input_weight": Option(1.0, _weight, "weight of the input: a number or the diagonal"),
        "sample": Option(None, above_zero, "time between two samples, s; continuous unless given"),
    },
    needs=_needs,
    outputs=_outputs,
    labels=_labels,
    run=each(_one),
    chunk=256,
)
