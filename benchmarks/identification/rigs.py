"""Rigs that are measured: chains whose numbers are known, the motion they make, and noise on what an encoder sees of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.system import System

Array = NDArray[np.float64]
Numbers = Mapping[str, float | list[float]]
NOISE = 1e-3
"""Of the spread of each column."""
AWAY = 0.3
"""Fits begin at most this far from the truth, of it."""


@dataclass(frozen=True)
class Rig:
    """A chain, what is sought of it, and how it moves.

    Attributes:
        name: Of the scene.
        about: What it is, for the table.
        links: How many.
        keys: Its scene, but for what is left to run time.
        truth: Its runtime parameters.
        known: Numbers of these that were weighed, such as "mass_1".
        x0: Where it starts.
        span: Seconds that are measured, and rows a second.
        push: Amplitude and frequency, rad/s, of what drives it; nothing does where the amplitude is zero.
    """

    name: str
    about: str
    links: int
    keys: Mapping[str, Any]
    truth: Numbers
    known: tuple[str, ...]
    x0: tuple[float, ...]
    span: tuple[float, int] = (10.0, 500)
    push: tuple[float, float] = (0.0, 0.0)

    @property
    def scene(self) -> Scene:
        """The chain as `phichain fit` builds it."""
        from phichain.app.commands.fit import followed
        from phichain.scene import Scene

        return followed(Scene(self.name, self.links, **self.keys, **dict.fromkeys(self.truth, "runtime")), self.truth)

    @property
    def true(self) -> dict[str, float]:
        """Every number that is sought, by the name that a Fit gives it."""
        numbers: dict[str, float] = {}
        for name, value in self.truth.items():
            numbers |= {f"{name}_{k}": x for k, x in enumerate(value, 1)} if isinstance(value, list) else {name: value}
        return {name: value for name, value in numbers.items() if name not in self.known}

    def begun(self, rng: np.random.Generator) -> Numbers:
        """Starting values off the truth, but for what is known."""

        def off(name: str, value: float) -> float:
            return value if name in self.known else value * (1 + AWAY * rng.uniform(-1, 1))

        return {
            name: [off(f"{name}_{k}", x) for k, x in enumerate(value, 1)] if isinstance(value, list) else off(name, value)
            for name, value in self.truth.items()
        }


_PAIR: Mapping[str, Any] = {"mass": [0.3, 0.2], "com": [0.15, 0.12], "inertia": [0.003, 0.001], "damping": [0.002, 0.001]}
_WEIGHED = ("mass_1", "mass_2", "com_1")
RIGS = (
    Rig(
        "fitted_double", "double pendulum, damped joints", 2, {"length": [0.3, 0.25]}, _PAIR, _WEIGHED, (1.5, 0.5, 0.0, 0.0),
    ),
    Rig(
        "fitted_dry_double", "the same, with dry friction in both joints", 2, {"length": [0.3, 0.25], "friction_speed": 0.5},
        {**_PAIR, "friction": [0.002, 0.001]}, _WEIGHED, (1.5, 0.5, 0.0, 0.0),
    ),
    Rig(
        "fitted_cart_pole", "rod on a cart with viscous and dry friction", 1,
        {"base": "cart", "length": 0.6413, "actuated": "none", "cart_friction_speed": 0.05},
        {"mass": [0.23], "com": [0.32], "inertia": [0.0079], "cart_mass": 1.073, "cart_damping": 0.8, "cart_friction": 0.3, "damping": [0.0024]},
        ("mass_1", "com_1"), (0.0, 2.4, 0.0, 0.0),
    ),
    Rig(
        "fitted_acrobot", "Acrobot, its torque known, 50 Hz", 2, {"length": 1.0, "gravity": 9.8, "actuated": [2]},
        {"mass": [1.0, 1.0], "com": [0.5, 0.5], "inertia": [1.0, 1.0], "damping": [0.1, 0.1]},
        ("mass_1", "mass_2", "com_1"), (0.6, -0.3, 0.0, 0.0), (10.0, 50), (4.0, 2.5),
    ),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Motion:
    """What a rig does, without noise.

    Attributes:
        system: The chain, compiled.
        t: Times (m,).
        seen: Angles, and a cart's place, by name.
        given: Inputs by name.
    """

    system: System
    t: Array
    seen: Mapping[str, Array]
    given: Mapping[str, Array]

    def measured(self, rng: np.random.Generator) -> dict[str, Array]:
        """The columns of a data file, with noise."""
        noisy = {name: x + NOISE * np.std(x) * rng.standard_normal(len(x)) for name, x in self.seen.items()}
        return {"t": self.t, **noisy, **self.given}


def moved(rig: Rig) -> Motion:
    """The rig's motion, at round-off."""
    from phichain import build
    from phichain.motion import simulate

    system = build(rig.scene, prove=False)
    seconds, rate = rig.span
    t = np.linspace(0.0, seconds, round(seconds * rate) + 1)
    size, omega = rig.push
    push = size * np.sin(omega * t)
    p = {name: np.array(value) if isinstance(value, list) else value for name, value in rig.truth.items()}
    x = simulate(system, rig.x0, t, tol=1e-13, p=p, u=(t, push) if size else None, error_estimate=False).x
    given = {system.u_names[0]: push} if size else {}
    return Motion(system, t, {name: x[:, k] for k, name in enumerate(system.q_names)}, given)
