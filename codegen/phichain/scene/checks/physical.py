"""The physical parameters of a scene, each with those that it depends on: links as bodies, the cart, and what acts at joints.

As in `validate`, functions are pure and return values in the one form that a scene keeps.
"""

from __future__ import annotations

from typing import Final

from phichain.contract.bases import drives, law_of, placed
from phichain.errors import SceneError
from phichain.scene.checks.validate import (
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    RUNTIME,
    Runtime,
    Sign,
    choice,
    no_cart,
    per_link,
    range_remedy,
    representable,
    scalar,
)
from phichain.scene.keys import label

Values = tuple[float, ...] | Runtime
_BEYOND_ITS_JOINT: Final = Sign(POSITIVE.holds, POSITIVE.broken, "use a number above zero; a link with inertia may have zero")


def inertia_of(value: object, links: int, real: str) -> Values | None:
    """Return the moments of inertia about the links' centres of mass; all zero means point masses."""
    return _law("inertia", value, links, real)


def com_of(value: object, length: Values, inertia: Values | None, links: int, real: str) -> Values | None:
    """Return the distances of the masses from their joints, or None where every mass sits at its link's end.

    A link with a moment of inertia may have its centre of mass anywhere along it and beyond, and at its joint.

    Raises:
        SceneError: A point mass lies on its joint or beyond the end of its link (r_k = 0 or r_k > l_k).
    """
    if value is None:
        return None
    com = per_link("com", value, links, _BEYOND_ITS_JOINT if inertia is None else NOT_NEGATIVE, real)
    if isinstance(com, str) or isinstance(inertia, str):
        return com
    for k, r in enumerate(com):
        if inertia is not None and inertia[k]:
            continue
        if not r:
            problem = f"puts the mass of link {k + 1} on its joint, and the link has no inertia"
            raise SceneError(label("com"), r, problem, "use 0 < com <= length, or give the link an inertia", link=k + 1)
        if not isinstance(length, str) and r > length[k]:
            problem = f"puts the mass of link {k + 1} beyond the link's length {length[k]!r}"
            remedy = "use 0 < com <= length, or give the link an inertia"
            raise SceneError(label("com"), r, problem, remedy, link=k + 1)
    return None if com == length else com


def check_inertia(mass: Values, length: Values, com: Values | None, inertia: Values | None, real: str) -> None:
    """Check that the type holds every link's inertia c_kk = m_k r_k^2 + J_k + l_k^2 sum_{a>k} m_a.

    It is the diagonal of the inertia matrix in absolute angles (docs/theory.md, section 1).

    Raises:
        SceneError: An inertia over- or underflows.
    """
    if isinstance(mass, str) or isinstance(length, str) or isinstance(com, str) or isinstance(inertia, str):
        return
    outer = 0.0
    for k in range(len(mass), 0, -1):
        m, l, r = mass[k - 1], length[k - 1], (com or length)[k - 1]
        moment = m * r * r + (inertia[k - 1] if inertia else 0.0) + outer * l * l
        if not (moment and representable(moment, real)):
            problem = f"gives link {k} the inertia {moment:.3g}, outside the range of {real}"
            raise SceneError(label("mass"), m, problem, range_remedy(real), link=k)
        outer += m


def drive_of(value: object, base: str, actuated: object) -> str | None:
    """Return what drives a cart, the first word of its base unless said; None without a cart.

    Raises:
        SceneError: There is no cart to drive, or its acceleration would be nobody's input.
    """
    key = "drive"
    words = drives(base)
    if not words:
        if value is not None:
            raise SceneError(label(key), value, no_cart(base), 'remove it, or set base = "cart"')
        return None
    drive = words[0] if value is None else choice(key, value, words)
    if law_of(base, drive).is_told and actuated == "none":
        problem = "makes the cart's acceleration an input, and nothing is actuated"
        raise SceneError(label(key), value, problem, 'use actuated = "cart", or drive = "force"')
    return drive


def cart_mass_of(value: object, base: str, drive: str | None, real: str) -> float | Runtime | None:
    """Return the cart's mass m_0, which a scene has exactly when it has a cart that a force drives.

    A cart driven by its acceleration may go without: then the links alone are what the drive moves.
    """
    key = "cart_mass"
    law = law_of(base, drive)
    if law.is_placed:
        if value is None and law.is_told:
            return None
        if value is None:
            raise SceneError(label(key), None, "is missing on a cart", 'give it, or set base = "fixed"')
        return scalar(key, value, POSITIVE, real)
    if value is not None:
        raise SceneError(label(key), value, no_cart(base), 'remove it, or set base = "cart"')
    return None


