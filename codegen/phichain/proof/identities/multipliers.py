"""The linear solves of variational steps: accelerations of the unit vectors with prescribed components, by multipliers along them.

Along turns across the links the forces of inertia, gravity, couples and rotors vanish together,

    sum_k d_k . (c_kk a_k + sum_j c_kj a_j + mu_k (C x'' - g e_d + b) - force_k) + sum_k (m_k - m_{k+1}) turn_k = 0,
    M00 x'' + sum_k mu_k C^T a_k = push,    n_k . a_k = along_k,

whatever the multipliers are; m_k = A_k (beta_k + lead_k - beta_{k-1}) is what rotor k takes of beta_k, the part of a_k across n_k over |n_k|.
"""

from __future__ import annotations

from phichain.proof.case import Case, proves
from phichain.proof.lagrange import along_told
from phichain.proof.modular.field import HALF, PRIME, Vector, dot, inverse, plus


@proves("constrained_accelerations", is_helper=True)
def constrained_accelerations(case: Case) -> None:
    """Lengths, the cart, and the links along a random turn."""
    point, chain, scene = case.point, case.chain, case.scene
    carts, size, q = point.carts, 2 if scene.is_planar else 3, chain.directions
    total = carts + size * scene.links
    (h,), rate, guess = point.free("h", 1), point.free("rate", total), point.free("guess", total)
    lead, force, push = point.free("lead", scene.links), point.free("force", size * scene.links), point.free("push", carts)
    place = [*point.free("place", carts), *(entry for link in q for entry in link)]
    asked = {array.name for array in case.subject.program.inputs}
    given = {"step": [h], "place": place, "rate": rate, "guess": guess, "lead": lead, "force": force, "push": push}
    found = case.run(point.given(**given))["acceleration"]
    speed = plus(rate, guess, h * HALF % PRIME)
    moved = plus(place, speed, h)

    def links(array: Vector) -> list[Vector]:
        return [array[i : i + size] for i in range(carts, total, size)]

    a, normals = links(found), links(moved)
    along = [(h * dot(w, g) - dot(w, w)) % PRIME for w, g in zip(links(speed), links(guess), strict=True)]
    case.same("along", [dot(n, one) % PRIME for n, one in zip(normals, a, strict=True)], along)
    base = found[:carts]
    if scene.base_accelerations:
        case.same("acceleration", base, point.u[:carts])
    elif carts:
        pushed = push if "push" in asked else point.u[:carts] if "u" in asked else [0] * carts
        held = [chain.total_mass * entry for entry in base]
        for mu, one in zip(chain.mu, a, strict=True):
            held = plus(held, one[:carts], mu)
        case.same("acceleration", held, pushed)
    turns = _turns(case, size)
    left = sum(dot(turn, pull) for turn, pull in zip(turns, _pulls(case, a, base, force if "force" in asked else None), strict=True))
    case.same("acceleration", [(left + _rotors(case, a, normals, turns, lead)) % PRIME], [0])


def _turns(case: Case, size: int) -> list[Vector]:
    """Random vectors across the links."""
    found = []
    for k, link in enumerate(case.chain.directions):
        free = case.point.free(f"turn {k}", size)
        found.append(plus(free, link, -dot(free, link)))
    return found


def _pulls(case: Case, a: list[Vector], base: Vector, force: Vector | None) -> list[Vector]:
    """What every link's vector is pulled with."""
    chain, scene, size = case.chain, case.scene, len(a[0])
    length, mu, moments = chain.per_link("length"), chain.mu, chain.moments
    still = [*base, *[0] * (size - len(base))]
    if scene.is_moving:
        still = along_told(scene, case.point.u)
    still = plus(still, [0] * (size - 1) + [1], -chain.single("gravity"))
    found = []
    for k in range(scene.links):
        pull = [mu[k] * entry for entry in still]
        for j, other in enumerate(a):
            pull = plus(pull, other, moments[k] if j == k else length[min(j, k)] * mu[max(j, k)])
        found.append(pull if force is None else plus(pull, force[size * k : size * (k + 1)], -1))
    return found


def _rotors(case: Case, a: list[Vector], normals: list[Vector], turns: list[Vector], lead: Vector) -> int:
    """The power of the rotors' couples along the turns of a planar chain."""
    if case.scene.armature is None:
        return 0
    beta = [(n[1] * one[0] - n[0] * one[1]) * inverse(dot(n, n)) % PRIME for n, one in zip(normals, a, strict=True)]
    angles = [(q[1] * turn[0] - q[0] * turn[1]) % PRIME for q, turn in zip(case.chain.directions, turns, strict=True)]
    power, inner, turned = 0, 0, 0
    for inertia, own, ahead, angle in zip(case.chain.per_link("armature"), beta, lead, angles, strict=True):
        power += inertia * (own + ahead - inner) % PRIME * (angle - turned)
        inner, turned = own, angle
    return power % PRIME
