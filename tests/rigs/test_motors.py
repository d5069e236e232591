"""Motors and carts: power in is heat and work, a published rig's numbers, a stepper's kinematics, and bad input."""

from __future__ import annotations

from math import pi

import pytest

from phichain import rigs
from phichain.errors import SceneError
from phichain.scene import Scene

MOTOR = rigs.Motor(torque_constant=0.05, resistance=1.2, rotor_inertia=2e-5, friction=1e-5)
IP02 = rigs.Motor(torque_constant=0.00767, resistance=2.6, rotor_inertia=3.90e-7)
"""Quanser's IP02: armature of 2.6 ohm, 0.00767 N m/A, 3.90e-7 kg m^2, gear 3.71, pinion of 6.35 mm."""


def test_power_in_is_heat_and_work() -> None:
    """At a steady speed of the joint: U i = R i^2 + rotor friction + torque w, whatever the gear."""
    n, volts, w = 20.0, 12.0, 3.0
    drive = rigs.at_joint(MOTOR, n, voltage=24.0)
    torque = drive.torque_per_input * volts - drive.damping * w
    current = (volts - 0.05 * n * w) / 1.2
    assert abs(volts * current - 1.2 * current**2 - 1e-5 * (n * w) ** 2 - torque * w) < 1e-12
    assert abs(drive.torque_limit - 24.0 * drive.torque_per_input) < 1e-14


def test_a_held_current_leaves_friction_alone() -> None:
    drive = rigs.at_joint(MOTOR, 20.0, current=3.0)
    assert abs(drive.damping - 400 * 1e-5) < 1e-17 and abs(drive.torque_per_input - 1.0) < 1e-15
    assert abs(drive.torque_limit - 3.0) < 1e-14 and abs(drive.armature - 400 * 2e-5) < 1e-17


def test_an_idle_motor_runs_until_its_back_emf_is_the_voltage() -> None:
    motor = rigs.Motor(0.05, 1.2, 2e-5, back_emf=0.052)
    drive = rigs.at_joint(motor, 10.0, voltage=12.0)
    assert abs(drive.torque_limit / drive.damping - 12.0 / (10.0 * 0.052)) < 1e-12


def test_efficiency_counts_for_all_that_comes_through_the_gear() -> None:
    whole, half = (rigs.at_joint(MOTOR, 5.0, voltage=6.0, gear_efficiency=eta, gear_inertia=1e-3) for eta in (1.0, 0.5))
    assert abs(half.torque_per_input - whole.torque_per_input / 2) < 1e-16
    assert abs((half.armature - 1e-3) - (whole.armature - 1e-3) / 2) < 1e-16
    assert abs(half.damping - whole.damping / 2) < 1e-16


def test_the_cart_of_a_published_rig() -> None:
    """1.0731 kg with its weight and the rotor, 1.72 N/V, 7.72 N s/m of back-EMF on top of 5.4 N s/m of the rail."""
    cart = rigs.belt_cart(IP02, 6.35e-3, 0.57 + 0.37, gear=3.71, voltage=6.0, cart_damping=5.4)
    assert abs(cart.cart_mass - 1.0731) < 5e-5
    assert abs(cart.force_per_input - 3.71 * 0.00767 / (2.6 * 6.35e-3)) < 1e-14
    assert abs(cart.cart_damping - 5.4 - (3.71 * 0.00767 / 6.35e-3) ** 2 / 2.6) < 1e-13
    assert abs(cart.force_limit - 10.34) < 5e-3
    scene = Scene("cart", 1, mass=0.1, length=0.3, **cart.keys)  # type: ignore[arg-type]
    assert (scene.base, scene.cart_mass, scene.cart_damping) == ("cart", cart.cart_mass, cart.cart_damping)


def test_a_belt_cart_keeps_the_motors_power() -> None:
    joint = rigs.at_joint(MOTOR, 4.0, voltage=24.0, gear_inertia=3e-5)
    cart = rigs.belt_cart(MOTOR, 0.02, 0.5, 4.0, voltage=24.0, pulley_inertia=3e-5)
    speed = 0.7
    force = cart.force_per_input * 10.0 - cart.cart_damping * speed
    torque = joint.torque_per_input * 10.0 - joint.damping * speed / 0.02
    assert abs(force * speed - torque * speed / 0.02) < 1e-12
    stored = (cart.cart_mass - 0.5) * speed**2
    assert abs(stored - joint.armature * (speed / 0.02) ** 2) < 1e-12


def test_a_stepper_moves_a_cart_by_steps() -> None:
    radius = rigs.pulley_radius(20, 0.002)
    assert abs(2 * pi * radius - 0.04) < 1e-17
    cart = rigs.stepped_cart(0.3, radius, 0.25, 3200, 40000.0, rotor_inertia=5e-6)
    assert abs(cart.step - 0.04 / 3200) < 1e-18 and abs(cart.speed_limit - 0.5) < 1e-15
    assert abs(cart.acceleration_limit - (0.3 / radius) / (0.25 + 5e-6 / radius**2)) < 1e-12
    assert Scene("stepped", 1, mass=0.1, length=0.3, **cart.keys).u_names == ("acceleration",)  # type: ignore[arg-type]


def test_joints_are_the_keys_of_a_scene() -> None:
    drive = rigs.at_joint(MOTOR, 20.0, current=3.0)
    scene = Scene("pair", 2, mass=1.0, length=1.0, **rigs.joints(0.01, drive))  # type: ignore[arg-type]
    assert scene.armature == (0.0, drive.armature) and scene.damping == (0.01, drive.damping)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rigs.Motor(0.0, 1.0, 1e-5), "torque_constant: is not positive (got 0.0); give a number above zero, N m/A"),
        (lambda: rigs.Motor(0.1, 1.0, -1e-5), "rotor_inertia: is negative (got -1e-05); give zero or a number above it, kg m^2"),
        (
            lambda: rigs.at_joint(MOTOR),
            "voltage: and current are the two ways to drive a motor (got nothing); give the limit of one of them",
        ),
        (
            lambda: rigs.at_joint(MOTOR, voltage=1.0, current=1.0),
            "voltage: and current are the two ways to drive a motor (got (1.0, 1.0)); give the limit of one of them",
        ),
        (
            lambda: rigs.at_joint(MOTOR, voltage=1.0, gear_efficiency=90),
            "gear_efficiency: is above one (got 90); give a part of one, such as 0.9 for 90 %",
        ),
        (lambda: rigs.at_joint(0.05, voltage=1.0), "motor: is not a Motor (got 0.05); give Motor(torque_constant, resistance, rotor_inertia)"),
        (lambda: rigs.joints(), "joints: has no joint (got ()); give a JointDrive or a damping for every joint"),
        (lambda: rigs.joints(-0.1), "joints: is negative (got -0.1); give zero or a number above it, N m s/rad, or a JointDrive"),
        (lambda: rigs.pulley_radius(20.5, 0.002), "teeth: is not a whole number (got 20.5); give the number of the pulley's teeth"),
        (
            lambda: rigs.stepped_cart(0.3, 0.01, 0.25, 3200, 0),
            "step_rate: is not positive (got 0); give a number above zero, 1/s",
        ),
    ],
)
def test_bad_numbers_are_refused(make, message):
    with pytest.raises(SceneError) as caught:
        make()
    assert str(caught.value) == message
