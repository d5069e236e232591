"""What is to be moved from where to where, and within which limits: checked before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from phichain.control.equilibria import demand_equilibria
from phichain.errors import ControlError, UnsupportedError
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.arrays import real_numbers
from phichain.system.vertical import Signs, configuration


@dataclass(frozen=True, eq=False)
class Task(Held):
    """A motion from one vertical equilibrium to another.

    Attributes:
        start: Directions of the links at the start, +1 hanging, -1 upright.
        target: Directions at the end.
        first: Configuration at the start (nq,).
        last: Configuration at the end (nq,).
        rail: Largest distance of the cart from 0, m; inf for none.
        limit: Largest size of every input (nu,).
        sample: Time between two calls of the law, s.
        swing: Swing time of the chain, sqrt(sum r' / g), s: what times and rates are measured by. r' = r + J / (m r), at most l, is
            how far from its joint a link swings as a point would.
        routes: The same in several motions each, from one equilibrium to the next, see `_between`.
    """

    start: Signs
    target: Signs
    first: Vector
    last: Vector
    rail: float
    limit: Vector
    sample: float
    swing: float
    routes: tuple[tuple[Task, ...], ...] = ()

    @classmethod
    def of(
        cls,
        system: System,
        *,
        limit: ArrayLike,
        rail: float | None = None,
        start: Sequence[int] | None = None,
        target: Sequence[int] | None = None,
        places: tuple[float, float] = (0.0, 0.0),
        sample: float = 1e-3,
    ) -> Task:
        """The task of a chain.

        Args:
            system: A planar chain with inputs, its `linearization`, and casadi installed.
            limit: Largest size of every input, one number or (nu,).
            rail: Largest distance of the cart from 0, m; none unless given.
            start: Where it begins; every link hanging unless given.
            target: Where it ends; every link upright unless given.
            places: Where the cart stands at the start and at the end, m.
            sample: Time between two calls of the law, s.

        Raises:
            UnsupportedError: A spatial chain.
            ControlError: No inputs, no equilibrium, nothing to do, or limits that are none or exclude an end.
        """
        if not system.is_planar:
            raise UnsupportedError(
                "chain.space", system.space, "has no swing-up: its trajectories are planned in angles",
                'make the chain "planar", or stay near one equilibrium with lqr(system, s)',
            )  # fmt: skip
        if not system.nu:
            raise ControlError("joints.actuated", "none", "nothing pushes this chain", 'actuate the "cart", or a joint such as [1]')
        ends = ([1] * system.links if start is None else start, [-1] * system.links if target is None else target)
        linear = demand_equilibria(system, ends)
        first, last = (configuration(system, one.s) for one in linear)
        for end, place in zip((first, last), places, strict=True):
            end[: system.cart_size] = place
        if np.array_equal(first, last):
            raise ControlError("target", list(linear[1].s), "is where the chain starts", "give another target, or another place of the cart")
        gravity = abs(float(system.number("gravity")))
        if not gravity > 0:
            raise UnsupportedError("chain.gravity", gravity, "leaves no equilibrium to swing to", "give the chain its weight")
        if not (np.isfinite(sample) and sample > 0):
            raise ControlError("sample", sample, "is no positive time", "give the time between two calls, s")
        whole = cls(
            linear[0].s, linear[1].s, first, last, _rail(system, rail, places), _limits(system, limit), float(sample),
            sqrt(float(np.sum(_swinging(system))) / gravity),
        )  # fmt: skip
        return replace(whole, routes=tuple(_legs(system, whole, route, places) for route in _between(whole.start, whole.target)))


def _between(start: Signs, target: Signs) -> list[list[Signs]]:
    """Equilibria to stop at on the way, route by route.

    Through the hanging chain where neither end hangs: swing-ups are easier to find than motions from pose to pose, and one of them may be
    run backwards. And where links hang behind the last that stands, through the pose in which they stand too: from there they alone swing
    down, while a pose that is folded so is hardly met by a chain that comes from afar.
    """
    hanging = (1,) * len(start)
    home = [] if hanging in (start, target) else [hanging]
    leaving, coming = _unfolded(start), _unfolded(target)
    folded = [leaving, *(home if leaving != coming else []), coming]
    routes = [home, [pose for k, pose in enumerate(folded) if pose not in (start, target) and pose not in folded[:k]]]
    return [route for k, route in enumerate(routes) if route and route not in routes[:k]]


def _unfolded(signs: Signs) -> Signs:
    """The same pose with the links behind the last that stands standing too."""
    last = max((k for k, sign in enumerate(signs) if sign < 0), default=len(signs))
    return signs[: last + 1] + (-1,) * (len(signs) - last - 1)


def _legs(system: System, whole: Task, route: list[Signs], places: tuple[float, float]) -> tuple[Task, ...]:
    """One motion after the other, the cart half-way in between."""
    ends = [(whole.start, whole.first)]
    for signs in route:
        stop = configuration(system, signs)
        stop[: system.cart_size] = float(np.mean(places))
        ends.append((signs, stop))
    ends.append((whole.target, whole.last))
    return tuple(replace(whole, start=one[0], first=one[1], target=other[0], last=other[1]) for one, other in pairwise(ends))


def _swinging(system: System) -> Vector:
    """r' of every link (N,), m."""
    length, mass = (np.asarray(system.number(name), dtype=float) for name in ("length", "mass"))
    com = np.asarray(system.number("com", default=length), dtype=float)
    inertia = np.asarray(system.number("inertia", default=np.zeros(system.links)), dtype=float)
    moment = np.maximum(mass * np.abs(com), 1e-300)
    return np.asarray(np.minimum(length, np.abs(com) + inertia / moment), dtype=float)


def _limits(system: System, limit: ArrayLike) -> Vector:
    bound = real_numbers("limit", limit, "give the largest size of every input")
    if bound.shape not in ((), (1,), (system.nu,)) or not np.all((bound > 0) & np.isfinite(bound)):
        raise ControlError("limit", limit, "is no positive size of every input", f"give one number, or {system.nu}")
    return np.array(np.broadcast_to(bound, (system.nu,)))


def _rail(system: System, rail: float | None, places: tuple[float, float]) -> float:
    if not system.has_cart:
        if rail is not None or any(places):
            raise ControlError("rail", rail, "belongs to a cart, which this chain has not", "leave it out")
        return inf
    length = inf if rail is None else float(rail)
    if not length > 0:
        raise ControlError("rail", rail, "is no positive length", "give how far the cart may go to either side, m")
    far = max(map(abs, places))
    if far >= length:
        raise ControlError("rail", rail, f"ends before the cart's place at {far:g} m", "give a longer rail, or another place")
    return length
