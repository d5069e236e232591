"""Every function a scene can want, un-lowered and in as many digits as asked: the yardstick of all backends.

`reference` works densely from positions (see `dense`), so nothing in it is shared with the lowered programs:
the inertia matrix is sum_a m_a J_a^T J_a, accelerations come from an LU solve, Phi from a quadrature of its
own integral, Jacobians from central differences at raised precision.

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

from phichain.errors import ArrayError, UnsupportedError
from phichain.reference import derived, directions, motion, rosenbrock, steps
from phichain.reference.algebra import Vector
from phichain.reference.motion import Case, Outputs
from phichain.reference.pose import exact, parameters
from phichain.scene import Scene

_GUARD = 60

_FUNCTIONS: dict[str, tuple[Callable[[Case], Outputs], tuple[str, ...]]] = {
    "forward_dynamics": (motion.forward_dynamics, ("q", "v", "u")),
    "direction_dynamics": (directions.direction_dynamics, ("q", "q_dot", "u")),
    "inverse_dynamics": (motion.inverse_dynamics, ("q", "v", "a")),
    "mass_matrix": (motion.mass_matrix, ("q",)),
    "coriolis": (motion.coriolis, ("q", "v")),
    "gravity_torque": (motion.gravity_torque, ("q",)),
    "energy": (motion.energy, ("q", "v")),
    "positions": (motion.positions, ("q",)),
    "linearization": (motion.linearization, ("s",)),
    "state_jacobian": (derived.state_jacobian, ("q", "v", "u")),
    "phi": (derived.phi, ("amplitude", "omega")),
    "phi_jacobian": (derived.phi_jacobian, ("amplitude", "omega")),
    "step": (derived.step, ("h", "q", "v", "u")),
    "step_lie4": (steps.step_lie4, ("h", "q", "v", "u")),
    "step_variational": (steps.step_variational, ("h", "q", "v", "u")),
    "step_rosenbrock": (rosenbrock.step_rosenbrock, ("h", "q", "v", "u")),
    "project": (motion.project_state, ("q", "v")),
}

_PLANAR_ONLY = ("inverse_dynamics", "phi", "phi_jacobian")
_SPATIAL_ONLY = ("direction_dynamics", "project")


def reference(
    scene: Scene,
    function: str,
    inputs: Mapping[str, Any],
    digits: int = 50,
    params: Mapping[str, Any] | None = None,
) -> Outputs:
    """Return the outputs of one function of the contract's table for exact inputs, to `digits` digits.

    Args:
        scene: The chain; which functions it wants does not matter here.
        function: A name of `phichain.scene.FUNCTIONS`, e.g. "forward_dynamics".
        inputs: The C arguments by name (q, v, q_dot, u, a, s, amplitude, omega, h): flat sequences, numbers for
            scalars, in SI units. A missing `u` is zero.
        digits: Significant digits of the outputs; guard digits are added for mass and length ratios.
        params: Values of the runtime parameters by name.

    Returns:
        mpf or nested lists of mpf by output name: "a", "u", "M", "N", "G", "kinetic" and "potential", "r"; "M",
        "G", "B" (and "D" when damped) of the linearisation; "dadq", "dadv", "dadu" (spatial: "tangent" and
        "dadu"), "q_ddot", "phi", "dphi", "q_next" and "v_next" (and "residual",
        or "q_error" and "v_error"), "q_out" and "v_out".

    Raises:
        UnsupportedError: There is no such function, or none for this kind of scene.
        ArrayError: An input is missing, not finite or of the wrong length, or a unit vector is zero.
        SceneError: A runtime parameter has no value.
    """
    evaluate = _chosen(scene, function)
    with mp.workdps(digits + _GUARD):
        guard = _GUARD + 2 * parameters(scene, params).decades()
    with mp.workdps(digits + guard):
        outputs = evaluate(Case(scene, parameters(scene, params), _read(scene, function, inputs)))
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
        return derived.tangents(scene, [exact(entry) for entry in q], [exact(entry) for entry in v])


def _chosen(scene: Scene, function: str) -> Callable[[Case], Outputs]:
    """Return the evaluation of a function that this kind of scene has."""
    if function not in _FUNCTIONS:
        raise UnsupportedError(
            "function", function, "has no reference", f"choose one of {', '.join(_FUNCTIONS)}"
        )
    if not scene.is_planar and function in _PLANAR_ONLY:
        raise UnsupportedError(
            "function", function, "is for planar scenes", "use forward_dynamics or linearization"
        )
    if function in ("phi", "phi_jacobian") and scene.damping is not None:
        raise UnsupportedError(
            "function", function, "has no meaning with dampers: there is no in-phase motion", "remove the dampers"
        )
    if scene.is_planar and function in _SPATIAL_ONLY:
        raise UnsupportedError(
            "function", function, "is for spatial scenes", "planar states are angles, with no unit vectors"
        )
    return _FUNCTIONS[function][0]


def _read(scene: Scene, function: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the inputs as mpf, checked against the function's arguments."""
    lengths = {
        "q": scene.nq,
        "v": scene.nv,
        "q_dot": scene.nq,
        "a": scene.nv,
        "u": scene.nu,
        "s": scene.links,
        "amplitude": scene.nq,
    }
    known: dict[str, Any] = {}
    for name in _FUNCTIONS[function][1]:
        given = inputs.get(name, [0.0] * scene.nu if name == "u" else None)
        if given is None:
            raise ArrayError(name, None, f"is an argument of {function}", "pass it in inputs")
        scalar = name not in lengths
        entries = [exact(entry) for entry in ([given] if scalar else given)]
        if not scalar and len(entries) != lengths[name]:
            raise ArrayError(name, given, f"has {len(entries)} entries", f"pass {lengths[name]}")
        if not all(mp.isfinite(entry) for entry in entries):
            raise ArrayError(name, given, "is not finite", "pass finite numbers")
        known[name] = entries[0] if scalar else entries
    return known


def _rounded(output: Any) -> Any:
    """Return an output rounded to the current precision."""
    return [_rounded(entry) for entry in output] if isinstance(output, list) else +output
