"""Chains whose base is given its acceleration: every form of the lowering, on a driven cart and on a moving base."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from phichain.contract.functions import TABLE
from phichain.scene import Scene
from tests.lowering.chains import label, scene

GIVEN: Final[dict[str, dict[str, Any]]] = {"moving": {}, "cart": {"drive": "acceleration", "cart_mass": None}}
"""The keys of the two bases; a cart weighs nothing unless a scene says more."""


def chain(base: str, links: int, space: str, masses: str, joints: str = "free", **more: Any) -> Scene:
    """A chain of `tests.lowering.chains` on such a base."""
    return scene(links, space, base, masses, joints, **(GIVEN[base] | more))


def given(links: int = 3) -> Iterator[Scene]:
    """Scenes that between them take every branch."""
    for base in GIVEN:
        for masses, joints in (("tip", "free"), ("mid", "free"), ("mid", "damped"), ("runtime", "free"), ("unlike", "damped")):
            yield chain(base, links, "spatial", masses, joints)
            yield chain(base, links, "planar", masses, joints, actuated="all")
        for angles in ("absolute", "adjacent"):
            yield chain(base, links, "planar", "tip", "damped", angles=angles, actuated="all")
        yield chain(base, links, "planar", "one_at_its_end", "sprung")
        yield chain(base, 1, "planar", "mid")
        yield chain(base, 1, "spatial", "tip")
    yield chain("cart", links, "planar", "tip", cart_mass="runtime", actuated=[2])
    yield chain("cart", links, "spatial", "mid", cart_mass=0.4)


def named(of: Scene) -> str:
    """A readable test id."""
    return f"{'driven' if of.is_driven else 'moving'}-{label(of)}"


def functions(of: Scene) -> tuple[str, ...]:
    """The functions of such a scene that are one Program."""
    return tuple(row.name for row in TABLE if not row.flow and row.absence(of) is None)
