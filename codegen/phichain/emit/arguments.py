"""What the arguments of emitted functions mean, and their units: the words of the header."""

from __future__ import annotations

from phichain.ir.nodes import Array
from phichain.scene import Scene

_ANGLES = {
    "relative": "each angle counted from the link before, the first from the hanging vertical",
    "absolute": "each angle counted from the hanging vertical",
    "adjacent": "the angle of link k from the hanging vertical is theta_k + theta_(k-1)",
}
_CONJUGATE = "the generalised force conjugate to each angle, N m"

_OF_ANY = {
    "q": "configuration",
    "v": "rates",
    "u": "inputs",
    "a": "accelerations",
    "h": "step, s",
    "q_next": "configuration after the step",
    "v_next": "rates after the step",
    "q_error": "estimated error of q_next: its difference to an embedded step of order 4",
    "v_error": "estimated error of v_next, likewise",
    "residual": "norm of (|q_k|^2 - 1) over the links before they are made unit: round-off when the iteration was enough",
    "q_out": "configuration with unit vectors",
    "v_out": "rates with every angular velocity orthogonal to its link",
}


def state_meanings(scene: Scene) -> dict[str, str]:
    """What the entries of q, v, u and a are, in order and with units: said once for all functions of a scene."""
    inputs = {"u": _inputs(scene)} if scene.nu else {}
    accelerations = f"the rates of v, {_units(scene, 'm/s^2', 'rad/s^2')}"
    return {"q": _configuration(scene), "v": _rates(scene), **inputs, "a": accelerations}


def meaning(scene: Scene, function: str, array: Array) -> str:
    """One line on an argument: what it is, in which units.

    Args:
        scene: whose function it is.
        function: the function's name in the contract.
        array: the argument.
    """
    text = _of_function(scene, function).get(array.name) or _OF_ANY.get(array.name) or array.doc
    return f"{array.shape[0]} x {array.shape[1]}, {text}" if len(array.shape) == 2 else text


def _of_function(scene: Scene, function: str) -> dict[str, str]:
    """Arguments that one function explains otherwise."""
    force = _units(scene, "N", "N m")
    match function:
        case "direction_dynamics":
            return {"q_dot": _direction_rates(scene), "q_ddot": f"the rates of q_dot, {_units(scene, 'm/s^2', '1/s^2')}"}
        case "inverse_dynamics":
            return {"u": f"generalised force conjugate to q, {force}"}
        case "mass_matrix":
            return {"out": f"M of M a + coriolis + gravity_torque = generalised force; {_inertias(scene)}"}
        case "coriolis" | "gravity_torque":
            terms = "velocity" if function == "coriolis" else "gravity"
            return {"out": f"{terms} terms, {force}"}
        case "energy":
            springs = ", springs included" if scene.stiffness is not None else ""
            return {"kinetic": "J", "potential": f"J, zero with all masses at the height of the base{springs}"}
        case "positions":
            axes = "[horizontal, down]" if scene.is_planar else "[horizontal, horizontal, down]"
            return {"out": f"row k holds the position {axes} of mass k, m"}
        case "linearization":
            return _linearization(scene)
        case "state_jacobian":
            return {f"dad{name}": f"partial derivatives of a by {name}" for name in "qvu"}
        case "phi" | "phi_jacobian":
            return _harmonic(scene, function, force)
    return {}


def _configuration(scene: Scene) -> str:
    cart = "position of the cart, m; then " if scene.has_cart else ""
    if not scene.is_planar:
        return f"{cart}the unit vector along each link, three components each, the last one down"
    return f"{cart}theta_k, rad: {_ANGLES[str(scene.angles)]}"


def _rates(scene: Scene) -> str:
    cart = "velocity of the cart, m/s; then " if scene.has_cart else ""
    if not scene.is_planar:
        return f"{cart}the angular velocity of each link, three components each, orthogonal to the link, rad/s"
    return f"{cart}the rate of each angle, rad/s"


def _direction_rates(scene: Scene) -> str:
    cart = "velocity of the cart, m/s; then " if scene.has_cart else ""
    return f"{cart}the rate of each unit vector, three components each, orthogonal to it, 1/s"


def _inputs(scene: Scene) -> str:
    force = ["horizontal force on the cart, N"] if scene.has_force else []
    if not scene.actuated_joints:
        return force[0]
    every = len(scene.actuated_joints) == scene.links
    joints = "every joint" if every else "joint " + ", ".join(map(str, scene.actuated_joints))
    is_torque = scene.angles == "relative"
    return "; then ".join([*force, f"the torque at {joints}, N m" if is_torque else _CONJUGATE])


def _units(scene: Scene, cart: str, link: str) -> str:
    return f"{cart} for the cart, {link} for the links" if scene.has_cart else link


def _inertias(scene: Scene) -> str:
    return "kg for the cart, kg m^2 for the links, kg m between them" if scene.has_cart else "kg m^2"


def _linearization(scene: Scene) -> dict[str, str]:
    cart = "the cart's position and " if scene.has_cart else ""
    what = "the angles" if scene.is_planar else "the two horizontal components of each link's rotation"
    return {
        "s": "+1 for a link that hangs down, -1 for one that stands up",
        "M": f"inertia; the coordinates x are {cart}{what}, counted from the equilibrium",
        "D": "damping",
        "G": "stiffness by gravity" + (" and springs" if scene.stiffness is not None else ""),
        "B": "how the inputs u enter",
    }


def _harmonic(scene: Scene, function: str, force: str) -> dict[str, str]:
    cart = "amplitude of the cart, m; then " if scene.has_cart else ""
    residual = f"what is left of the balance conjugate to each amplitude, {force}"
    derivative = "derivatives of phi by the amplitudes and, in the last column, by omega"
    return {
        "amplitude": f"{cart}the amplitude of each theta_k, rad",
        "omega": "angular frequency, rad/s",
        "out": residual if function == "phi" else derivative,
    }
