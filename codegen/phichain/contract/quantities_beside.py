"""What the named quantities are beside the sweeps: with dry friction, with rotors at the joints, in two lanes, in the harmonic balance, in Taylor series."""

from __future__ import annotations

from phichain.contract.quantity import Quantities, rows


def geared(functions: frozenset[str]) -> Quantities:
    """Those of planar chains whose joints carry rotors, for some functions."""
    return Quantities(
        functions, "section 5, rotors",
        rows(
            ("beyond_inertia", "kg", "the chain beyond a joint: force along its first link per acceleration along it, X"),
            ("beyond_skew", "", "share of that across the first link, z"),
            ("beyond_reach", "m", "share of that in the turning of the link before, h"),
            ("beyond_across beyond_mixed", "", "what the rest of its inertia comes to across the link, E and F"),
            ("beyond_turning", "kg m^2", "and in turning, G"),
            ("beyond_determinant", "", "determinant of that rest, delta"),
            ("held_inertia", "kg", "X of the link and all beyond it"),
            ("held_skew held_reach", "", "z and h of the link and all beyond it"),
            ("held_across held_mixed", "", "E and F of the link and all beyond it"),
            ("held_turning", "kg m^2", "G of the link and all beyond it"),
            ("held_determinant", "", "delta of the link and all beyond it"),
            ("seen_xx seen_xy seen_yy", "kg", "inertia of the chain beyond in the frame of the link"),
            ("seen_moment", "kg m", "force along the link per turning of it, from the chain beyond"),
            ("turning_x turning_y", "kg m", "force that the chain beyond asks for while the link turns"),
            ("turning_moment", "kg m^2", "moment that it asks for then"),
            ("pivot", "kg m^2", "inertia against which a link turns, without the rotor at its joint"),
            ("inverse_turning", "", "1 / (pivot + rotor)"),
            ("share share_of", "", "rotor / (pivot + rotor)"),
            ("slack_of", "", "pivot / (pivot + rotor)"),
            ("minor_xx minor_xy", "", "minors of the inertia of the chain beyond, bordered by the turning"),
            ("beyond_x beyond_y", "N", "force that the motion of all beyond a joint asks for"),
            ("beyond_n", "N m", "moment that all beyond a joint asks for: the torque across it and what the rotor leaves of that"),
            ("joint_torque", "N m", "torque across a joint"),
            ("beside_joint", "N m", "torque on a link beside that across its joint, less what the chain beyond asks for"),
            ("driven", "N m", "torque on a link less what the chain beyond asks for"),
            ("drag", "rad/s^2", "what the force beyond takes from a link's acceleration"),
            ("loose", "rad/s^2", "acceleration of a link's angle while its joint and the link before rest"),
            ("slip", "rad/s^2", "acceleration of a joint's angle"),
            ("bend", "1/s^2", "second derivative of a link's direction, along it"),
        ),
        "planar",
    )  # fmt: skip


def dry_friction(functions: frozenset[str]) -> Quantities:
    """Those that dry friction brings along, w the rate of a joint or of a cart and v_0 the speed where it saturates."""
    return Quantities(
        functions, "section 1",
        rows(
            ("joint_ratio cart_ratio", "", "|w| / v_0 of dry friction"),
            ("joint_over_ratio cart_over_ratio", "", "v_0 / |w|"),
            ("joint_saturation cart_saturation", "", "tanh(|w| / v_0); in the plane with the sign of the rate"),
            ("joint_share cart_share", "", "tanh(|w| / v_0) v_0 / |w|, friction over what it were if it grew on as at rest"),
        ),
    )  # fmt: skip


def dry_slopes(functions: frozenset[str]) -> Quantities:
    """Those that it brings into implicit steps."""
    return Quantities(
        functions, "section 9",
        rows(
            ("resistance", "N m s/rad", "slope of what resists a joint's rate"),
            ("cart_slope", "N s/m", "slope of what resists a cart"),
            ("resisted", "", "couple per rate of every joint, N m s/rad, and its slope over w, N m s^3/rad^3, one after the other"),
        ),
    )  # fmt: skip


def dry_series(functions: frozenset[str]) -> Quantities:
    """Those that it brings into Taylor series."""
    return Quantities(
        functions, "section 10",
        rows(
            ("over", "", "1 / v_0 in the step's unit of time"),
            ("cart_rate", "", "coefficient of the cart's speed, for its friction"),
            ("rub_ratio", "", "|w| / v_0 where a step begins"),
            ("rub_saturation", "", "its tanh"),
            ("rub_share", "", "tanh(|w| / v_0) v_0 / |w|"),
            ("rub_square", "", "coefficient of |w|^2 / v_0^2"),
            ("rub_moved", "", "coefficient of tanh(|w| / v_0) v_0 / |w|"),
        ),
    )  # fmt: skip


