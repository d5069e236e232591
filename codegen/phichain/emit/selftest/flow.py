"""The self-test of what runs over many steps: a short motion against the un-lowered Lagrangian, and back to its start.

The expected end is that of Gragg's midpoint rule extrapolated in the step size (Gragg 1965), on the accelerations of
`reference` in 50 digits: another method on other equations than the emitted ones.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from mpmath import mp

from phichain.emit.selftest.states import draw_inputs, draw_parameter, motion_step, rounded, shaped
from phichain.ir.nodes import Array
from phichain.ir.rounded import EPSILON
from phichain.lowering.lower import Lowered
from phichain.reference import reference
from phichain.reference.forcing import forced_inputs
from phichain.scene import Scene

#: The reference's cost grows with the cube of the links: longer chains only go there and back.
LONGEST_REFERENCE: Final = 8
#: Longest motion in units of the step that the one-step functions are tested with.
_STEPS: Final = 2048
#: Midpoint substeps of the extrapolated rows.
_ROWS: Final = tuple(range(2, 26, 2))
#: A reference is taken when two extrapolations in turn agree to so many digits of the largest entry.
_AGREEMENT: Final = 20
#: Rows gain digits evenly. After so many it is seen whether the rest will do, each gaining this much more than those before.
_SEEN: Final = 5
_FASTER: Final = Fraction(3, 2)


@dataclass(frozen=True)
class FlowKind:
    """What is asked of a flow.

    Attributes:
        tolerance: what is asked, by type.
        accepted: error over the largest entry that passes, by type.
    """

    tolerance: Mapping[str, float]
    accepted: Mapping[str, float]


KINDS: Final[Mapping[str, FlowKind]] = {
    "propagate": FlowKind(EPSILON, {real: 64 * epsilon for real, epsilon in EPSILON.items()}),
    "propagate_stiff": FlowKind({"double": 1e-11, "float": 1e-4}, {"double": 1e-9, "float": 1e-3}),
}


@dataclass(frozen=True)
class FlowCase:
    """A motion over t_end from (q, v), u held.

    Attributes:
        function: the flow's name in the contract.
        params: values of the runtime parameters, by name.
        inputs: q, v and, where the scene has one, u, and of a forced scene amplitude and omega.
        t_end: its length, s.
        expected: q and v at its end; None where they would take too long to compute.
        tolerance: what is asked of the flow.
        accepted: error over the largest entry that passes.
    """

    function: str
    params: Mapping[str, list[float]]
    inputs: Mapping[str, list[float]]
    t_end: float
    expected: Mapping[str, list[float]] | None
    tolerance: float
    accepted: float


def flow_cases(scene: Scene, lowered: Lowered) -> tuple[FlowCase, ...]:
    """One motion for each flow that the scene wants, drawn from the scene's digest; batch forms have none."""
    return tuple(_case(scene, lowered, name) for name in scene.want if name in KINDS)


def _case(scene: Scene, lowered: Lowered, name: str) -> FlowCase:
    source = random.Random(f"{name} {scene.digest}")
    values = {array.name: draw_parameter(scene, array, source) for array in lowered.params}
    state = [
        Array("q", (scene.nq,)),
        Array("v", (scene.nv,)),
        *([Array("u", (scene.nu,))] if scene.nu else []),
        *([Array("amplitude", (1,)), Array("omega", (1,))] if scene.forced is not None else []),
    ]
    inputs = draw_inputs(scene, state, source)
    t_end = _STEPS * motion_step(scene, values, inputs)
    expected = None
    while scene.links <= LONGEST_REFERENCE and expected is None:
        t_end /= 2
        ends = exact_motion(scene, shaped(lowered.params, values), inputs, t_end)
        if ends is not None:
            expected = {part: [rounded(scene, x) for x in end] for part, end in ends.items()}
    kind = KINDS[name]
    return FlowCase(name, values, inputs, t_end, expected, kind.tolerance[scene.real], kind.accepted[scene.real])


