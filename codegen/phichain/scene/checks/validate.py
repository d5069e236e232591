"""The values of a scene: numbers, lists of one number per link, choices, and the joints with a torque.

Every function is pure: it takes a value as a person wrote it and returns it in the one form a scene keeps,
or raises a `SceneError` that names the key, the value and the remedy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, Final, Literal

from phichain.contract.bases import placed
from phichain.contract.words import nearest
from phichain.errors import SceneError
from phichain.scene.keys import PARAMETERS, label

Runtime = Literal["runtime"]
RUNTIME: Final[Runtime] = "runtime"

# At 4096 links the looped C stays within 1 MiB of stack (some thirty arrays with a double per link); far longer
# chains would need another method anyway, and a slip such as 10^9 must not exhaust the memory.
MOST_LINKS: Final = 4096

_SMALLEST_NORMAL: Final = {"double": 1 / 2**1022, "float": 1 / 2**126}
_LARGEST: Final = {"double": float(2**1024 - 2**971), "float": float(2**128 - 2**104)}


@dataclass(frozen=True)
class Sign:
    """Which numbers a parameter admits, and how a message says so."""

    holds: Callable[[float], bool]
    broken: str
    remedy: str


POSITIVE: Final = Sign(lambda x: x > 0.0, "is not positive", "use a number above zero")
NOT_NEGATIVE: Final = Sign(lambda x: x >= 0.0, "is negative", "use zero or a number above it")
ANY: Final = Sign(lambda x: True, "", "")


def link_count(value: object) -> int:
    """Return the number of links, a whole number from 1 to `MOST_LINKS`."""
    return whole_number("links", value, 1, MOST_LINKS)


def whole_number(key: str, value: object, least: int, most: int) -> int:
    """Return a whole number within bounds."""
    plain = _plain(value)
    remedy = f"use a whole number from {least} to {most}"
    if isinstance(plain, bool) or not isinstance(plain, int):
        raise SceneError(label(key), value, "is not a whole number", remedy)
    if plain < least:
        raise SceneError(label(key), value, f"is below {least}", remedy)
    if plain > most:
        raise SceneError(label(key), value, f"is above {most}", remedy)
    return plain


def choice(key: str, value: object, allowed: Sequence[str]) -> str:
    """Return a word after checking that it is one of those allowed."""
    if isinstance(value, str) and value in allowed:
        return str(value)
    remedy = "use " + " or ".join(f'"{word}"' for word in allowed)
    if isinstance(value, str) and (best := nearest(value, allowed)):
        remedy += f' (did you mean "{best}"?)'
    raise SceneError(label(key), value, "is not one of the choices", remedy)


def scalar(key: str, value: object, sign: Sign, real: str) -> float | Runtime:
    """Return a parameter of the whole chain: a number or "runtime"."""
    if isinstance(value, str) and value == RUNTIME:
        return RUNTIME
    return _number(key, value, "", sign, real)


def per_link(key: str, value: object, links: int, sign: Sign, real: str) -> tuple[float, ...] | Runtime:
    """Return a parameter of the links: one number each, or "runtime"; a single number is meant for all."""
    if isinstance(value, str) and value == RUNTIME:
        return RUNTIME
    plain = _plain(value)
    if not isinstance(plain, list):
        return (_number(key, plain, "", sign, real),) * links
    if len(plain) != links:
        problem = f"is a list of length {len(plain)}, and links = {links}"
        raise SceneError(label(key), value, problem, "give one number for all links, or one per link")
    return tuple(_number(key, entry, f"entry {k} ", sign, real) for k, entry in enumerate(plain, start=1))


def _number(key: str, value: object, whose: str, sign: Sign, real: str) -> float:
    """Return a finite number of the wanted sign that the target's `real` can hold.

    `whose` is empty or tells in a message which entry of a list is meant, e.g. "entry 2 ".
    """
    plain = _plain(value)
    if isinstance(plain, bool) or not isinstance(plain, Real):
        remedy = f'use numbers, or {key} = "{RUNTIME}"' if whose else f'use a number or "{RUNTIME}"'
        raise SceneError(label(key), value, f"{whose}is not a number", remedy)
    try:
        result = float(plain) + 0.0  # turns -0.0 into 0.0: equal scenes have one digest
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise SceneError(label(key), value, f"{whose}is not finite", "use a finite number")
    if not sign.holds(result):
        raise SceneError(label(key), value, f"{whose}{sign.broken}", sign.remedy)
    if not representable(result, real):
        raise SceneError(label(key), value, f"{whose}is outside the range of {real}", range_remedy(real))
    return result


def representable(value: float, real: str) -> bool:
    """Return whether a number is zero or within the normal numbers of the type `real`."""
    return value == 0.0 or _SMALLEST_NORMAL[real] <= abs(value) <= _LARGEST[real]


def range_remedy(real: str) -> str:
    """Return the remedy for a number that the type cannot hold."""
    alternative = ', or real = "double"' if real == "float" else ""
    return f"choose units that keep it from {_SMALLEST_NORMAL[real]:.2g} to {_LARGEST[real]:.2g}{alternative}"


def angle_kind(value: object, space: str) -> str | None:
    """Return the kind of joint angles of a planar scene; a spatial scene has none."""
    kinds = ("relative", "absolute", "adjacent")
    if space == "planar":
        return kinds[0] if value is None else choice("angles", value, kinds)
    if value is not None:
        problem = "is a choice of planar scenes, the links of a spatial one being unit vectors"
        raise SceneError(label("angles"), value, problem, 'remove it, or set space = "planar"')
    return None


def actuation(value: object, space: str, base: str, links: int, angles: str | None) -> str | tuple[int, ...]:
    """Return "none", "all", "cart", or the joints with a torque, counted from 1 in rising order.

    The list of every joint is "all". On a cart the force comes before the torques, whatever the list.

    Raises:
        SceneError: The scene has no such actuators.
    """
    key, on_cart = "actuated", base in placed()
    default = "cart" if on_cart else "none"
    plain = default if value is None else _plain(value)
    if isinstance(plain, list):
        return _joints(value, plain, space, links, angles, default)
    if isinstance(plain, bool) or not isinstance(plain, str):
        raise SceneError(label(key), value, "is no kind of actuation", _ACTUATED_REMEDY)
    word = choice(key, plain, ("none", "all", "cart"))
    if word == "cart" and not on_cart:
        raise SceneError(label(key), value, no_cart(base), 'use "none" or "all", or set base = "cart"')
    if word == "all" and space == "spatial":
        raise SceneError(label(key), value, _SPATIAL_JOINTS, f'use "{default}"')
    return word


_ACTUATED_REMEDY: Final = 'use "none", "all", "cart" or a list of joints such as [1, 2]'
_SPATIAL_JOINTS: Final = "asks for joint torques, and spatial joints are not actuated"


def no_cart(base: str) -> str:
    """Say that there is no cart."""
    return f"needs a cart, and the base is {base}"


def variational_equations(
    value: object, want: Sequence[str], runtime: Sequence[str], is_forced: bool
) -> bool | tuple[str, ...]:
    """Return whether the flow carries the variational equations along; only a scene with a flow can ask for them.

    True for derivatives by the state; where parameters are asked for too, what derivatives are by: "state", parameters, "forcing".
    """
    plain, key = _plain(value), label("variational")
    if isinstance(plain, list) and all(isinstance(name, str) for name in plain):
        plain = _varied(plain, runtime, is_forced)
    elif not isinstance(plain, bool):
        remedy = 'write variational = true, a list such as ["state", "mass"], or remove it'
        raise SceneError(key, value, "is neither true nor false, nor a list of names", remedy)
    if plain and "propagate" not in want:
        raise SceneError(
            key, value, "asks for derivatives of a flow that is not wanted", 'add "propagate" to want'
        )
    return plain


def _varied(names: Sequence[str], runtime: Sequence[str], is_forced: bool) -> bool | tuple[str, ...]:
    """Return what derivatives are by, in the order of the emitted columns; True where that is the state alone."""
    key, known = label("variational"), ("state", *runtime, *(("forcing",) if is_forced else ()))
    for name in names:
        if name in known:
            continue
        remedy = f"use {', '.join(known)}"
        if name in ("amplitude", "omega"):
            instead = '"forcing", both of them' if is_forced else "[forcing] first"
            raise SceneError(key, name, "is half of what forces a chain", f"use {instead}")
        if name == "forcing":
            raise SceneError(key, name, "asks for derivatives by a forcing, and nothing is forced", "add [forcing], or leave it out")
        if name in PARAMETERS:
            problem = "asks for derivatives by a parameter that is no argument"
            raise SceneError(key, name, problem, f'set {label(name)} = "{RUNTIME}", or leave it out')
        best = nearest(name, known)
        raise SceneError(key, name, "is nothing that derivatives are by", remedy + (f' (did you mean "{best}"?)' if best else ""))
    # What forces a chain comes along with its parameters: their columns know of it anyway.
    named = {"state", *names, *(("forcing",) if set(names) - {"state"} else ())}
    varied = tuple(name for name in known if name in named)
    return bool(names) if len(varied) == 1 else varied


def _joints(
    value: object, joints: Sequence[Any], space: str, links: int, angles: str | None, default: str
) -> str | tuple[int, ...]:
    """Return a list of joints with a torque after checking each, or "all" when it names every joint."""
    key = label("actuated")
    if space == "spatial":
        raise SceneError(key, value, _SPATIAL_JOINTS, f'use "{default}"')
    if angles != "relative":
        problem = f"lists joints, whose torques belong to relative angles, and the angles are {angles}"
        raise SceneError(key, value, problem, 'use "all", or set angles = "relative"')
    if not joints:
        raise SceneError(key, value, "lists no joint", f'use "{default}"')
    for joint in joints:
        if isinstance(joint, bool) or not isinstance(joint, int):
            raise SceneError(key, joint, "lists what is no joint's number", _ACTUATED_REMEDY)
        if not 1 <= joint <= links:
            raise SceneError(key, joint, "is no joint of the chain", f"use joints from 1 to {links}")
    rising = sorted(set(joints))
    if list(joints) != rising:
        raise SceneError(key, value, "is not in rising order, each once", f"use {rising}, the order of u")
    return "all" if len(rising) == links else tuple(rising)


def _plain(value: Any) -> Any:
    """Return NumPy's scalars as Python's and every kind of list as a list, without importing NumPy."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple | range) else value
