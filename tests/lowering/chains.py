"""One scene of every kind that lowers differently, and random arguments for its Programs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.contract.functions import ROWS
from phichain.ir import Program
from phichain.scene import Scene
from tests.offered import offered

Arguments = dict[str, NDArray[np.float64]]

_LINKS: dict[str, Any] = {"mass": [0.7, 1.9, 0.4, 1.1], "length": [0.5, 1.3, 0.8, 0.6]}
_MASSES: dict[str, dict[str, Any]] = {
    "tip": {},
    "mid": {"com": [0.3, 0.9, 0.1, 0.55]},
    "one_at_its_end": {"com": [0.3, 1.3, 0.8, 0.2]},
    "unlike": {"mass": [2.0, 3e-4, 1.5, 0.8]},
    "runtime": {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"},
    "runtime_tip": {"mass": "runtime", "length": "runtime"},
    "rigid": {"com": [0.3, 0.9, 1.4, 0.55], "inertia": [0.05, 0.3, 0.02, 0.1]},
    "held": {"com": [0.3, 0.0, 0.0, 0.55], "inertia": [0.0, 0.3, 0.05, 0.1]},
    "runtime_rigid": {"mass": "runtime", "length": "runtime", "com": "runtime", "inertia": "runtime"},
    "runtime_inertia": {"inertia": "runtime"},
}
_JOINTS: dict[str, dict[str, Any]] = {
    "free": {},
    "sprung": {"stiffness": [2.0, 0.5, 1.5, 0.8]},
    "damped": {"stiffness": [2.0, 0.5, 1.5, 0.8], "damping": [0.3, 0.1, 0.2, 0.4]},
    "geared": {"armature": [0.3, 0.0, 0.5, 0.1]},
    "geared_damped": {"armature": [0.3, 0.0, 0.5, 0.1], "stiffness": [2.0, 0.5, 1.5, 0.8], "damping": [0.3, 0.1, 0.2, 0.4]},
    "geared_runtime": {"armature": "runtime"},
}


def scene(links: int, space: str, base: str, masses: str, joints: str = "free", **more: Any) -> Scene:
    """A chain of the first `links` of four uneven links."""
    keys = _LINKS | _MASSES[masses] | _JOINTS[joints]
    keys = {name: value[:links] if isinstance(value, list) else value for name, value in keys.items()}
    if base == "cart":
        keys["cart_mass"] = 1.7
    return Scene("chain", links, space=space, base=base, **(keys | more))


def kinds(links: int = 3) -> Iterator[Scene]:
    """Scenes that between them take every branch of the lowering."""
    for base, masses, joints in product(("fixed", "cart"), ("tip", "mid", "runtime"), ("free", "damped")):
        yield scene(links, "planar", base, masses, joints, actuated="all")
        yield scene(links, "spatial", base, masses, joints)
    for base, masses, angles in product(("fixed", "cart"), ("tip", "mid"), ("absolute", "adjacent")):
        joints = "free" if base == "fixed" else "damped"
        yield scene(links, "planar", base, masses, joints, angles=angles, actuated="all")
    for base in ("fixed", "cart"):
        yield scene(links, "planar", base, "one_at_its_end", "sprung", actuated="none")
        yield scene(links, "planar", base, "unlike", "sprung", actuated="all")
        yield scene(links, "planar", base, "runtime_tip", actuated=[1])
        yield scene(links, "planar", base, "tip", actuated="none")
        yield scene(links, "spatial", base, "one_at_its_end", "sprung")
        yield scene(links, "spatial", base, "runtime_tip", actuated="none")
    for base, masses in product(("fixed", "cart"), ("rigid", "held")):
        yield scene(links, "planar", base, masses, "damped", actuated="all")
        yield scene(links, "spatial", base, masses, "free" if base == "fixed" else "damped")
    for space in ("planar", "spatial"):
        yield scene(links, space, "cart", "runtime_rigid", "damped")
        yield scene(links, space, "fixed", "runtime_inertia")
    yield from geared_kinds(links)


def geared_kinds(links: int = 3) -> Iterator[Scene]:
    """Scenes with rotors at their joints that between them take every branch of those."""
    for base, angles in product(("fixed", "cart"), ("relative", "absolute", "adjacent")):
        masses, joints = ("mid", "geared_damped") if base == "fixed" else ("tip", "geared")
        yield scene(links, "planar", base, masses, joints, angles=angles, actuated="all")
    yield scene(links, "planar", "fixed", "runtime", "geared_runtime", actuated="none")
    yield scene(links, "planar", "cart", "one_at_its_end", "geared_runtime", actuated=[1])


def label(chain: Scene) -> str:
    """A readable test id."""
    com = "tip" if chain.com is None else "com"
    com += "" if chain.inertia is None else "-rigid" if chain.com is None or all(chain.com) else "-held"
    numbers = "-".join(chain.runtime) if chain.runtime else "numbers"
    joints = "".join(name[0] for name in ("damping", "stiffness", "armature") if getattr(chain, name) is not None)
    form = chain.angles or "spatial"
    return f"{form}-{chain.links}-{chain.base}-{com}-{numbers}-{joints or 'free'}-{chain.nu}u"


def functions(chain: Scene) -> tuple[str, ...]:
    """Every function of a scene that is a Program."""
    known = offered(chain.space, chain.damping is not None, on_request=True)
    return tuple(name for name in known if ROWS[name].absence(chain) is None)


def random_arguments(chain: Scene, program: Program, seed: int = 0) -> Arguments:
    """Random parameters and inputs by name; directions are unit and rates tangent to rounding."""
    rng = np.random.default_rng(seed)
    state = {"q": rng.normal(size=chain.nq), "v": rng.normal(size=chain.nv), "q_dot": rng.normal(size=chain.nq)}
    if not chain.is_planar:
        start = 2 * chain.has_cart
        q, omega, q_dot = (state[name][start:].reshape(-1, 3) for name in ("q", "v", "q_dot"))
        q /= np.linalg.norm(q, axis=1)[:, None]
        for rate in (omega, q_dot):
            rate -= q * np.sum(q * rate, axis=1)[:, None]
    drawn = {array.name: rng.normal(size=array.shape) for array in program.inputs}
    drawn |= {array.name: rng.uniform(0.6, 1.0, array.shape) for array in program.params}
    if "com" in drawn:
        drawn["com"] *= 0.6
    if "s" in drawn:
        drawn["s"] = np.where(drawn["s"] > 0, 1.0, -1.0)
    if "h" in drawn:
        drawn["h"] = np.array(1e-3)
    return drawn | {name: state[name] for name in state if name in drawn}


def gap(found: Any, expected: Any) -> float:
    """max |found - expected| / max |expected|."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    if found.size == 0:
        return 0.0
    return float(np.max(np.abs(found - expected)) / max(np.max(np.abs(expected)), 1e-300))