def cart_law(key: str, value: object, base: str, real: str) -> float | Runtime | None:
    """Return the cart's damper or dry friction; zero means that there is none."""
    if value is None:
        return None
    if base not in placed():
        raise SceneError(label(key), value, no_cart(base), 'remove it, or set base = "cart"')
    return scalar(key, value, NOT_NEGATIVE, real) or None


def joint_law(key: str, value: object, links: int, base: str, real: str) -> Values | None:
    """Return the joints' dampers, springs or dry friction; all zero means that there are none.

    Raises:
        SceneError: Also where a list has an entry for the cart, which has keys of its own.
    """
    if base in placed() and key in _OF_CART and isinstance(value, list | tuple) and len(value) == links + 1:
        problem = f"has {links + 1} entries, one too many for the joints of {links} links"
        raise SceneError(label(key), value, problem, f"give one per joint; the cart's is {label(_OF_CART[key])}")
    return _law(key, value, links, real)


def armature_of(value: object, space: str, links: int, real: str) -> Values | None:
    """Return the rotor inertias at the joints; all zero means that there are none.

    Raises:
        SceneError: The chain is spatial, where joints have no motors.
    """
    if value is not None and space == "spatial":
        problem = "is the inertia of a motor at a joint, and spatial joints are not actuated"
        raise SceneError(label("armature"), value, problem, 'remove it, or set space = "planar"')
    return _law("armature", value, links, real)


def rest_angle_of(value: object, stiffness: Values | None, space: str, links: int, real: str) -> Values | None:
    """Return the joints' angles at which their springs rest; all zero means along the link before.

    Raises:
        SceneError: There are no springs, or the chain is spatial, where an angle alone is no direction.
    """
    key = "rest_angle"
    if value is None:
        return None
    if space == "spatial":
        problem = "is an angle of a planar joint, and the springs of spatial ones rest along the link before"
        raise SceneError(label(key), value, problem, 'remove it, or set space = "planar"')
    if stiffness is None:
        raise SceneError(label(key), value, "needs springs, and the joints have none", f"give {label('stiffness')}, or remove it")
    rest = per_link(key, value, links, ANY, real)
    return rest if any(rest) else None


def friction_speeds(
    friction: Values | None, cart_friction: float | Runtime | None, speed: object, cart_speed: object, real: str,
    said: tuple[object, object],
) -> tuple[float | None, float | None]:  # fmt: skip
    """Return v_0 of the joints' (rad/s) and of the cart's dry friction (m/s), each None without friction there.

    The law is F tanh(v / v_0). A cart without a speed of its own takes the number of the joints.

    Args:
        friction: That of the joints, None for none.
        cart_friction: That of the cart, likewise.
        speed: v_0 of the joints, as it was written.
        cart_speed: v_0 of the cart, as it was written.
        real: The type of the numbers.
        said: Both frictions as they were written: one of zero has a speed that nothing uses.

    Raises:
        SceneError: Friction comes without its speed, or a speed without friction.
    """
    for key, value, laws in (("friction_speed", speed, said), ("cart_friction_speed", cart_speed, said[1:])):
        if value is not None and all(law is None for law in laws):
            other = "cart_friction" if len(laws) == 1 else "friction"
            raise SceneError(label(key), value, "is the speed of a friction that nothing has", f"give {label(other)}, or remove it")
    own, cart = (_speed(key, value, real) for key, value in (("friction_speed", speed), ("cart_friction_speed", cart_speed)))
    is_read = friction is not None or (cart_friction is not None and cart is None)
    if own is None and is_read:
        key = "friction" if friction is not None else "cart_friction"
        given = friction if friction is not None else cart_friction
        problem = "needs the speed v_0 below which it fades, in F tanh(v / v_0)"
        raise SceneError(label(key), given, problem, f"give {label('friction_speed')}, rad/s at joints and m/s on a cart")
    return own if friction is not None else None, (cart or own) if cart_friction is not None else None


def _speed(key: str, value: object, real: str) -> float | None:
    if value is None:
        return None
    if value == RUNTIME:
        raise SceneError(label(key), value, "is no number", "give a number: it regularises a law and is known beforehand")
    return float(scalar(key, value, POSITIVE, real))


def _law(key: str, value: object, links: int, real: str) -> Values | None:
    values = None if value is None else per_link(key, value, links, NOT_NEGATIVE, real)
    return None if values is None or not any(values) else values


_OF_CART: Final = {"damping": "cart_damping", "friction": "cart_friction"}
"""What acts on the cart where the joints have the key."""
