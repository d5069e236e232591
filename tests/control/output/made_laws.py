"""The laws of measurements that several tests share: by observers, integrals or both, in the plane and in space."""

from __future__ import annotations

from functools import cache
from typing import Any

from phichain.control import Gains, Sensors, estimator, lqr, output_law
from phichain.laws import OutputFeedback
from tests.handmade import planar, spatial

PERIOD = 0.002
CHAINS = {
    "plane": planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart"),
    "space": spatial([0.2], [0.4], cart_mass=0.5),
}
KINDS = ("kalman", "reduced")
INTEGRALS = {"plane": {"x": 2.0}, "space": {"x_1": 1.0, "x_2": 0.5}}


@cache
def gains_of(chain: str) -> Gains:
    return lqr(CHAINS[chain], sample=PERIOD)


@cache
def law_of(chain: str, kind: str | None = "kalman", integrals: bool = False, **more: Any) -> OutputFeedback:
    gains = gains_of(chain)
    estimate = None if kind is None else estimator(gains, Sensors(), kind)
    return output_law(gains, estimate, INTEGRALS[chain] if integrals else None, [0.125] * CHAINS[chain].cart_size, **more)


LAWS = [(chain, kind, integrals) for chain in CHAINS for kind in (*KINDS, None) for integrals in (False, True) if kind or integrals]
