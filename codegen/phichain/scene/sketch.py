"""A scene as a sketch in plain characters: the chain from its base to its tip, with the numbers beside it."""

from __future__ import annotations

from phichain.contract.chain import Chain

_MOST_DRAWN = 8
_DRAWN_AT_ENDS = 3


def sketch(scene: Chain) -> str:
    """Return the drawing of a chain: `o` is a joint, `@` a mass; of long chains the ends alone."""
    return "\n".join([_title(scene), "", *_base(scene), *_chain(scene), "", *_legend(scene)])


def _title(scene: Chain) -> str:
    """Return one line that says what the scene is."""
    links = f"{scene.links} link{'s' if scene.links > 1 else ''}"
    state = f"{scene.angles} angles" if scene.is_planar else "unit vectors"
    return f"{scene.name}: {scene.space} chain, {links} {scene.base_law.on}, {state}"


def _base(scene: Chain) -> list[str]:
    """Return the drawing of the base, whose joint is the first."""
    law = scene.base_law
    if not scene.has_cart:
        return list(law.drawing)
    top, body, wheels = law.drawing
    drive = f" <-> {law.input}" if scene.has_force else ""
    acting = [] if scene.cart_mass is None else [f"mass {_number(scene.cart_mass)}"]
    if scene.cart_damping is not None:
        acting.append(f"damping {_number(scene.cart_damping)}")
    if scene.cart_friction is not None:
        acting.append(f"friction {_number(scene.cart_friction)} (v_0 {_number(scene.cart_friction_speed)})")
    return [top, f"{body}{drive}  {', '.join(acting)}".rstrip(), wheels]


def _chain(scene: Chain) -> list[str]:
    """Return the drawing of the links, those in the middle of a long chain left out."""
    links = list(range(1, scene.links + 1))
    if scene.links <= _MOST_DRAWN:
        return _links(scene, links)
    head, tail = links[:_DRAWN_AT_ENDS], links[-_DRAWN_AT_ENDS:]
    gap = f"     :   links {head[-1] + 1} to {tail[0] - 1}"
    return [*_links(scene, head), gap, *_links(scene, tail)]


def _links(scene: Chain, links: list[int]) -> list[str]:
    """Return the drawing of some links, one below the other."""
    return [line for k in links for line in _link(scene, k)]


def _link(scene: Chain, k: int) -> list[str]:
    """Return the drawing of one link below its joint."""
    mass, length = _entry(scene.mass, k), _entry(scene.length, k)
    if scene.inertia is not None:
        mass += f", inertia {_entry(scene.inertia, k)}"
    joint = f"     o   {_joint(scene, k)}"
    if scene.com is None:
        return [joint, f"     |   length {length}", f"     @   mass {mass}"]
    return [joint, f"     @   mass {mass} at {_entry(scene.com, k)}", f"     |   length {length}"]


def _joint(scene: Chain, k: int) -> str:
    """Return a joint's name and what acts there."""
    acting = [f"torque_{k}"] if k in scene.actuated_joints else []
    if scene.stiffness is not None:
        rest = "" if scene.rest_angle is None else f" (rest {_entry(scene.rest_angle, k)})"
        acting.append(f"stiffness {_entry(scene.stiffness, k)}{rest}")
    if scene.damping is not None:
        acting.append(f"damping {_entry(scene.damping, k)}")
    if scene.friction is not None:
        acting.append(f"friction {_entry(scene.friction, k)} (v_0 {_number(scene.friction_speed)})")
    if scene.armature is not None:
        acting.append(f"armature {_entry(scene.armature, k)}")
    return f"joint {k}" + (": " if acting else "") + ", ".join(acting)


def _legend(scene: Chain) -> list[str]:
    """Return the lines below the drawing."""
    return [
        f"gravity  {_number(scene.gravity)}",
        f"q        {_span(scene.q_names)}",
        f"v        {_span(scene.v_names)}",
        f"u        {_span(scene.u_names)}",
        f"runtime  {', '.join(scene.runtime) or 'none'}",
        f"want     {', '.join(scene.want)}",
        f"target   {scene.real}, {scene.code}",
    ]


def _span(names: tuple[str, ...]) -> str:
    """Return a vector's length and its entries, the middle of a long one left out."""
    if not names:
        return "none"
    listed = names if len(names) <= 2 * _DRAWN_AT_ENDS else (*names[:2], "...", names[-1])
    return f"({len(names)})  {', '.join(listed)}"


def _entry(values: tuple[float, ...] | str, k: int) -> str:
    """Return link k's number, or the word runtime."""
    return _number(values if isinstance(values, str) else values[k - 1])


def _number(value: float | str | None) -> str:
    """Return a number with six digits, or the word runtime."""
    return value if isinstance(value, str) else f"{value:.6g}"
