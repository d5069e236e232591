"""Reference of the force in every link: d'Alembert's principle for the part of the chain beyond a cut."""

from __future__ import annotations

from mpmath import fdot, mpf

from phichain.reference import masses
from phichain.reference.algebra import Vector, dot
from phichain.reference.case import Case, Outputs, along_told, judges
from phichain.reference.motion import forward_dynamics
from phichain.reference.pose import Pose, cart_axes


@judges("tensions")
def tensions(case: Case) -> Outputs:
    """-q_k . sum_{a>=k} m_a (r_a'' - g e_d) (N), r_a'' put together from the motion that the forces make."""
    scene, values, pose = case.scene, case.values, case.pose()
    parts = (
        masses.driven(scene, values, pose, _rates(case, pose)),
        masses.centripetal(values, pose),
        masses.anti_gravity(values, pose),
    )
    force = masses.weighted(values, [sum(entries) for entries in zip(*parts, strict=True)])
    size, found = len(pose.direction[0]), list[object]()
    base: Vector = along_told(scene, case.inputs["u"][: scene.base_inputs]) if scene.is_moving else [mpf(0)] * size
    beyond: Vector = [mpf(0)] * size
    for k in reversed(range(scene.links)):
        own = zip(beyond, force[size * k : size * (k + 1)], base, strict=True)
        beyond = [outer + pull + values.mass[k] * b for outer, pull, b in own]
        found.append(-dot(pose.direction[k], beyond))
    return {"tension": found[::-1]}


def _rates(case: Case, pose: Pose) -> Vector:
    """The accelerations as the pose has them: in space two a link, about the axes of its tangent plane."""
    a, carts = forward_dynamics(case)["a"], cart_axes(case.scene)
    if case.scene.is_planar:
        return list(a)
    turns = [a[i : i + 3] for i in range(carts, len(a), 3)]
    return [*a[:carts], *(fdot(axis, turn) for axes, turn in zip(pose.axes, turns, strict=True) for axis in axes)]
