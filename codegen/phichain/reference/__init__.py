"""Every function a scene can want, un-lowered and in as many digits as asked: the yardstick of all backends.

`reference` works from positions (see `masses`), so nothing in it is shared with the lowered programs: the inertia matrix is
sum_a m_a J_a^T J_a, and accelerations are what it turns into the forces, found by elimination with pivots (see `inertia`);
Phi comes from a quadrature of its own integral, Jacobians from central differences at raised precision. Forces and
accelerations of N links cost O(N).

Inputs are read as exact binary64 numbers. A spatial state in floating point is never exactly unit and
tangent; the nearest exact state stands for it. Two functions need a word there:

* `state_jacobian`: off the manifold every emitted form extends (16) in a way of its own, so its partial
  derivatives are its own too. Those along the manifold are not: "tangent" holds one row per direction of
  `tangent_directions`.
* `step`: the stages leave the manifold by O(h^2), and the reference evaluates accelerations at the nearest
  consistent states. It agrees with an emitted spatial step to the method's own local error O(h^5), not to
  round-off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mpmath import mp

from phichain.contract.functions import ROWS
from phichain.errors import ArrayError, ContractError, UnsupportedError
from phichain.reference.algebra import Vector
from phichain.reference.case import JUDGES, Case, Outputs
from phichain.reference.derived import tangents
from phichain.reference.nudge import Nudge
from phichain.reference.pose import exact, parameters
from phichain.scene import Scene

_GUARD = 60


def reference(
    scene: Scene,
    function: str,
    inputs: Mapping[str, Any],
    digits: int = 50,
    params: Mapping[str, Any] | None = None,
    nudge: Nudge | None = None,
) -> Outputs:
    """Return the outputs of one function of the contract's table for exact inputs, to `digits` digits.

    Args:
        scene: The chain; which functions it wants does not matter here.
        function: A name of `phichain.scene.FUNCTIONS` that is no flow, e.g. "forward_dynamics".
        inputs: The C arguments by name (q, v, q_dot, u, a, s, amplitude, omega, h): flat sequences, numbers for
            scalars, in SI units. A missing `u` or `b` is zero.
        digits: Significant digits of the outputs; guard digits are added for mass and length ratios.
        params: Values of the runtime parameters by name.
        nudge: Moves every constant, parameter and input a little, to see how much the outputs move; signs s stay.

    Returns:
        mpf or nested lists of mpf by output name: "a", "u", "M", "N", "G", "kinetic" and "potential", "r"; "M",
        "G", "B" (and "D" when damped) of the linearisation; "dadq", "dadv", "dadu" (spatial: "tangent" and
        "dadu"), "q_ddot", "phi", "dphi", "q_next" and "v_next" (and "residual",
        or "q_error" and "v_error"), "q_out" and "v_out".

    Raises:
        UnsupportedError: There is no such function, or none for this kind of scene.
        ContractError: The function stands in the contract's table, and nobody wrote its reference.
        ArrayError: An input is missing, not finite or of the wrong length, or a unit vector is zero.
        SceneError: A runtime parameter has no value.
    """
    evaluate = _chosen(scene, function)
    with mp.workdps(digits + _GUARD):
        guard = _GUARD + 2 * parameters(scene, params).decades()
    with mp.workdps(digits + guard):
        values, known = parameters(scene, params), _read(scene, function, inputs)
        if nudge is not None:
            values, known = values.nudged(nudge), _nudged(known, nudge)
        outputs = evaluate(Case(scene, values, known))
        _demand_outputs(scene, function, outputs)
    with mp.workdps(digits):
        return {name: _rounded(output) for name, output in outputs.items()}


def tangent_directions(
    scene: Scene, q: Sequence[float], v: Sequence[float], digits: int = 50
) -> list[tuple[Vector, Vector]]:
    """Return directions (dq, dv) that span the tangent space of spatial states at the one nearest (q, v).

    Ordered: the cart's x; for each link and each of two axes b orthogonal to q_k the rotation (b x q_k, b x
    omega_k), which turns the rate with the link; the cart's x'; for each link and axis the rate (0, b).
    `reference(scene, "state_jacobian", ...)["tangent"][i]` is dadq dq_i + dadv dv_i.

    Raises:
        UnsupportedError: The scene is planar; its states have no manifold to keep to.
    """
    if scene.is_planar:
        raise UnsupportedError("space", "planar", "has no constrained states", "read dadq and dadv instead")
    with mp.workdps(digits + _GUARD):
        return tangents(scene, [exact(entry) for entry in q], [exact(entry) for entry in v])


def _chosen(scene: Scene, function: str) -> Callable[[Case], Outputs]:
    """Return the evaluation of a function that this kind of scene has."""
    row = ROWS.get(function)
    if row is None or row.flow:
        known = [name for name in ROWS if JUDGES.has(name)]
        raise UnsupportedError("function", function, "has no reference", f"choose one of {', '.join(known)}")
    reason = row.absence(scene)
    if reason is not None:
        raise UnsupportedError("function", function, reason.problem, reason.remedy)
    return JUDGES.of(function)


def _demand_outputs(scene: Scene, function: str, outputs: object) -> None:
    """Check that a reference gives every output of its row; that of a Jacobian may speak of directions instead."""
    row = ROWS[function]
    given = outputs if isinstance(outputs, Mapping) else {}
    absent = [name for name in row.outputs_in_reference(scene).values() if name not in given]
    if absent and (row.derivative is None or not given):
        problem = f"has a reference that gives no {' and no '.join(absent)}"
        remedy = "return every output of its row, or say in the row what the reference calls it"
        raise ContractError("function", function, problem, remedy, missing="reference")


def _read(scene: Scene, function: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the inputs as mpf, checked against the function's arguments."""
    known: dict[str, Any] = {}
    for argument in ROWS[function].arguments:
        if argument.direction == "out":
            continue
        name, shape = argument.name, argument.shape(scene)
        given = inputs.get(name, [0.0] * shape[0] if name in ("u", "b") else None)
        if given is None:
            raise ArrayError(name, None, f"is an argument of {function}", "pass it in inputs")
        entries = [exact(entry) for entry in (given if shape else [given])]
        if shape and len(entries) != shape[0]:
            raise ArrayError(name, given, f"has {len(entries)} entries", f"pass {shape[0]}")
        if not all(mp.isfinite(entry) for entry in entries):
            raise ArrayError(name, given, "is not finite", "pass finite numbers")
        known[name] = entries if shape else entries[0]
    return known


def _nudged(known: Mapping[str, Any], nudge: Nudge) -> dict[str, Any]:
    """Return the inputs moved, but for signs."""
    return {
        name: value if name == "s" else nudge(name, value) if isinstance(value, list) else nudge(name, [value])[0]
        for name, value in known.items()
    }


def _rounded(output: Any) -> Any:
    """Return an output rounded to the current precision."""
    return [_rounded(entry) for entry in output] if isinstance(output, list) else +output
