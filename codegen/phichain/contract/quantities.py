"""What the named quantities inside the emitted functions are: each explained once, for the comment above a function.

A name may mean one thing in the dynamics and another in the energy, so rows come in groups that say whose names they
are. `M` and `L` stand for the units of mass and length that a Program computes in: kg and m, or a link's own where all
links are alike. Sections and equation numbers are those of docs/theory.md.
"""

from __future__ import annotations

from typing import Final

from phichain.contract import quantities_beside as beside
from phichain.contract.chain import Chain
from phichain.contract.quantity import Quantities, Quantity, rows

_DYNAMICS: Final = frozenset({"forward_dynamics", "bent_dynamics", "direction_dynamics", "state_jacobian", "dynamics_and_jacobian", "step"})
_TENSIONS: Final = frozenset({"tensions"})
_FIELD: Final = frozenset({"forward_dynamics", "bent_dynamics", "direction_dynamics", "state_jacobian", "dynamics_and_jacobian"})
_FORCES: Final = frozenset({"inverse_dynamics", "inverse_and_jacobian"})
_ANGLES: Final = frozenset({"mass_matrix", "coriolis", "gravity_torque", "energy", "positions", *_FORCES, "momentum", "linearization"})
_BALANCE: Final = frozenset({"phi", "phi_jacobian"})
_STEPS: Final = frozenset({"step_lie4", "step_variational"})
_IMPLICIT: Final = frozenset({"step_rosenbrock", "implicit_factors"})
_SERIES: Final = frozenset({"flow_factor", "flow_order", "flow_columns", "flow_settle"})
"""What a Taylor flow does once a step, once an order, and first of all for its derivatives."""

_OF_LINKS: Final = "of the link and all beyond it"
_LINK_MASS, _PER_MASS = "m (r/l)^2", "l^2/(m r^2)"
_ON_BASE_SIDE: Final = "the links between it and the base"