def balance(functions: frozenset[str]) -> Quantities:
    """Those of the harmonic balance."""
    return Quantities(
        functions, "section 6",
        rows(
            ("swing link_swing", "rad", "amplitude of a link's absolute angle"),
            ("omega_squared", "rad^2/s^2", "squared angular frequency"),
            ("apart", "rad", "difference of two links' amplitudes"),
            ("acceleration_kernel centripetal_kernel", "", "harmonic of cos and sin of that difference in motion"),
            ("row row_with_springs", "N m", "balance for absolute angles, without and with the springs' moments"),
            ("mu", "kg m", "first moment of a link: m_k r_k + l_k (mass beyond)"),
            ("c_diagonal", "kg m^2", "second moment of a link: m_k r_k^2 + l_k^2 (mass beyond)"),
            ("outer_mass", "kg", "mass beyond a link"),
            ("joint_amplitude", "rad", "amplitude of a joint's angle"),
            ("spring_moment", "N m", "moment of a joint's spring"),
        ),
    )  # fmt: skip


def series(functions: frozenset[str]) -> Quantities:
    """Those of the Taylor recurrences."""
    return Quantities(
        functions, "section 10",
        rows(
            ("held", "", "what is constant over a step: the factored mass matrix and what goes with it, link by link"),
            ("left right", "", "coefficients of the factors of every product, order by order"),
            ("sums", "", "for every product what the coefficients that are known contribute to it"),
            ("newest", "", "the last row of left"),
            ("coefficient next", "", "the state's coefficients of order n, and of order n + 1"),
            ("row row_after row_ahead", "", "coefficients of the configuration of orders n, n + 1 and n + 2"),
            ("now", "", "n + 1, 1 / (n + 1), 1 / ((n + 1) (n + 2)), and 1 at order 0, else 0"),
            ("scale", "s", "unit of time in a step, and its square"),
            ("lost", "", "what rounding took from the state"),
            ("saturated steep", "", "tanh(v / v_0) of dry friction, and 1 less its square"),
            ("saturation_next change", "", "coefficient n + 1 of tanh(v / v_0), and of v / v_0 times n + 1"),
            ("lead", "", "variation of what stands before the first row of left"),
        ),
    )  # fmt: skip


def moments(functions: frozenset[str], space: str, meaning: str) -> Quantities:
    """What a moment is there."""
    return Quantities(functions, "section 10", rows(("moment", "", meaning)), space)


def tension_slopes() -> Quantities:
    """Those of spatial Jacobians where tensions tie the links."""
    return Quantities(
        frozenset({"state_jacobian", "dynamics_and_jacobian"}), "section 5, Jacobians by tensions",
        rows(
            ("slack tip_slack tip_slack_next", "", "scaled pivot of a link's row less 1, eliminated from the base or from the tip"),
            ("compliance tip_compliance", "", "scaled tension of a link per load on its own row"),
            ("inner outer", "", "what a tension makes of a change of the next one's, and of that of the one before"),
            ("answer_past answer_short", "", "tensions beyond and before a joint per change of the cosine of its links"),
            ("size_past size_short", "", "the same per change of what the sweep takes for their lengths, which is 1"),
            ("beside", "L", "direction of the link before, from cell k on; what the chain falls with before the first"),
            ("inwards onwards", "1/L", "how a link turns with the tension beyond it, and with the one before"),
            ("by_direction_here by_direction_next by_direction_back", "L/s^2", "tensions of a link and both its neighbours by its direction"),
            ("pulled leaning", "1/s^2", "pull of both neighbours on a link's tips over its length; with a cart that stays"),
            ("share passed", "", "what arrives of a change of tension"),
        ),
        "spatial",
    )  # fmt: skip


