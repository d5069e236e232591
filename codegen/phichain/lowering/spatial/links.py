"""Unit vectors of a spatial chain: the products between neighbours that every sweep shares, and the couples on the links.

Springs: V = sum k_k (1 - q_{k-1}.q_k), q_{-1} = e_3; dampers and dry friction: the couple -c_k (omega_k - omega_{k-1}) between
neighbours, c_k a number or a function of their slip (`chain.losses`). Both act on link k through the tangent vector n_k (a force times a length) with q_k'' gaining n_k / inertia along it.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.lowering.algebra.vector import Vector, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import joint_resistance, slows_joints, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene


def directions(scene: Scene, q: ArrayRef) -> ArrayRef:
    """The unit vectors within q, three cells a link."""
    return q.shifted(2 if scene.has_cart else 0)


def neighbours(builder: Builder, direction: ArrayRef, links: int) -> tuple[ArrayRef, ArrayRef]:
    """Cosines q_{k-1}.q_k and crosses q_k x q_{k-1} for k = 1..N-1; crosses are zero beyond the tip (k = N)."""
    cosine, crosses = builder.array("cosine", links), builder.array("cross", 3 * links + 3)
    with builder.loop("k", 1, links) as loop:
        write_cosine(builder, cosine, direction, loop.index)
        write_cross(builder, crosses, direction, loop.index)
    nothing = builder.lift(0)
    store(crosses, links, (nothing, nothing, nothing))
    return cosine, crosses


def cosines(builder: Builder, direction: ArrayRef, links: int) -> tuple[ArrayRef, ArrayRef]:
    """The same where the crosses between links are still to be written (`write_cross`)."""
    cosine, crosses = builder.array("cosine", links), builder.array("cross", 3 * links + 3)
    with builder.loop("k", 1, links) as loop:
        write_cosine(builder, cosine, direction, loop.index)
    nothing = builder.lift(0)
    store(crosses, links, (nothing, nothing, nothing))
    return cosine, crosses


def write_cosine(builder: Builder, cosine: ArrayRef, direction: ArrayRef, k: Index) -> None:
    """q_{k-1}.q_k."""
    cosine[k] = builder.let("cosine_k", dot(load(direction, k - 1), load(direction, k)))


def write_cross(builder: Builder, crosses: ArrayRef, direction: ArrayRef, k: Index) -> None:
    """q_k x q_{k-1}."""
    across = cross(load(direction, k), load(direction, k - 1))
    let = builder.let
    store(crosses, k, (let("cross_x", across[0]), let("cross_y", across[1]), let("cross_z", across[2])))


def couples(
    builder: Builder, scene: Scene, parameters: Parameters, direction: ArrayRef, angular: Callable[[], ArrayRef],
    bend: ArrayRef | None = None,
) -> ArrayRef | None:  # fmt: skip
    """n_k of springs, dampers and dry friction, tangent to q_k, three cells a link; None on a scene without any.

    `angular` gives the omega_k and is asked where something resists them; `bend` holds the q_{k-1} - q_k where they are known to
    more digits than the q_k are.
    """
    moment = joint_moments(builder, scene, parameters, direction, angular, bend)
    return None if moment is None else couples_of(builder, scene, direction, moment)


def joint_moments(
    builder: Builder, scene: Scene, parameters: Parameters, direction: ArrayRef, angular: Callable[[], ArrayRef],
    bend: ArrayRef | None = None,
) -> ArrayRef | None:  # fmt: skip
    """The moment of every joint on the link beyond it, and zero beyond the tip; None on a scene without any."""
    if not ties_links(scene):
        return None
    links = scene.links
    moment = builder.array("joint_moment", 3 * links + 3)
    nothing = builder.lift(0)
    upright: Vector = (nothing, nothing, builder.lift(1))
    still: Vector = (nothing, nothing, nothing)
    omega = angular() if slows_joints(scene) else None
    first = still if omega is None else load(omega, 0)
    # q_k x q_{k-1} = q_k x (q_{k-1} - q_k)
    inner = upright if bend is None else load(bend, 0)
    store(moment, 0, _moment(scene, parameters, 0, inner, load(direction, 0), first))
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        bending = still if omega is None else sub(load(omega, k), load(omega, k - 1))
        inner = load(direction, k - 1) if bend is None else load(bend, k)
        store(moment, k, _moment(scene, parameters, k, inner, load(direction, k), bending))
    store(moment, links, still)
    return moment


def couples_of(builder: Builder, scene: Scene, direction: ArrayRef, moment: ArrayRef) -> ArrayRef:
    """(M_k - M_{k+1}) x q_k of the joints' moments."""
    links = scene.links
    couple = builder.array("couple", 3 * links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        net = sub(load(moment, k), load(moment, k + 1))
        store(couple, k, cross(net, load(direction, k)))
    return couple


def _moment(scene: Scene, parameters: Parameters, k: Index, inner: Vector, outer: Vector, bending: Vector) -> Vector:
    """Moment of joint k on the link beyond it: k_k q_k x q_{k-1} - c_k bending, bending = omega_k - omega_{k-1}."""
    stiffness, resistance = parameters.stiffness, joint_resistance(scene, parameters, k, bending)
    spring = None if stiffness is None else scale(stiffness[k], cross(outer, inner))
    if resistance is None:
        assert spring is not None
        return spring
    return scale(-resistance, bending) if spring is None else sub(spring, scale(resistance, bending))
