"""System: the frozen record of callables and sizes that every numerical package takes, and the state it moves."""

from phichain.system.arrays import Vector
from phichain.system.described import Drive, Joints, Numbers
from phichain.system.state import (
    VectorField,
    acceleration,
    angular_velocities,
    hat,
    input_arguments,
    pack,
    rhs,
    rhs_jacobian,
    unit_vectors,
    unpack,
    velocity,
)
from phichain.system.system import AbsentFunctionError, Parameters, System, given_system
from phichain.system.variations import variations

__all__ = [
    "AbsentFunctionError",
    "Drive",
    "Joints",
    "Numbers",
    "Parameters",
    "System",
    "Vector",
    "VectorField",
    "acceleration",
    "angular_velocities",
    "given_system",
    "hat",
    "input_arguments",
    "pack",
    "rhs",
    "rhs_jacobian",
    "unit_vectors",
    "unpack",
    "variations",
    "velocity",
]
