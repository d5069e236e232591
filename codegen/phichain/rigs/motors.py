"""Direct-current motors at joints: what they add to the chain, and what a volt or an ampere does.

With gear ratio n, efficiency eta of the gear, torque constant k_t, back-EMF constant k_e, resistance R, rotor inertia J and
friction b at the rotor, the joint turning at the relative rate w,

    torque = eta n (k_t i - J n w' - b n w),     i = (U - k_e n w) / R  driven by voltage, or given driven by current.

So the joint gains the armature eta n^2 J, the damping eta n^2 (k_t k_e / R + b), the first part by voltage alone, and what is left is
the torque per volt eta n k_t / R or per ampere eta n k_t. Inductance is left out: its time constant is far below the chain's.
Of the kinetic energy J / 2 (w_inner + n w)^2 the part n^2 J w^2 / 2 is kept; the rest is 1/n and 1/n^2 of it: count the rotor's mass and, for small
n, its inertia to the link that carries the motor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from phichain.errors import SceneError
from phichain.rigs.numbers import efficiency, not_negative, positive


@dataclass(frozen=True)
class Motor:
    """A direct-current motor, as its data sheet states it.

    Attributes:
        torque_constant: k_t, N m/A.
        resistance: R of the armature, ohm; of a brushless motor between two phases.
        rotor_inertia: J, kg m^2.
        back_emf: k_e, V s/rad; None for k_t, which it equals in these units.
        friction: b, viscous friction at the rotor, N m s/rad.
    """

    torque_constant: float
    resistance: float
    rotor_inertia: float
    back_emf: float | None = None
    friction: float = 0.0

    def __post_init__(self) -> None:
        """Check every number.

        Raises:
            SceneError: A number is none, or has the wrong sign.
        """
        positive("torque_constant", self.torque_constant, "N m/A")
        positive("resistance", self.resistance, "ohm")
        not_negative("rotor_inertia", self.rotor_inertia, "kg m^2")
        not_negative("friction", self.friction, "N m s/rad")
        if self.back_emf is not None:
            positive("back_emf", self.back_emf, "V s/rad")

    @property
    def braking(self) -> float:
        """k_t k_e / R, the drag of the shorted motor at its own shaft, N m s/rad."""
        back_emf = self.torque_constant if self.back_emf is None else self.back_emf
        return self.torque_constant * back_emf / self.resistance


@dataclass(frozen=True)
class JointDrive:
    """What a motor adds to the joint that it drives, and what its input does there.

    Attributes:
        armature: kg m^2, the key `joints.armature`.
        damping: N m s/rad, part of the key `joints.damping`.
        torque_per_input: N m per V or per A; the joint's torque in u is this times the input.
        torque_limit: the torque at the largest input, N m, on a joint at rest.
    """

    armature: float
    damping: float
    torque_per_input: float
    torque_limit: float


def at_joint(
    motor: Motor, gear: float = 1.0, *, voltage: float | None = None, current: float | None = None, gear_efficiency: float = 1.0,
    gear_inertia: float = 0.0,
) -> JointDrive:  # fmt: skip
    """A motor at a planar joint, driven by voltage (the back-EMF brakes it) or by an amplifier that holds its current.

    Args:
        motor: its data sheet.
        gear: n, turns of the rotor for one of the joint.
        voltage: the largest voltage, V, of a drive by voltage.
        current: the largest current, A, of a drive by current; one of the two is given.
        gear_efficiency: eta, at most 1. It holds while the motor drives; driven backwards a gear loses more.
        gear_inertia: of what turns with the joint on its side of the gear, kg m^2.

    Raises:
        SceneError: A number is none, or has the wrong sign; both limits are given, or none.
    """
    n, eta = positive("gear", gear, "turns of the rotor a turn of the joint"), efficiency("gear_efficiency", gear_efficiency)
    per_input, limit, drag = _driven(motor, voltage, current)
    armature = eta * n**2 * motor.rotor_inertia + not_negative("gear_inertia", gear_inertia, "kg m^2")
    torque = eta * n * per_input
    return JointDrive(armature, eta * n**2 * drag, torque, torque * limit)


def joints(*drives: JointDrive | float) -> Mapping[str, object]:
    """The keys of a scene for its joints, from the base on; a number stands for the damping of a joint without a motor, N m s/rad.

    Friction of bearings beside a motor comes on top: `dataclasses.replace(drive, damping=drive.damping + 0.01)`.

    Raises:
        SceneError: There is no joint, or what is given is neither a JointDrive nor a damping.
    """
    if not drives:
        raise SceneError("joints", drives, "has no joint", "give a JointDrive or a damping for every joint")
    full = [
        drive if isinstance(drive, JointDrive) else JointDrive(0.0, not_negative("joints", drive, "N m s/rad, or a JointDrive"), 0.0, 0.0)
        for drive in drives
    ]  # fmt: skip
    return MappingProxyType({"armature": [one.armature for one in full], "damping": [one.damping for one in full]})


def _driven(motor: object, voltage: float | None, current: float | None) -> tuple[float, float, float]:
    """Torque at the rotor per unit of the input, N m/V or N m/A; the largest input; drag at the rotor, N m s/rad."""
    if not isinstance(motor, Motor):
        raise SceneError("motor", motor, "is not a Motor", "give Motor(torque_constant, resistance, rotor_inertia)")
    if (voltage is None) == (current is None):
        given = None if voltage is None else (voltage, current)
        raise SceneError("voltage", given, "and current are the two ways to drive a motor", "give the limit of one of them")
    if voltage is not None:
        return motor.torque_constant / motor.resistance, positive("voltage", voltage, "V"), motor.braking + motor.friction
    return motor.torque_constant, positive("current", current, "A"), motor.friction
