"""Words of physics that are no keys: what a scene holds in their place, in one sentence each.

Somebody who writes `rotor` does not mean `cart_mass`, however alike the letters are. So words that people who build rigs use are looked up
here before any key of similar spelling is offered; the keys themselves are in `keys`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final


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
_ROPE: Final = Answer(
    "is slack or taut, and the links of a chain are rigid", 'want "tensions", which say where a link would be pressed; below zero a rope is no chain'
)
_SPIN: Final = Answer(
    "turns a link about its own axis, and links are thin rods that have no such motion", "remove it; chain.inertia is about an axis across the link"
)
_ROTARY: Final = Answer(
    "is a base that turns about the vertical, which is not served", 'use base = "fixed", "cart" or "moving" (docs/rigs.md says how near a cart comes)'
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

_TABLE: Final[tuple[tuple[str, Answer], ...]] = (
    ("rotor rotor_inertia motor_inertia reflected_inertia drive_inertia", _ROTOR),
    (
        "motor motors motor_voltage voltage current volt torque_constant motor_constant kt km ke back_emf emf resistance inductance servo stepper",
        _MOTOR,
    ),
    ("gear gears gear_ratio gearbox transmission reduction gear_efficiency efficiency belt pulley pinion", _GEAR),
    ("backlash play hysteresis dead_zone deadzone contact contacts impact collision ground wall floor restitution", _STOPS),
    ("limit limits", _EITHER),
    ("joint_limit joint_limits angle_limit angle_limits stop stops joint_stop end_stop bumper rail track track_length x_max x_limit", _STOPS),
    ("torque_limit torque_limits force_limit max_torque max_force max_current max_voltage saturation u_max u_limit effort_limit", _LIMITS),
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
    ("rail_friction rail_damping cart_viscous cart_drag", _is("friction of a cart", "chain.cart_damping, N s/m, or chain.cart_friction, N")),
    ("moment_of_inertia moments_of_inertia moi rotational_inertia i_zz i_xx i_yy izz ixx iyy i j", _is("inertia", "chain.inertia", "kg m^2 about the centre of mass")),
    ("centre_of_mass center_of_mass cog center_of_gravity centre_of_gravity lc l_c r", _is("the centre of mass", "chain.com", "m from the base joint")),
    ("m masses weight weights link_mass", _is("masses", "chain.mass", "kg")),
    ("l len lengths link_length size", _is("lengths", "chain.length", "m")),
    ("m0 m_0 base_mass trolley_mass cart cart_weight", _is("the mass of a cart", "chain.cart_mass", "kg, with base = \"cart\"")),
    ("g grav", _is("gravity", "chain.gravity", "m/s^2")),
    ("n dof number_of_links n_links link_count num_links", _is("the number of links", "chain.links")),
    ("dim dimension dimensions plane spherical", _is("the kind of space", 'chain.space = "planar" or "spatial"')),
    ("coordinates angle_convention convention", _is("the kind of angles", 'joints.angles = "relative", "absolute" or "adjacent"')),
    ("precision dtype type single double float", _is("the type of numbers", 'target.real = "double" or "float"')),
    ("output outputs wanted function", _is("the functions that are wanted", "functions.want = [...]")),
)  # fmt: skip


def _spelled(rows: Iterable[tuple[str, Answer]]) -> dict[str, Answer]:
    return {word: answer for words, answer in rows for word in words.split()}


WORDS: Final = _spelled(_TABLE)
"""Every word and its answer."""


def answer_of(word: str) -> Answer | None:
    """Return what is said of a word, however it is written: `Joint Limits`, `joint-limits` and `joint_limits` are one."""
    return WORDS.get("_".join(word.lower().replace("-", " ").replace("_", " ").split()))