def joint_slopes() -> tuple[Quantities, ...]:
    """Those of spatial Jacobians where joints transmit moments, and where masses are before the ends of their links."""
    functions = frozenset({"state_jacobian", "dynamics_and_jacobian"})
    tied = rows(
        ("answer", "", "tensions from three links before a link to three beyond it by its direction and rates"),
        ("pair_slope", "", "forces of a link's couple by direction and rates of the link before, its own, and the next one's"),
        ("by_rate_next by_rate_back", "", "tensions two links beyond and before a link by its rates"),
        ("own_compliance onward_share backward_share", "", "compliance, outer and inner, with zeros beyond the ends"),
        ("resistance resistance_slope", "", "couple of a joint over the difference of its links' rates, and how it moves with that difference"),
        ("inner_pull outer_pull", "L/s^2", "tension of a link over its mass, and over that of the link before"),
    )
    before = rows(
        ("freedom", "1/M", "acceleration of a link's outer end per force on it, its joint held"),
        ("drawn drawn_freely", "", "acceleration of a link's outer end per stretch of the chain beyond, free and with its joint held"),
        ("joint_acceleration", "L/s^2", "acceleration of a link's joint less gravity"),
        ("stretch", "L/s^2", "tension of a link over what is inert along it"),
        ("passes passes_force", "", "what a link makes of its joint's acceleration, and of the force beyond its end (along the chain, and besides)"),
        ("rows_outwards rows_inwards", "", "a link's angular acceleration per acceleration of its joint, and per force beyond its end"),
        ("joint_mobility", "", "acceleration of a joint per force on it, the chain inside included"),
        ("force_by_direction_c force_by_direction_x force_by_direction_y force_by_direction_z force_by_rate_c force_by_rate_x force_by_rate_y force_by_rate_z", "", "forces that go inwards, column by column: along the chain, and besides"),
        ("motion_by_direction_x motion_by_direction_y motion_by_direction_z motion_by_rate_x motion_by_rate_y motion_by_rate_z", "", "accelerations that go outwards, column by column"),
        ("load force_from motion_from", "", "what a link disturbs at itself and its neighbours, column by column, the forces from there inwards and the motions outwards"),
        ("rate_load", "L/s", "what the ends of a link may differ by along it, by its rates"),
    )
    return Quantities(functions, "section 5, Jacobians by tensions", tied, "spatial"), Quantities(functions, "section 5, Jacobians by joints", before, "spatial")


def column_sweeps() -> Quantities:
    """Those of planar Jacobians whose columns go through one pair of loops."""
    return Quantities(
        frozenset({"dynamics_and_jacobian"}), "section 5, column by column",
        rows(
            ("reach", "", "force at the joint along the link per squared rate: l/r, and what the chain beyond adds"),
            ("turned_x turned_y", "1/s^2", "acceleration of the joint less gravity, in the frame of the link, over the length of the link before"),
            ("tip_slope", "rad/s", "twice the rate: what the tip's acceleration along the link loses per rate"),
            ("turn", "", "acceleration of a link's tip across it while its joint rests, per couple"),
            ("alpha", "1/s^2", "angular acceleration of the link"),
            ("push_x push_y", "", "force at the joint that a column's disturbance makes, in the frame of the link"),
            ("outer_push_x outer_push_y", "", "the same in the frame of the link before"),
            ("moved_joint_x moved_joint_y", "", "what a column makes of the joint's acceleration, in the frame of the link"),
            ("moved_tip_y", "", "what it makes of the acceleration of the link's tip, across it"),
            ("moved_alpha", "", "what it makes of the link's angular acceleration"),
        ),
        "planar",
    )


def in_lanes(functions: frozenset[str]) -> Quantities:
    """Those of long planar chains, whose two sides are lanes of one loop, for some functions."""
    return Quantities(
        functions, "section 5, from both ends in two lanes",
        rows(
            ("lane", "", "0: the tip's side, whose row i eliminates one link; 1: the base's side, its mobility for an inertia"),
            ("row_angle turn_sine turn_cosine", "", "the joint's angle by which a row turns what it carries, its sine and cosine"),
            ("row_drive", "1/s^2", "couple on the link over m r^2; on the base's side its rate squared"),
            ("row_spin", "1/s^2", "the link's rate squared; on the base's side the couple on it over m r^2"),
            ("seen_xx seen_xy seen_yy", "", "inertia of what a link carries, in its frame, over m (r/l)^2; l/r squared times a mobility"),
            ("seen_force_x seen_force_y", "1/s^2", "force that its motion asks for; l/r times an acceleration"),
            ("seen_minor_x seen_minor_y", "1/s^2", "adjugate of that inertia times that force, over l/r"),
            ("lifted", "", "the link's own part of the inertia across the next one"),
            ("push pull driven", "1/s^2", "parts of the forces along the link and across"),
            ("gain row_gain", "", "share of what happens along the link in what happens across it"),
            ("left_axial left_skew left_across left_inverse", "", "inertia that a link leaves for the next one, before and what multiplies it"),
            ("left_determinant", "", "its determinant, over l/r"),
            ("left_force_x left_force_y left_minor_x left_minor_y", "1/s^2", "force and adjugate times force that it leaves"),
            ("row_inverse row_free row_pull row_push row_axial row_across", "", "what the way back takes from the elimination"),
            ("base_pivot", "", "compliance along the link, its mass included"),
            ("met_x_force", "1/s^2", "force at the outer end of the link before, over m r^2 / l"),
        ),
        "planar",
    )
