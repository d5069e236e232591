"""THE table of the functions that a scene can ask for. Every other list of functions is read off it.

A new function is a row here, a writer in `lowering` and a reference in `reference`: see CONTRIBUTING.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from phichain.contract import arguments, flows, meanings
from phichain.contract.arguments import (
    ACCELERATIONS,
    BALANCE,
    ESTIMATE,
    FORCE,
    NO_BALANCE,
    NO_FORCES,
    NO_PREPARATION,
    STATE,
    STEP,
    Q,
    U,
    V,
    is_lossy,
    is_planar,
    jacobian_by,
    out,
    per_q,
    per_v,
    scalar,
    small,
)
from phichain.contract.chain import Kind, Sample, always
from phichain.contract.function import Absence, Argument, Derivative, Function

_QUADRATURE: Final = 16
"""Links up to which the quadrature behind phi's reference, N^2 a node, is worth its time."""
_DENSE_STEP: Final = 8
"""The same for the dense reference of an implicit step, whose Jacobian costs N^4."""
_FURTHER_STEP: Final = "a further way to step, for those who know that they need it"
_FURTHER_FLOW: Final = "a further way to move on, for those who know that they need it"
_MANY: Final = "for many states at once"

TABLE: Final[tuple[Function, ...]] = (
    Function(
        "forward_dynamics", "Accelerations: the equations of motion solved.",
        (*STATE, Argument("a", "out", per_v, "accelerations")),
    ),
    Function(
        "forward_dynamics_batch", "Accelerations of many states at once, on vectors.",
        flow=flows.FORWARD_DYNAMICS_BATCH, on_request=_MANY,
    ),
    Function(
        "prepare", "What the runtime parameters alone determine, computed once; forward_dynamics_prepared goes on from there.",
        flow=flows.PREPARE, absent=NO_PREPARATION, on_request="for many states under the same runtime parameters", is_missed=False,
    ),
    Function(
        "direction_dynamics", "Accelerations of the unit vectors themselves: the equations of motion without angular velocities.",
        (
            Q,
            Argument("q_dot", "in", per_q, "rate of q", meanings.direction_rates),
            U,
            Argument("q_ddot", "out", per_q, "second derivative of q", meanings.direction_accelerations),
        ),
        absent=(
            Absence(
                is_planar, "is defined on spatial scenes alone, since a planar link has an angle and no unit vector",
                'use "forward_dynamics", whose accelerations are those of the angles',
            ),
        ),
    ),
    Function(
        "inverse_dynamics", "Generalised force that produces given accelerations.",
        (Q, V, ACCELERATIONS, arguments.B, FORCE), absent=NO_FORCES,
    ),
    Function(
        "inverse_and_jacobian", "Generalised force for given accelerations, and its exact partial derivatives.",
        (Q, V, ACCELERATIONS, arguments.B, FORCE, *(arguments.force_by(name) for name in ("q", "v", "a"))),
        absent=NO_FORCES, derivative=Derivative("inverse_dynamics", "u", by=("q", "v", "a"), keeps=True),
        on_request="for who balances harmonics or fits splines to the equations of motion", is_missed=False,
    ),
    Function(
        "mass_matrix", "Mass matrix of the equations of motion.",
        (Q, out(lambda chain: (chain.nv, chain.nv), "mass matrix, row-major", meanings.inertias)),
        reference=("M",),
    ),
    Function(
        "coriolis", "Velocity terms of the equations of motion.",
        (Q, V, out(per_v, "velocity terms", lambda chain: f"velocity terms, {meanings.forces(chain)}")),
        reference=("N",),
    ),
    Function(
        "gravity_torque", "Gravity terms of the equations of motion, without springs.",
        (Q, out(per_v, "gravity terms", lambda chain: f"gravity terms, {meanings.forces(chain)}")),
        reference=("G",),
    ),
    Function(
        "energy", "Kinetic and potential energy.",
        (
            Q, V,
            Argument("kinetic", "out", scalar, "kinetic energy, J", meanings.kinetic),
            Argument("potential", "out", scalar, "potential energy, J, springs included", meanings.potential),
        ),
    ),
    Function(
        "momentum", "Generalised momenta: the derivatives of the kinetic energy by the rates.",
        (
            Q,
            V,
            out(
                per_v, "generalised momenta",
                lambda chain: f"generalised momenta conjugate to v, {meanings.units(chain, 'kg m/s', 'kg m^2/s')}"
                + ("" if chain.is_planar else "; those of the links are orthogonal to them"),
            ),
        ),
        # Who has the mass matrix has M v: nobody misses it, and no list of all functions asks for it.
        on_request="it is mass_matrix times v", is_missed=False, reference=("p",),
    ),
    Function(
        "tensions", "Force in every link along it, at the joint that carries it.",
        (
            *STATE,
            out(lambda chain: (chain.links,), "", "force in each link along it, just below the joint that carries it, N; positive in tension"),
        ),
        on_request="for who sizes links and joints", is_missed=False, reference=("tension",),
    ),
    Function(
        "positions", "Positions of the point masses.",
        (
            Q,
            out(
                lambda chain: (chain.links, 2 if chain.is_planar else 3),
                "mass positions, m, last component along gravity", meanings.places,
            ),
        ),
        reference=("r",),
    ),
    Function(
        "linearization", "Linear equations of motion about an equilibrium, M x'' + D x' + G x = B u.",
        (
            Argument(
                "s", "in", lambda chain: (chain.links,), "+1 for a link hanging down, -1 for one pointing up",
                "+1 for a link that hangs down, -1 for one that stands up",
            ),
            Argument("M", "out", small, "inertia", meanings.small_inertia),
            Argument("G", "out", small, "stiffness of gravity and springs", meanings.small_stiffness),
            Argument("D", "out", small, "damping", meanings.small_damping, is_lossy),
            Argument(
                "B", "out", lambda chain: (small(chain)[0], chain.nu), "input matrix", "how the inputs u enter",
                flows.has_input,
            ),
        ),
    ),
    Function(
        "state_jacobian", "Exact partial derivatives of forward_dynamics.",
        (
            *STATE,
            jacobian_by("q", lambda chain: chain.nq, always),
            jacobian_by("v", lambda chain: chain.nv, always),
            jacobian_by("u", lambda chain: chain.nu, flows.has_input),
        ),
        derivative=Derivative("forward_dynamics", "a", by=("q", "v", "u")),
    ),
    Function(
        "dynamics_and_jacobian", "Accelerations and their exact partial derivatives, from one factorisation.",
        (
            *STATE,
            Argument("a", "out", per_v, "accelerations"),
            jacobian_by("q", lambda chain: chain.nq, always),
            jacobian_by("v", lambda chain: chain.nv, always),
            jacobian_by("u", lambda chain: chain.nu, flows.has_input),
        ),
        derivative=Derivative("forward_dynamics", "a", by=("q", "v", "u"), keeps=True),
        # Who has state_jacobian and forward_dynamics has both: nobody misses it.
        on_request="it is forward_dynamics and state_jacobian in one call", is_missed=False,
    ),
    Function(
        "phi", "Residuals of the single-harmonic balance.",
        (*BALANCE, out(per_v, "residuals of the balance", meanings.residuals)),
        absent=NO_BALANCE, reference=("phi",), longest_checked=_QUADRATURE,
    ),
    Function(
        "phi_jacobian", "Exact derivatives of phi, columns [amplitude, omega].",
        (
            *BALANCE,
            out(
                lambda chain: (chain.nv, chain.nv + 1), "",
                "derivatives of phi by the amplitudes and, in the last column, by omega",
            ),
        ),
        absent=NO_BALANCE, derivative=Derivative("phi", "out", by=("amplitude", "omega")), reference=("dphi",),
        longest_checked=_QUADRATURE,
    ),
    Function("step", "One Runge-Kutta step of order 4.", STEP),
    Function(
        "step_jacobian", "The same step with its exact derivatives by the state before and by the held inputs.",
        (
            *STEP,
            Argument(
                "A", "out", lambda chain: (2 * chain.nv, 2 * chain.nv), "",
                "partial derivatives of (q_next, v_next) by (q, v): A_d of the sampled system",
            ),
            Argument(
                "B", "out", lambda chain: (2 * chain.nv, chain.nu), "",
                "partial derivatives of (q_next, v_next) by u: B_d of the sampled system", flows.has_input,
            ),
        ),
        on_request="for controllers and estimators in discrete time", is_missed=False, longest_checked=_DENSE_STEP,
    ),
    Function(
        "step_lie4", "One Runge-Kutta-Munthe-Kaas step of order 4: unit vectors turn, and stay unit.", STEP,
        on_request=_FURTHER_STEP,
    ),
    Function(
        "step_variational", "One step of the variational integrator of order 2, symplectic and reversible.",
        (
            *STEP,
            Argument(
                "residual", "out", scalar, "what the iteration left of the links' lengths",
                "norm of (|q_k|^2 - 1) over the links before they are made unit: round-off when the iteration was enough",
            ),
        ),
        on_request=_FURTHER_STEP,
    ),
    Function(
        "step_rosenbrock", "One L-stable Rosenbrock step of order 5 (Rodas5P), with an error estimate.",
        (
            *STEP,
            Argument(
                "q_error", "out", per_q, ESTIMATE,
                "estimated error of q_next: its difference to an embedded step of order 4", is_checked=False,
            ),
            Argument("v_error", "out", per_v, ESTIMATE, "estimated error of v_next, likewise", is_checked=False),
        ),
        on_request=_FURTHER_STEP, longest_checked=_DENSE_STEP,
    ),
    Function(
        "propagate", "Taylor flow: order and steps chosen from a tolerance, with dense output and an event.",
        flow=flows.PROPAGATE,
    ),
    Function(
        "propagate_stiff", "Stiff flow: an L-stable Rosenbrock method of order 5, its steps chosen from a tolerance.",
        flow=flows.PROPAGATE_STIFF, on_request=_FURTHER_FLOW,
    ),
    Function(
        "propagate_batch", "Taylor flow of many trajectories at once, on vectors, each with steps of its own.",
        flow=flows.PROPAGATE_BATCH, on_request=_MANY,
    ),
    Function(
        "project", "Unit vectors made unit, angular velocities made tangent.",
        (
            Q,
            V,
            Argument("q_out", "out", per_q, "configuration with unit vectors"),
            Argument(
                "v_out", "out", per_v, "rates with tangent angular velocities",
                "rates with every angular velocity orthogonal to its link",
            ),
        ),
        absent=(
            Absence(
                is_planar,
                "has no meaning on a planar scene, whose angles need no projection",
                "remove it; project belongs to the unit vectors of spatial scenes",
            ),
        ),
    ),
)  # fmt: skip
"""Every function, in the order of the contract; `want` is kept in this order."""


def _offered(kind: Kind) -> tuple[str, ...]:
    """What such a chain has, but for what is on request."""
    return tuple(row.name for row in TABLE if not row.on_request and row.absence(kind) is None)


ROWS: Final[Mapping[str, Function]] = MappingProxyType({row.name: row for row in TABLE})
"""The rows by name."""

FUNCTIONS: Final = tuple(ROWS)
"""The names of all functions."""

ON_REQUEST: Final = tuple(row.name for row in TABLE if row.on_request)
"""Those that are asked for by name and stand in no list of all functions."""

FLOWS: Final = tuple(row.name for row in TABLE if row.flow)
"""Those that run over many steps or states: C around Programs, where every other function is one Program."""

PLANAR_FUNCTIONS: Final = _offered(Sample(is_planar=True))
"""The functions of an undamped planar scene, but for those on request."""

SPATIAL_FUNCTIONS: Final = _offered(Sample(is_planar=False))
"""The functions of a spatial scene, but for those on request."""
