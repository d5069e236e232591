"""Words of physics that are no keys: what a scene holds in their place, in one sentence each.

Somebody who writes `rotor` does not mean `cart_mass`, however alike the letters are. So words that people who build rigs use are looked up
here before any key of similar spelling is offered; the keys themselves are in `keys`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from phichain.contract.bases import bases


@dataclass(frozen=True)
class Answer:
    """What is said of a word.

    Attributes:
        problem: what it is, and why no key has its name.
        remedy: what the scene can hold instead, or where else to say it.
    """

    problem: str
    remedy: str


def _is(what: str, key: str, unit: str = "") -> Answer:
    """Another word for what a key holds."""
    return Answer(f"is not what a scene calls {what}", f"write {key}{f', {unit}' if unit else ''}")


*_FIRST, _LAST = (f'"{word}"' for word in bases())
_BASES: Final = f"{', '.join(_FIRST)} or {_LAST}"

_STOPS: Final = Answer(
    "is a law with corners, and a scene holds smooth ones alone",
    "let an event of simulate find where it is reached, and go on from there",
)
_EITHER: Final = Answer(
    "limits a joint or an input, and a scene holds neither", "let an event of simulate find where a joint stops; saturate u in the law that it calls"
)
_LIMITS: Final = Answer("limits what is passed as u, not the chain", "saturate u where it is computed, in the law that simulate calls")
_MOTOR: Final = Answer(
    "belongs to a motor, and the inputs of a scene are torques, forces and accelerations",
    "turn the motor's data into joints.armature, joints.damping and torque per volt by phichain.rigs (docs/rigs.md)",
)
_ROTOR: Final = Answer(
    "is the inertia of a rotor, which a scene has at its joint",
    "write joints.armature = n^2 J_rotor, kg m^2, or add n^2 J_rotor / p^2 to chain.cart_mass behind a pulley of radius p",
)
_GEAR: Final = Answer(
    "is a gear, whose ratio n is in the numbers of its joint", "multiply the motor's torque by n, its damping and rotor inertia by n^2 (phichain.rigs)"
)
_PULLEY: Final = Answer(
    "is what a motor draws a cart or turns a joint by, whose ratio is in the numbers of what it moves",
    "use phichain.rigs: belt_cart for chain.cart_mass, chain.cart_damping and force per volt, at_joint for a joint (docs/rigs.md)",
)
_ROPE: Final = Answer(
    "is slack or taut, and the links of a chain are rigid", 'want "tensions", which say where a link would be pressed; below zero a rope is no chain'
)
_SPIN: Final = Answer(
    "turns a link about its own axis, and links are thin rods that have no such motion", "remove it; chain.inertia is about an axis across the link"
)
_ROTARY: Final = Answer(
    "is a base that turns about the vertical, which is not served", f"use base = {_BASES} (docs/rigs.md says how near a cart comes)"
)
_BRANCH: Final = Answer("makes a tree or a loop, and every link of a chain hangs on the one before", "give the links in one row from the base on")
_FORCES: Final = Answer("is computed, not given", 'want "tensions" for the force in every link, or "inverse_dynamics" for the forces of a motion')
_INPUT: Final = Answer(
    "is passed at run time, not kept in a scene", "say in joints.actuated which inputs there are, and pass u to the functions or to simulate"
)
_START: Final = Answer("is a state, and a scene holds the chain alone", "pass it to simulate or propagate as x0 = (q, v)")
_RUN: Final = Answer("belongs to a run, and a scene holds the chain alone", "pass it to simulate")
_SHAPE: Final = Answer(
    "is the shape of a body, of which a scene holds mass, com and inertia", "compute them by phichain.rigs: rod, tube, cylinder, box or disc (docs/rigs.md)"
)
_MOVED: Final = Answer("moves the base", 'write base = "moving" in [chain]; its acceleration, the last component down, is then the first part of u')
_FLEXIBLE: Final = Answer("bends a link, and the links of a chain are rigid", "use several short links with joints.stiffness between them")
_DRAG: Final = Answer("is a force of the air, which no key holds", "use joints.damping where a linear law at the joints will do, or add torques to u")
_LAW: Final = Answer("belongs to a controller, and a scene holds the chain alone", "pass it to lqr, or to the law that simulate calls")
_NOISE: Final = Answer("is random, and a scene is one chain that moves by its equations alone", "add it to u in the law that simulate calls, or to what is measured")
_UNITS: Final = Answer("chooses units, and a scene's are consistent ones of the user's own, angles in rad", "convert to kg, m, s and rad")
_COULOMB: Final = Answer(
    "is dry friction, which a scene regularises as F tanh(v / v_0)",
    "write joints.friction with joints.friction_speed, or chain.cart_friction with chain.cart_friction_speed",
)

_LOAD: Final = Answer(
    "is a mass on a link, which is part of its body", "make one link of both by phichain.rigs: link(length, rod(...), point(mass, place)) (docs/rigs.md)"
)
_BEARING: Final = Answer("is a joint, and those of a scene have no mass", "write joints.damping or joints.friction for what it resists; its mass belongs to a link")
_JOINT: Final = Answer(
    "is a kind of joint, and those of a chain turn about one axis in the plane and about all but the link's own in space",
    'set chain.space; what slides is the cart of base = "cart"',
)
_TILTED: Final = Answer(
    "tilts gravity, which points along the last axis", "use gravity times cos(tilt) for a plane of motion that is tilted; a rail that is not horizontal is not served"
)
_FIELD: Final = Answer("is a force that no key holds", "add its torques about the joints to u")
_RATIO: Final = Answer("is a share of critical damping, which hangs on the motion", "write joints.damping in N m s/rad: 2 zeta times the root of stiffness times inertia")
_FOUND: Final = Answer("is found, not given", 'want "linearization", or say "phichain trace SCENE --mode 1" for the family that begins with a mode')
_CLUTCH: Final = Answer("locks a joint and lets it go, a law with corners", "run one scene for each state, from an event of simulate to the next")
_MEASURING: Final = Answer("belongs to what measures, and a scene holds the chain alone", "round or sample in the law that simulate calls (sample=, delay=)")
_ASIDE: Final = Answer("lies beside the line from joint to joint, where links have no mass", "count the last link's angle from its joint to its centre of mass (docs/rigs.md)")
_RIGID: Final = Answer("stretches a link, and the links of a chain are rigid", "use joints.rest_angle for a joint's spring that rests at an angle")
_WHOLE: Final = Answer("is of the whole chain, and a scene has a number for each link", "write chain.mass and chain.length link by link, or one number for all")
_CORNERS: Final = Answer(
    "is a law of dry friction with corners or ripples, and a scene regularises it as F tanh(v / v_0)",
    "write joints.friction with joints.friction_speed, or add the rest to u",
)
_ROLLING: Final = Answer("resists what rolls or turns", "write chain.cart_friction, N, with chain.cart_friction_speed, chain.cart_damping, N s/m, or joints.damping, N m s/rad")
_CART_SPRING: Final = Answer("pulls on the cart, where a scene has no spring", "add -k x to the force in u")

_TABLE: Final[tuple[tuple[str, Answer], ...]] = (
    ("rotor rotor_inertia motor_inertia reflected_inertia drive_inertia", _ROTOR),
    (
        "motor motors motor_voltage voltage current volt torque_constant motor_constant kt km ke back_emf emf resistance inductance servo stepper",
        _MOTOR,
    ),
    ("gear gears gear_ratio gearbox transmission reduction gear_efficiency efficiency", _GEAR),
    ("belt pulley pinion rack sprocket lead_screw leadscrew ball_screw capstan", _PULLEY),
    ("backlash play hysteresis dead_zone deadzone contact contacts impact collision ground wall floor restitution", _STOPS),
    ("limit limits", _EITHER),
    ("joint_limit joint_limits angle_limit angle_limits stop stops joint_stop end_stop bumper rail track track_length x_max x_limit", _STOPS),
    ("torque_limit torque_limits force_limit max_torque max_force max_current max_voltage saturation u_max u_limit effort_limit", _LIMITS),
    ("stall_torque rated_torque nominal_torque continuous_torque peak_torque holding_torque speed_torque_gradient", _MOTOR),
    ("no_load no_load_speed no_load_current rated_speed nominal_speed speed_constant velocity_constant", _MOTOR),
    ("time_constant mechanical_time_constant electrical_time_constant", _MOTOR),
    ("rope cable string wire tendon slack chain_slack taut", _ROPE),
    ("spin twist torsion roll axial_inertia polar_inertia gyroscope gyroscopic flywheel reaction_wheel", _SPIN),
    ("rotary rotary_base rotary_arm arm arm_length furuta turntable yaw", _ROTARY),
    ("branch branches parent parents child children tree loop loops closed_loop topology mechanism", _BRANCH),
    ("tension tensions reaction reactions reaction_force joint_force joint_forces constraint_force constraint_forces", _FORCES),
    ("torque torques force forces input inputs u control control_input actuator actuators actuation actuated_joints tau", _INPUT),
    ("initial initial_state initial_angle initial_angles start state q q0 v0 x0 x theta theta0 angle angle0 omega omega0", _START),
    ("time t dt step step_size h t_end duration tolerance tol method integrator solver atol rtol", _RUN),
    ("density radius radii diameter thickness width height section material shape geometry body bodies", _SHAPE),
    ("pivot pivot_motion base_acceleration base_motion shake shaker excitation vibration vertical", _MOVED),
    ("flexible flexibility elastic elasticity beam bending youngs_modulus modulus", _FLEXIBLE),
    ("drag air_drag air_resistance aerodynamic wind", _DRAG),
    ("gain gains k_p k_d pid lqr regulator observer reference setpoint target_angle sample sample_time ts delay", _LAW),
    ("noise disturbance sigma uncertainty", _NOISE),
    ("unit units degrees deg rad radians", _UNITS),
    ("coulomb coulomb_friction dry_friction stiction static_friction friction_torque friction_coefficient", _COULOMB),
    ("viscous viscous_friction viscosity damper dampers damping_coefficient joint_damping", _is("damping", "joints.damping", "N m s/rad")),
    ("spring springs spring_constant spring_stiffness joint_stiffness", _is("a joint's spring", "joints.stiffness", "N m/rad")),
    ("spring_angle neutral_angle equilibrium_angle", _is("a spring's angle of rest", "joints.rest_angle", "rad")),
    ("rail_friction rail_damping track_friction track_damping cart_viscous cart_drag", _is("friction of a cart", "chain.cart_damping, N s/m, or chain.cart_friction, N")),
    ("moment_of_inertia moments_of_inertia moi mass_moment inertia_matrix inertia_tensor rotational_inertia i_zz i_xx i_yy izz ixx iyy i j", _is("inertia", "chain.inertia", "kg m^2 about the centre of mass")),
    ("centre_of_mass center_of_mass cog center_of_gravity centre_of_gravity lc l_c r", _is("the centre of mass", "chain.com", "m from the base joint")),
    ("m masses weight weights link_mass", _is("masses", "chain.mass", "kg")),
    ("l len lengths link_length size", _is("lengths", "chain.length", "m")),
    ("m0 m_0 base_mass trolley_mass cart cart_weight", _is("the mass of a cart", "chain.cart_mass", "kg, with base = \"cart\"")),
    ("g grav", _is("gravity", "chain.gravity", "m/s^2")),
    ("n dof number_of_links n_links link_count num_links", _is("the number of links", "chain.links")),
    ("dim dimension dimensions plane spherical", _is("the kind of space", 'chain.space = "planar" or "spatial"')),
    ("coordinates angle_convention convention", _is("the kind of angles", 'joints.angles = "relative", "absolute" or "adjacent"')),
    ("precision dtype type single double float", _is("the type of numbers", 'target.real = "double" or "float"')),
    ("payload load tip_load tip_mass end_mass end_load point_mass bob ball counterweight balance_weight motor_mass motor_weight stator_mass hinge_mass joint_mass bearing_mass encoder_mass coupling_mass", _LOAD),
    ("bearing bearings hinge hinges pin axle shaft", _BEARING),
    ("revolute ball_joint universal_joint universal gimbal prismatic slider slide joint_type axis_of_rotation wheel wheels", _JOINT),
    ("tilt tilted incline inclined inclination slope gravity_vector gravity_direction gravity_angle rail_angle track_angle", _TILTED),
    ("magnet magnets electromagnet magnetic field thrust propeller buoyancy fluid water added_mass external_force external_torque", _FIELD),
    ("damping_ratio zeta quality_factor q_factor loss_factor logarithmic_decrement decay decay_rate half_life", _RATIO),
    ("frequency natural_frequency frequencies eigenfrequency period mode modes", _FOUND),
    ("brake brakes clutch lock locked", _CLUTCH),
    ("encoder encoders resolution quantization sensor sensors filter latency", _MEASURING),
    ("supply_voltage battery power pwm duty duty_cycle amplifier microsteps steps_per_rev poles", _MOTOR),
    ("offset com_offset eccentricity eccentric", _ASIDE),
    ("rest_length stretch axial_stiffness preload pretension", _RIGID),
    ("total_mass total_length chain_mass chain_length", _WHOLE),
    ("stribeck static_torque breakaway breakaway_torque cogging cogging_torque detent detent_torque ripple", _CORNERS),
    ("rolling rolling_resistance rolling_friction eddy_current eddy_currents", _ROLLING),
    ("cart_spring cart_stiffness", _CART_SPRING),
    ("stroke velocity_limit speed_limit max_speed max_velocity", _EITHER),
    ("mu friction_coeff friction_coefficients", _COULOMB),
    ("base_position base_velocity base_speed base_path", _MOVED),
    ("torsional_spring torsion_spring torsional_stiffness rotational_stiffness", _is("a joint's spring", "joints.stiffness", "N m/rad")),
    ("joint_friction joint_torque_friction", _is("dry friction of a joint", "joints.friction", "N m, with joints.friction_speed, rad/s")),
    ("output outputs wanted function", _is("the functions that are wanted", "functions.want = [...]")),
)  # fmt: skip


def _spelled(rows: Iterable[tuple[str, Answer]]) -> dict[str, Answer]:
    return {word: answer for words, answer in rows for word in words.split()}


WORDS: Final = _spelled(_TABLE)
"""Every word and its answer."""


#: What a part of a chain is called in front of what is said of it, and numbers.
_WHOSE: Final = frozenset({
    "link", "links", "rod", "rods", "pole", "poles", "pendulum", "arm", "bob", "first", "second", "third", "upper", "lower", "inner", "outer",
    "joint", "joints", "hinge", "shoulder", "elbow",
})  # fmt: skip
#: Keys that are said of such a part.
_KEYS: Final = {
    "mass": _is("masses", "chain.mass", "kg"), "length": _is("lengths", "chain.length", "m"), "inertia": _is("inertia", "chain.inertia", "kg m^2 about the centre of mass"),
    "com": _is("the centre of mass", "chain.com", "m from the base joint"), "damping": _is("damping", "joints.damping", "N m s/rad"),
    "stiffness": _is("a joint's spring", "joints.stiffness", "N m/rad"), "friction": _is("dry friction of a joint", "joints.friction", "N m, with joints.friction_speed, rad/s"),
}  # fmt: skip
#: Words that say little of a word that they are part of.
_VAGUE: Final = _WHOSE | {"cart", "size", "start", "state", "type", "time", "method", "function"}
#: Words longer than this are cut.
_LONGEST: Final = 80


def answer_of(word: str) -> Answer | None:
    """Return what is said of a word, however it is written: `Joint Limits`, `joint-limits` and `joint_limits` are one.

    Of `pole_mass` or `second_link_inertia` it is said what is said of `mass` and `inertia`.
    """
    parts = _parts(word)
    found = WORDS.get("_".join(parts))
    while found is None and len(parts) > 1 and (parts[0] in _WHOSE or parts[0].isdigit()):
        parts = parts[1:]
        found = WORDS.get("_".join(parts)) or _KEYS.get("_".join(parts))
    return found


def answer_of_part(word: str) -> Answer | None:
    """Return what is said of the first part that something is said of: of `bearing_drag` what is said of bearings."""
    parts = _parts(word)
    return next((WORDS[part] for part in parts if part in WORDS and len(part) > 2 and part not in _VAGUE), None) if len(parts) > 1 else None


def _parts(word: str) -> list[str]:
    return word[:_LONGEST].lower().replace("-", " ").replace("_", " ").split()