def exact_motion(
    scene: Scene, params: Mapping[str, Any], inputs: Mapping[str, Sequence[float]], t_end: float
) -> dict[str, list[Any]] | None:
    """q and v at t_end to twenty digits, or None where t_end is too long for the extrapolation."""
    with mp.workdps(50):
        # Time comes along as the last entry: what is forced asks for it.
        start = [mp.mpf(x) for x in (*inputs["q"], *inputs["v"], 0)]

        def slope(state: list[Any]) -> list[Any]:
            q, v = state[: scene.nq], state[scene.nq : -1]
            chain, u = _inputs(scene, inputs, state[-1])
            a = reference(chain, "forward_dynamics", {"q": q, "v": v, **u}, params=params)["a"]
            return [*_velocity(scene, q, v), *a, mp.mpf(1)]

        sizes = {"q": slice(0, scene.nq), "v": slice(scene.nq, -1)}
        end = _extrapolated(slope, start, mp.mpf(t_end), tuple(sizes.values()))
        return None if end is None else {name: end[part] for name, part in sizes.items()}


def _inputs(scene: Scene, inputs: Mapping[str, Sequence[float]], t: Any) -> tuple[Scene, dict[str, list[Any]]]:
    """The chain with all that acts on it at a time among its inputs, and these."""
    given = list(inputs.get("u", ()))
    if scene.forced is None:
        return scene, {"u": given} if given else {}
    (amplitude,), (omega,) = inputs["amplitude"], inputs["omega"]
    chain, u = forced_inputs(scene, given, amplitude * mp.cos(omega * t))
    return chain, {"u": u}


def _velocity(scene: Scene, q: list[Any], v: list[Any]) -> list[Any]:
    """q' of a state: v in the plane, omega_k x q_k on the sphere."""
    if scene.is_planar:
        return v
    first = 2 if scene.has_cart else 0
    velocity = v[:first]
    for k in range(first, scene.nq, 3):
        (a, b, c), (x, y, z) = v[k : k + 3], q[k : k + 3]
        velocity += [b * z - c * y, c * x - a * z, a * y - b * x]
    return velocity


def _extrapolated(
    slope: Callable[[list[Any]], list[Any]], start: list[Any], t_end: Any, parts: Sequence[slice]
) -> list[Any] | None:
    """Aitken-Neville extrapolation in h^2 of the midpoint rule's results, until two of the diagonal agree in every part."""
    first = slope(start)
    row: list[list[Any]] = []
    for k, count in enumerate(_ROWS):
        new = [_midpoint(slope, start, first, t_end / count, count)]
        for j, before in enumerate(row):
            ratio = mp.mpf(count) / _ROWS[k - 1 - j]
            new.append([x + (x - y) / (ratio**2 - 1) for x, y in zip(new[-1], before, strict=True)])
        row, last = new, row[-1] if row else start
        digits = min(_digits(row[-1][part], last[part]) for part in parts)
        if digits >= _AGREEMENT:
            return row[-1]
        if k + 1 >= _SEEN and digits * (k + _FASTER * (len(_ROWS) - 1 - k)) < _AGREEMENT * k:
            return None
    return None


def _digits(one: list[Any], other: list[Any]) -> Any:
    """To how many digits of the largest entry two vectors agree."""
    apart = max(abs(x - y) for x, y in zip(one, other, strict=True))
    return -mp.log10(apart / max(map(abs, one))) if apart else mp.inf


def _midpoint(
    slope: Callable[[list[Any]], list[Any]], start: list[Any], first: list[Any], h: Any, count: int
) -> list[Any]:
    before, now = start, [x + h * y for x, y in zip(start, first, strict=True)]
    for _ in range(count - 1):
        before, now = now, [x + 2 * h * y for x, y in zip(before, slope(now), strict=True)]
    return now
