"""Chains that lose energy: dampers and dry friction at joints and carts, springs that rest elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phichain.contract.functions import TABLE
from phichain.scene import Scene

_LINKS: dict[str, Any] = {"mass": [0.7, 1.9, 0.4, 1.1, 0.6, 0.8], "length": [0.5, 1.3, 0.8, 0.6, 1.0, 0.7]}
_COM = [0.3, 0.9, 0.1, 0.55, 0.5, 0.2]
_JOINTS: dict[str, Any] = {
    "stiffness": [2.0, 0.5, 1.5, 0.8, 1.2, 0.6],
    "damping": [0.3, 0.1, 0.2, 0.4, 0.0, 0.1],
    "rest_angle": [0.4, -0.7, 0.0, 1.1, 0.2, -0.3],
    "friction": [0.6, 0.2, 0.4, 0.0, 0.3, 0.1],
}
#: So fast that random rates of order one leave tanh on its slope.
SPEEDS = {"friction_speed": 0.8, "cart_friction_speed": 1.3}


def braked(links: int, space: str, laws: str, base: str = "cart", **more: Any) -> Scene:
    """A chain of the first links of six uneven ones.

    Args:
        links: how many, at most six.
        space: "planar" or "spatial".
        laws: letters: c cart damper, C its dry friction, k springs, d dampers, f dry friction, r springs rest elsewhere,
            m masses before the links' ends, p all numbers at run time.
        base: "cart" or "fixed".
        more: keys of the scene.
    """
    keys: dict[str, Any] = {name: values[:links] for name, values in _LINKS.items()}
    names = {"k": "stiffness", "d": "damping", "r": "rest_angle", "f": "friction"}
    keys |= {name: _JOINTS[name][:links] for letter, name in names.items() if letter in laws}
    if base == "cart":
        keys["cart_mass"] = 1.7
    keys |= {"com": _COM[:links]} if "m" in laws else {}
    keys |= {"cart_damping": 0.45} if "c" in laws else {}
    keys |= {"cart_friction": 0.9} if "C" in laws else {}
    if "p" in laws:
        keys = {name: "runtime" for name in keys} | {"gravity": "runtime"}
    keys |= {name: SPEEDS[name] for name, letter in (("friction_speed", "f"), ("cart_friction_speed", "C")) if letter in laws}
    return Scene("braked", links, space=space, base=base, **(keys | more))


def kinds() -> Iterator[Scene]:
    """Scenes that between them take every branch of the lowering."""
    for angles in ("relative", "absolute", "adjacent"):
        yield braked(3, "planar", "cCkdfr", angles=angles, actuated="all")
        yield braked(3, "planar", "cCkdfrm", angles=angles, actuated="none")
        yield braked(3, "planar", "f", "fixed", angles=angles)
    for laws in ("c", "C", "cm", "cf", "kr", "krm", "cCkdfrp", "cCkdfrmp", "mf"):
        yield braked(2, "planar", laws)
    for laws in ("c", "C", "cCkdfr", "krf"):
        yield braked(1, "planar", laws)
    yield braked(1, "planar", "krf", "fixed")
    yield braked(1, "planar", "krdp", "fixed")
    yield braked(6, "planar", "cCfm")
    yield braked(6, "planar", "cm", actuated="none")
    for laws in ("c", "cm", "cd", "cdkm", "cp", "ckdmp"):
        yield braked(2, "spatial", laws)
    for laws in ("f", "fC", "cCkdfmp"):
        yield braked(2, "spatial", laws)
    yield braked(3, "spatial", "C", com=[0.1, 0.2, 0.1], actuated="none")
    yield braked(2, "spatial", "f", "fixed", com="runtime", inertia="runtime")
    yield braked(2, "spatial", "cCf", com=[0.2, 0.0], inertia=[0.1, 0.3])
    yield braked(1, "spatial", "c")
    yield braked(3, "spatial", "cm", com=[0.1, 0.2, 0.1], actuated="none")
    yield braked(3, "spatial", "c", mass=0.4, length=0.5, com=0.25)


def label(chain: Scene) -> str:
    """A readable test id."""
    laws = {"cart_damping": "c", "cart_friction": "C", "stiffness": "k", "damping": "d", "friction": "f", "rest_angle": "r",
            "com": "m"}  # fmt: skip
    held = "".join(letter for name, letter in laws.items() if getattr(chain, name) is not None)
    return f"{chain.angles or 'spatial'}-{chain.links}-{chain.base}-{held}{'p' if chain.runtime else ''}-{chain.nu}u"


def offered(chain: Scene, flows: bool = False) -> tuple[str, ...]:
    """Every function of a scene, those on request included; the flows only where asked for."""
    return tuple(row.name for row in TABLE if row.absence(chain) is None and (flows or not row.flow))
