"""What a scene wants of the contract's functions, checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from phichain.contract.chain import Kind
from phichain.contract.functions import FUNCTIONS, ROWS
from phichain.contract.words import nearest
from phichain.errors import SceneError, UnsupportedError

_COMMANDS: Final = {
    word: remedy
    for words, remedy in (
        ("controller regulator observer supervisor", 'say "phichain controller SCENE" (docs/controllers.md)'),
        ("lqr gains", 'say "phichain lqr SCENE", or "phichain controller SCENE" for them in C'),
        ("swingup swing_up", 'say "phichain swingup SCENE" (docs/swingup.md)'),
    )
    for word in words.split()
}
"""What is made of a chain and a task by a command, and is no function of the chain alone."""

_MEANT: Final = {
    word: remedy
    for words, remedy in (
        ("acceleration accelerations equations_of_motion dynamics ode rhs", 'want "forward_dynamics"'),
        ("torque torques joint_torques force forces inverse", 'want "inverse_dynamics" for the forces of a motion'),
        ("reaction reactions reaction_forces joint_forces constraint_forces axial_forces", 'want "tensions"'),
        ("kinetic potential hamiltonian lagrangian kinetic_energy potential_energy", 'want "energy"'),
        ("inertia inertia_matrix", 'want "mass_matrix"; a link\'s own moment of inertia is chain.inertia'),
        ("gravity", 'want "gravity_torque"'),
        ("friction damping", 'it is part of "forward_dynamics"'),
        ("kinematics forward_kinematics tip position", 'want "positions"'),
        ("jacobian jacobians derivatives gradient", 'want "state_jacobian" or "dynamics_and_jacobian"'),
        ("linear linearize linearise linearized state_space poles modes", 'want "linearization"'),
        ("simulate simulation integrate trajectory flow motion", 'want "propagate"; simulate takes what is there'),
        ("rk4 runge_kutta integrator", 'want "step"'),
        ("limit_cycle limit_cycles harmonic_balance", 'want "phi" and "phi_jacobian"'),
        ("power work loss dissipation", 'want "energy" along a motion'),
    )
    for word in words.split()
}
"""What people call functions of ours."""


def wanted(value: object, kind: Kind) -> tuple[str, ...]:
    """Check a list of wanted functions and return it in the contract's order, each name once.

    Args:
        value: The list of names.
        kind: What the scene is.

    Raises:
        SceneError: The value is no list of names, or a name is unknown (one spelled much alike is given, or what is meant by it).
        UnsupportedError: A function is not defined for such a scene (what to use instead is given).
    """
    label = "functions.want"
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise SceneError(label, value, "is not a list of function names", 'write want = ["forward_dynamics"]')
    for name in value:
        _check_function(label, name, kind)
    if not value:
        raise SceneError(label, value, "asks for no function", 'write want = ["forward_dynamics"]')
    return tuple(name for name in FUNCTIONS if name in value)


def _check_function(label: str, name: object, kind: Kind) -> None:
    """Refuse what is no function, or none of such a scene.

    Raises:
        SceneError: It is no name of a function.
        UnsupportedError: Such a scene has no such function.
    """
    if not isinstance(name, str):
        raise SceneError(label, name, "holds what is no function name", 'write want = ["forward_dynamics"]')
    if name not in ROWS:
        word = name.lower().replace(" ", "_").replace("-", "_")
        if word in _COMMANDS:
            raise SceneError(label, name, "is no function of a chain but made by a command", _COMMANDS[word])
        best = nearest(name, FUNCTIONS)
        guess = f'did you mean "{best}"? The functions' if best else "the functions"
        meant = None if best else _MEANT.get(word)
        remedy = meant or f"{guess} are {', '.join(FUNCTIONS)}"
        raise SceneError(label, name, "is not a function", remedy, nearest=best)
    reason = ROWS[name].absence(kind)
    if reason is not None:
        raise UnsupportedError(label, name, reason.problem, reason.remedy)
