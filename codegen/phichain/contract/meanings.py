"""What the arguments of a chain's functions mean, and their units, where that depends on the chain: the words of the header."""

from __future__ import annotations

from phichain.contract.chain import Chain

_ANGLES = {
    "relative": "each angle counted from the link before, the first from the hanging vertical",
    "absolute": "each angle counted from the hanging vertical",
    "adjacent": "the angle of link k from the hanging vertical is theta_k + theta_(k-1)",
}
_CONJUGATE = "the generalised force conjugate to each angle, N m"


def state_meanings(chain: Chain) -> dict[str, str]:
    """What the entries of q, v, u and a are, in order and with units: said once for all functions of a chain."""
    inputs = {"u": _inputs(chain)} if chain.nu else {}
    accelerations = f"the rates of v, {units(chain, 'm/s^2', 'rad/s^2')}"
    return {"q": _configuration(chain), "v": _rates(chain), **inputs, "a": accelerations}


def _configuration(chain: Chain) -> str:
    cart = "position of the cart, m; then " if chain.has_cart else ""
    if not chain.is_planar:
        return f"{cart}the unit vector along each link, three components each, the last one down"
    return f"{cart}theta_k, rad: {_ANGLES[str(chain.angles)]}"


def _rates(chain: Chain) -> str:
    cart = "velocity of the cart, m/s; then " if chain.has_cart else ""
    if not chain.is_planar:
        return f"{cart}the angular velocity of each link, three components each, orthogonal to the link, rad/s"
    return f"{cart}the rate of each angle, rad/s"


def _inputs(chain: Chain) -> str:
    base = _base_inputs(chain)
    if not chain.actuated_joints:
        return base[0]
    every = len(chain.actuated_joints) == chain.links
    joints = "every joint" if every else "joint " + ", ".join(map(str, chain.actuated_joints))
    is_torque = chain.angles == "relative"
    return "; then ".join([*base, f"the torque at {joints}, N m" if is_torque else _CONJUGATE])


def _base_inputs(chain: Chain) -> list[str]:
    """What drives the base."""
    return [chain.base_law.meaning.format(size=chain.base_inputs)] if chain.base_inputs else []


def units(chain: Chain, cart: str, link: str) -> str:
    """Units of a vector with an entry for the cart, where there is one, and for the links."""
    return f"{cart} for the cart, {link} for the links" if chain.has_cart else link


def forces(chain: Chain) -> str:
    """The units of generalised forces."""
    return units(chain, "N", "N m")


def inertias(chain: Chain) -> str:
    """The mass matrix."""
    units = "kg for the cart, kg m^2 for the links, kg m between them" if chain.has_cart else "kg m^2"
    return f"M of M a + coriolis + gravity_torque = generalised force; {units}"


def kinetic(chain: Chain) -> str:
    """The kinetic energy, and the frame that it is counted in."""
    if chain.is_moving:
        return "J, of the motion against the base"
    return "J, of the chain alone" if chain.is_driven and chain.cart_mass is None else "J"


def potential(chain: Chain) -> str:
    """The potential energy and its zero."""
    springs = ", springs included" if chain.stiffness is not None else ""
    return f"J, zero with all masses at the height of the base{springs}"


def places(chain: Chain) -> str:
    """The positions of the masses."""
    axes = "[horizontal, down]" if chain.is_planar else "[horizontal, horizontal, down]"
    start = ", from the base" if chain.is_moving else ""
    return f"row k holds the position {axes} of mass k{start}, m"


def direction_rates(chain: Chain) -> str:
    """The rates of x and of the unit vectors."""
    cart = "velocity of the cart, m/s; then " if chain.has_cart else ""
    return f"{cart}the rate of each unit vector, three components each, orthogonal to it, 1/s"


def direction_accelerations(chain: Chain) -> str:
    """The rates of those."""
    return f"the rates of q_dot, {units(chain, 'm/s^2', '1/s^2')}"


def small_inertia(chain: Chain) -> str:
    """The inertia of (19), and which coordinates it is in."""
    cart = "the cart's position and " if chain.has_cart else ""
    what = "the angles" if chain.is_planar else "the two horizontal components of each link's rotation"
    told = "; the cart's rows say x'' = u" if chain.is_driven else ""
    return f"inertia; the coordinates x are {cart}{what}, counted from the equilibrium{told}"


def small_stiffness(chain: Chain) -> str:
    """The stiffness of (19)."""
    return "stiffness by gravity" + (" and springs" if chain.stiffness is not None else "")


def small_damping(chain: Chain) -> str:
    """The damping of (19)."""
    is_dry = chain.friction is not None or chain.cart_friction is not None
    return "damping" + (", dry friction F tanh(v / v_0) as F / v_0" if is_dry else "")


def amplitudes(chain: Chain) -> str:
    """The amplitudes of the single-harmonic balance."""
    cart = "amplitude of the cart, m; then " if chain.has_cart else ""
    return f"{cart}the amplitude of each theta_k, rad"


def residuals(chain: Chain) -> str:
    """What the single-harmonic balance leaves."""
    return f"what is left of the balance conjugate to each amplitude, {forces(chain)}"