TABLE: Final[tuple[Quantities, ...]] = (
    Quantities(
        _TENSIONS, "section 5",
        rows(
            ("rise_x rise_y rise_z", "m/s^2", "acceleration of the joint less gravity; of angles alone, in the frame of the link"),
            ("joint_x joint_y joint_z", "1/s^2", "the same over a length"),
            ("bending_x bending_y bending_z", "1/s^2", "second derivative of a link's direction"),
            ("inertial", "N", "mass times acceleration less gravity of a link's mass"),
            ("force_x force_y force_z", "N", "force that the joint exerts on the link and all beyond it"),
            ("beyond_x beyond_y beyond_z", "N", "the same of the next joint"),
            ("sine cosine", "", "sine and cosine of the joints' angles; where links have a `direction`, of the absolute ones"),
            ("direction", "", "unit vector along a link"),
            ("moment", "N m", "couple on a link, as a vector across it"),
            ("along", "kg m", f"inertia {_OF_LINKS} along it, times the length that stretches are in"),
            ("force_unit", "kg m", "mass times length of the link before, whose units a link is seen in"),
        ),
    ),
    Quantities(
        _DYNAMICS | _TENSIONS, "section 5",
        rows(
            ("tension", "L/s^2", "tension of a link over its mass"),
            ("middle_tension", "L/s^2", "tension of the link where the eliminations from the base and from the tip meet"),
            ("inner_tension inner_tension_next", "L/s^2", "tension, substituted back from the middle towards the base"),
            ("outer_tension outer_tension_next", "L/s^2", "tension, substituted back from the middle towards the tip"),
            ("right_side", "L/s^2", "right side of a link's row: l |q'|^2 and the forces on both its masses along it"),
            ("base_load tip_load", "L/s^2", "right side with what was eliminated on the base's or the tip's side"),
            ("base_incoming tip_incoming", "L/s^2", "what the links eliminated from the base or from the tip add to the next right side"),
            ("base_numerator tip_numerator", "", "slack of the pivot on the base's or the tip's side: numerator"),
            ("base_denominator tip_denominator", "", "slack of the pivot on the base's or the tip's side: denominator"),
            ("base_inverse_pivot tip_inverse_pivot", "", "1 / scaled pivot of a link's row, eliminated from the base or from the tip"),
            ("coupling", "", "share of the neighbour's tension that comes on top"),
            ("sine_squared", "", "squared sine of the angle between a link and the one before"),
            ("force_pair", "M L/s^2", "couple on a link over its length: the pair of forces that stands for it"),
            ("outer_pull inner_pull", "1/s^2", "pull of the link beyond or before, over mass and length of this one"),
            ("free_cart_acceleration", "L/s^2", "acceleration of the cart if the first link had no tension"),
            ("pull_along push_across", "L/s^2", "force of the first link on the cart, along and across it, over the cart's mass"),
            ("inverse_cart_pivot", "", "1 / scaled pivot of the cart"),
            ("mass_ratio", "", "mass of a link over that of the one before"),
            ("inverse_mass_ratio", "", "mass of the link before over that of a link"),
            ("inverse_length", "1/L", "1 / length of a link"),
            ("cart_acceleration", "L/s^2", "acceleration of the cart"),
            ("couple link_couple", "M L^2/s^2", "moment on a link of inputs, springs and dampers at both its ends"),
            ("joint_moment", "M L^2/s^2", "moment of spring and damper at a joint"),
        ),
    ),
    Quantities(
        _DYNAMICS, "section 5",
        rows(
            ("rate link_rate", "rad/s", "absolute angular rate of a link"),
            ("rate_squared", "rad^2/s^2", "squared absolute rate of a link"),
            ("leverage", "", "l/r of a link, its length over the distance of its mass"),
            ("overhang", "", "l/r - 1"),
            ("own_moment end_moment", "kg m", "first moment of a link's own mass, and of what rigid links beyond leave at its end"),
            ("swung", "1/s^2", "angular acceleration of a link but for what its joint's acceleration across it adds"),
            ("mass_unit", "M", "m (r/l)^2 of a link, the unit of mass for the chain at its joint"),
            ("shortening", "", "r/l of a link"),
            ("inverse_com", "1/L", "1 / r of a link"),
            ("inverse_mass", "1/M", "1 / mass of a link"),
            ("inverse_mass_unit", "1/M", "1 / mass_unit"),
            ("inverse_torque", "1/(M L^2)", "1 / (m r^2) of a link"),
            ("mass_step length_step leverage_step", "", "mass_unit, length, l/r of a link over that of the one before"),
            ("outward_step", "", "length of the link before over that of a link"),
            ("axial_step skew_step lever_step force_step", "", "what takes a result into the units of the link before"),
            ("determinant_step determinant_lever minor_step", "", "what takes determinants and minors into the units of the link before"),
            ("minor_lever minor_leverage", "", "what takes determinants and minors into the units of the link before"),
        ),
    ),
    Quantities(
        _DYNAMICS, "section 5",
        rows(
            ("inverse_pivot", "", "1 / inertia against which a link turns, its own included"),
            ("swing", "1/s^2", "centrifugal force of the chain beyond, across the link"),
            ("free", "1/s^2", "acceleration of a link's tip across it while its joint rests"),
            ("gain_x gain_y", "", "share of the joint's acceleration along the link, and across, that slows the tip"),
            ("axial", _LINK_MASS, "inertia of the chain beyond along the link, which is free to turn"),
            ("link_xx link_yy", _LINK_MASS, f"inertia {_OF_LINKS}, along it and across, in its frame"),
            ("link_determinant", "", f"determinant of the inertia {_OF_LINKS}, over l/r"),
            ("link_force_x link_force_y", "1/s^2", f"force that the motion {_OF_LINKS} asks for, in its frame, over m r^2 / l"),
            ("link_minor_x link_minor_y", "1/s^2", "adjugate of that inertia times that force, over l/r"),
            ("shear lean", _LINK_MASS, "what turning by the joint's angle moves between the entries of the inertia"),
            ("outer_xx outer_xy outer_yy", _LINK_MASS, f"inertia {_OF_LINKS}, in the frame of the link before"),
            ("outer_determinant", "", f"determinant of the inertia {_OF_LINKS}, over l/r"),
            ("outer_force_x outer_force_y", "1/s^2", f"force that the motion {_OF_LINKS} asks for, in the frame of the link before"),
            ("outer_minor_x outer_minor_y", "1/s^2", "adjugate of that inertia times that force, in the frame of the link before"),
            ("base_x base_y", "1/s^2", "acceleration of the joint less gravity, in the frame of the link before, over a length"),
            ("joint_x joint_y", "1/s^2", "acceleration of the joint less gravity, in the frame of the link, over its length"),
            ("tip_y", "1/s^2", "acceleration of a link's tip across it, over its length"),
        ),
        "planar",
    ),
    Quantities(
        frozenset({"state_jacobian", "dynamics_and_jacobian"}), "section 5",
        rows(
            ("link_mobility", "1/(kg m^2)", "angular acceleration of a link per couple on it, its joint at rest"),
            ("pass_xx pass_xy pass_yx pass_yy", "", "what a joint's acceleration makes of the next joint's, each in its link's frame"),
            ("turn_x turn_y", "", "across the link before, in the frame of the link, over its length"),
            ("joint_gain", "", "share of that in the link's angular acceleration"),
            ("link_row_x link_row_y", "", "share of the joint before's acceleration in a link's angular acceleration"),
            ("joint_row_x joint_row_y", "", "the same in the angular acceleration against the link before"),
            ("mobility_xx mobility_xy mobility_yy", "1/(kg m^2)", "acceleration of a joint per force on it, in lengths of its link"),
            ("joint_turn", "1/s^2", "turn of the link before that the next joint's angle takes away"),
        ),
        "planar",
    ),
    Quantities(
        _DYNAMICS, "section 5, from both ends",
        rows(
            ("yield_xx yield_xy yield_yy", _PER_MASS, f"how {_ON_BASE_SIDE} yield to a force, along the link and across"),
            ("yield_shear yield_lean", _PER_MASS, "what turning by the joint's angle moves between those entries"),
            ("yield_along yield_across yield_slack yield_skew", _PER_MASS, "parts of how the links up to this one yield"),
            ("yield_swing", "1/s^2", "centrifugal part of the acceleration across the link"),
            ("inverse_yield base_yield", "", "1 / compliance along the link, its mass included"),
            ("drift_x drift_y", "1/s^2", "acceleration of the joint less gravity without the chain beyond it, over a length"),
            ("drift_minor_x drift_minor_y", "1/s^2", "adjugate of the mobility times that acceleration, times l/r"),
            ("drift_free", "1/s^2", "acceleration across the link without the chain beyond it, times that compliance"),
            ("drive base_drive", "1/s^2", "couple on the link over m r^2"),
            ("mobility_xx mobility_xy mobility_yy", _PER_MASS, f"how {_ON_BASE_SIDE} yield, in the frame of the link before"),
            ("mobility_determinant", "", "determinant of that mobility, times (l/r)^2"),
            ("mobility_drift_x mobility_drift_y", "1/s^2", "acceleration of the joint without the chain beyond it"),
            ("mobility_minor_x mobility_minor_y", "1/s^2", "adjugate of the mobility times that acceleration, times l/r"),
            ("inverse_rest", "", "1 / pivot of the way back"),
            ("base_rest base_rest_push base_rest_across base_rest_force", "", "what the way back takes from the elimination"),
            ("base_reach base_coupling_skew", "", "what the way back takes from the elimination"),
            ("inverse_meeting", "", "1 / det(I + A W), where the eliminations from the base and from the tip meet"),
            ("met_force_x met_x met_y", "1/s^2", "force and acceleration there"),
            ("rest", "1/s^2", "acceleration across the link if its outer end had none"),
            ("inner_x inner_y", "1/s^2", "acceleration of the joint less gravity, in the frame of the link, over its length"),
            ("inner_force_x inner_force_y", "1/s^2", "force at the joint, in the frame of the link, over m r^2 / l"),
            ("force_x force_y end_force_x", "1/s^2", "force at the outer end of the link before, over m r^2 / l"),
            ("end_x end_y inner_end_x inner_end_y", "1/s^2", "acceleration of the outer end of the link before, over its length"),
            ("counterweight minor_counterweight determinant_counterweight", "", "mass of the next link in this link's units"),
            ("leverage_squared overhang_squared lever", "", "(l/r)^2, (l/r - 1)^2, (l/r) (l/r - 1)"),
            ("next_skew next_lever next_determinant next_minor", "", "what takes results into the units of the next link"),
        ),
        "planar",
    ),
    Quantities(
        _FIELD | _TENSIONS, "(15)",
        rows(
            ("acceleration", "rad/s^2", "absolute angular acceleration of a link"),
            ("joint_angle", "rad", "angle of a link against the one before"),
            ("joint_rate", "rad/s", "rate of a link against the one before"),
        ),
        "planar",
    ),
    Quantities(
        _DYNAMICS | _TENSIONS | _FORCES, "section 5",
        rows(
            ("sine cosine", "", "sine and cosine of the joints' angles"),
            ("joint_saturation cart_saturation", "", "tanh(v / v_0) of dry friction"),
            ("resistance", "N m s/rad", "slope of what resists a joint's rate"),
        ),
        "planar",
    ),
    Quantities(
        _ANGLES - _FORCES, "section 2", rows(("sine cosine", "", "sine and cosine of the absolute angles")),
        "planar",
    ),
    Quantities(
        _DYNAMICS | _TENSIONS, "section 5",
        rows(
            ("cosine", "", "q_(k-1) . q_k, cosine of the angle between neighbours"),
            ("cross cross_x cross_y cross_z", "", "q_(k-1) x q_k"),
            ("omega", "rad/s", "angular velocity of a link, q_k x q_k'"),
            ("turning_x turning_y turning_z", "rad/s^2", "angular acceleration of a link"),
            ("inverse_pivot", "", "1 / determinant of the inertia against which a link turns"),
            ("outer", "", "the chain beyond a joint, inertia and force split along and across its first link"),
            ("axial", "m", "inertia of the chain beyond along the link, which is free to turn"),
            ("inverse_axial", "1/m", f"1 / inertia {_OF_LINKS}, along the link"),
            ("free", "1/s^2", "acceleration of a link's tip while its joint rests, over its length"),
            ("reach", "", "r/l of a link, the distance of its mass over its length"),
            ("reach_squared", "", "(r/l)^2, a link's own inertia against turning, over m l^2"),
            ("overhang_share overhang_squared", "", "1 - r/l of a link, and its square"),
            ("tip_lever", "", "(r/l) (1 - r/l) of a link"),
            ("over_end_inertia", "1/(M L^2)", "1 / (m l^2) of a link"),
            ("link_mass_step", "", "mass of a link over that of the one before"),
            ("freed", "", "(r/l) (1 - r/l) over that determinant"),
            ("slope gain", "", "share of the joint's acceleration along the link, and in any direction, that slows the tip"),
            ("joint_x joint_y joint_z", "1/s^2", "acceleration of the joint less gravity, over a length"),
        ),
        "spatial",
    ),
    Quantities(
        frozenset({"step"}), "",
        rows(
            ("q_stage v_stage", "as q, v", "state at a stage of the step"),
            ("velocity", "as v", "rate of q at a stage"),
            ("acceleration", "as a", "accelerations at a stage"),
        ),
    ),
    Quantities(
        _ANGLES | _TENSIONS, "section 2",
        rows(
            ("phi link_phi", "rad", "absolute angle of a link, from the hanging vertical"),
            ("rate link_rate", "rad/s", "absolute angular rate of a link"),
            ("alpha link_alpha", "rad/s^2", "absolute angular acceleration of a link"),
        ),
        "planar",
    ),
    Quantities(
        _ANGLES, "(13)-(16)",
        rows(
            ("mu", "kg m", "first moment of a link: m_k r_k + l_k (mass beyond)"),
            ("c_diagonal", "kg m^2", "second moment of a link: m_k r_k^2 + l_k^2 (mass beyond)"),
            ("outer_mass", "kg", "mass beyond a link"),
            ("absolute_mass", "kg m^2", "inertia matrix for absolute angles"),
            ("half", "", "a matrix for absolute angles half-way to the scene's own"),
            ("entry", "kg m^2", "inertia between a pair of links, for absolute angles"),
            ("inertia", "kg m^2", "l_i mu_j of a pair of links"),
            ("projection", "", "q_i . q_j, or of what of them is orthogonal to the other"),
            ("cart_coupling", "kg m", "inertia between the cart and the links, for absolute angles"),
            ("cart_row", "kg m", "inertia between the cart and the links, for the scene's angles"),
            ("pull", "", "l_k w_k^2, m/s^2, or mu_k w_k^2, N"),
            ("inner_part", "N m", "share of the links before in the velocity terms"),
            ("absolute_coriolis absolute_gravity absolute_torque", "N m", "moments for absolute angles"),
            ("falling", "N m", "g mu_k s_k"),
        ),
    ),
    Quantities(
        frozenset({"energy", "momentum"}), "section 1",
        rows(
            ("joint_speed_x joint_speed_y joint_speed_z", "m/s", "velocity of a joint"),
            ("mass_speed_x mass_speed_y mass_speed_z", "m/s", "velocity of a link's mass"),
            ("sideways", "1/s", "rate of a link's direction, its horizontal part"),
            ("turning_x turning_y turning_z", "1/s", "rate of a link's direction, q_k'"),
            ("joint_depth", "m", "how deep a joint hangs below the base"),
            ("twice_kinetic", "J", "twice the kinetic energy, link by link"),
            ("fallen", "J", "the potential energy, its sign turned, link by link"),
            ("length_beyond", "m", "length of a link beyond its mass"),
            ("mass_momentum", "kg m/s", "momentum of a link's mass"),
            ("momentum_x momentum_y momentum_z", "kg m/s", f"momentum {_OF_LINKS}"),
            ("beyond_x beyond_y beyond_z", "kg m/s", "momentum of all beyond a link"),
        ),
    ),
    Quantities(
        _TENSIONS | _FORCES, "(15)",
        rows(
            ("rate_squared", "rad^2/s^2", "squared absolute rate of a link"),
            ("base_x base_y", "m/s^2", "acceleration of the joint less gravity in the frame of the link before"),
            ("joint_x joint_y", "m/s^2", "acceleration of the joint less gravity, in the frame of the link"),
            ("inertial_x inertial_y", "N", "mass times acceleration of a link's mass"),
            ("force_x force_y", "N", f"force that the motion {_OF_LINKS} takes, in the frame of the link"),
            ("beyond_x beyond_y", "N", "force that the motion of all beyond the link takes"),
        ),
        "planar",
    ),
    Quantities(frozenset({"positions"}), "section 1", rows(("joint_x joint_y joint_z", "m", "position of a joint"))),
    beside.balance(_BALANCE),
    beside.series(_SERIES),
    beside.tension_slopes(), *beside.joint_slopes(), beside.column_sweeps(),
    beside.in_lanes(_DYNAMICS), beside.geared(_DYNAMICS | _SERIES),
    beside.dry_friction(_DYNAMICS | _TENSIONS | _FORCES | _STEPS | _IMPLICIT), beside.dry_slopes(_IMPLICIT),
    beside.dry_series(_SERIES),
    beside.moments(_SERIES, "planar", "coefficient of the moment on a link, as far as it is known"),
    beside.moments(_SERIES, "spatial", "coefficient of what resists a joint"),
)  # fmt: skip
"""Every explained name. What stands in no row is explained by the line that computes it."""

DERIVATIVE: Final = Quantity("d_NAME", "", "derivative of NAME with respect to the entry of an argument that is at hand")
"""What stands for the derivatives of all the others."""


def quantities_of(function: str, chain: Chain) -> list[tuple[Quantities, Quantity]]:
    """The rows that explain names of a function, in the table's order; the first row of a name is the one that counts."""
    found: dict[str, tuple[Quantities, Quantity]] = {}
    for group in TABLE:
        if function in group.functions and group.space in ("", "planar" if chain.is_planar else "spatial"):
            for row in group.rows:
                found.setdefault(row.name, (group, row))
    return list(found.values())
