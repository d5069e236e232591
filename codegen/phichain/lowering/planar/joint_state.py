"""A planar state in joint terms and back, with the digits that the scene's own angles do not hold.

Springs and dampers act on joint angles. Where the scene's angles are absolute or adjacent these are differences, and what
rounding takes from an angle of size 1 is, times a stiffness of 1e13, a torque of 1e-3. What runs over many steps therefore
carries joint angles and rates inside, each as a number and a rest (two-sum: Knuth 1969; Moller 1965), and goes through

    theta_k = joint_k + theta_{k-lag},   tau_joint,k = tau_k + tau_joint,k+lag,   lag = 1 (absolute), 2 (adjacent)

only at the ends of a call. Both ways lose less than the square of the round-off.
"""

from __future__ import annotations

from dataclasses import replace

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.losses import ties_links
from phichain.scene import Scene

Double = tuple[Expr, Expr]

#: How many angles back the one lies that a joint's angle is the difference to.
LAG = {"relative": 0, "absolute": 1, "adjacent": 2}


def carries_joints(scene: Scene) -> bool:
    """Whether joints transmit moments that differences of the scene's angles would blur."""
    return scene.is_planar and scene.links > 1 and scene.angles != "relative" and ties_links(scene)


def loses_bends(scene: Scene) -> bool:
    """Whether what a spring sees is a difference of numbers, small beside what rounding takes from them."""
    if not scene.is_planar or scene.stiffness is None:
        return False
    return scene.rest_angle is not None or carries_joints(scene)


def joint_scene(scene: Scene) -> Scene:
    """The same chain in joint angles, with a torque at every joint where the scene has one anywhere."""
    actuated = "all" if scene.actuated_joints else scene.actuated
    return replace(scene, angles="relative", actuated=actuated, want=("forward_dynamics",), variational=False, forced=None, axis=None)


def two_sum(a: Expr, b: Expr) -> Double:
    """a + b, rounded, and exactly what rounding took."""
    let = a.builder.let
    total = let("total", a + b)
    other = let("other", total - a)
    return total, (a - (total - other)) + (b - other)


def rest_of_difference(
    builder: Builder, scene: Scene, name: str, theta: ArrayRef, lost: ArrayRef
) -> ArrayRef:
    """What the rounded `planar.joints.difference` of theta leaves out of that of theta + lost."""
    lag, rest = LAG[str(scene.angles)], builder.array(name, scene.links)
    for first in range(min(lag or scene.links, scene.links)):
        rest[first] = lost[first]
    if lag:
        with builder.loop("k", min(lag, scene.links), scene.links) as loop:
            k = loop.index
            rest[k] = two_sum(theta[k], -theta[k - lag])[1] + (lost[k] - lost[k - lag])
    return rest


def to_joints(scene: Scene) -> Program:
    """q, v and what rounding took from them -> the same of the joints."""
    builder = Builder(
        "stiff_to_joints", "Joint angles and rates of a state, and what rounding took from them."
    )
    return _converted(builder, scene, is_inwards=True)


def from_joints(scene: Scene) -> Program:
    """Joint angles and rates, and what rounding took from them -> the state."""
    builder = Builder(
        "stiff_from_joints", "The state of joint angles and rates, and what rounding took from it."
    )
    return _converted(builder, scene, is_inwards=False)


def to_joint_inputs(scene: Scene) -> Program:
    """u, conjugate to the scene's angles -> forces conjugate to the joints' angles."""
    builder = Builder(
        "stiff_joint_inputs", "Torques at the joints of torques conjugate to the scene's angles."
    )
    carts, links, lag = scene.base_inputs, scene.links, LAG[str(scene.angles)]
    u = builder.input("u", (scene.nu,), "inputs")
    out = builder.output("joint_u", (joint_scene(scene).nu,), "force, torques at the joints")
    for i in range(carts):
        out[i] = u[i]
    own = {joint - 1: u[carts + i] for i, joint in enumerate(scene.actuated_joints)}
    for k in reversed(range(links)):
        torque = own.get(k, builder.lift(0))
        out[carts + k] = torque + out[carts + k + lag] if k + lag < links else torque
    return prune(builder.finish())


def _settled(total: Expr, rest: Expr) -> Double:
    """A number and a rest as the nearest number and its rest."""
    whole, left = two_sum(total, rest)
    return whole, whole.builder.let("left", left)


def _converted(builder: Builder, scene: Scene, is_inwards: bool) -> Program:
    """Each entry less that of the state one `LAG` before it (inwards), or the sum with the one made there."""
    size, carts, lag = scene.nq, int(scene.has_cart), LAG[str(scene.angles)]
    sizes = {"q": size, "v": size, "lost": 2 * size}
    given = [builder.input(name, (count,), name) for name, count in sizes.items()]
    made = [builder.output(f"{name}_made", (count,), name) for name, count in sizes.items()]
    for part in range(2):
        (old, old_rest), (new, new_rest) = (
            (half[part], half[2].shifted(part * size)) for half in (given, made)
        )
        for i in range(carts + lag):
            new[i], new_rest[i] = _settled(old[i], old_rest[i])
        with builder.loop("k", carts + lag, size) as loop:
            k = loop.index
            if is_inwards:
                total, rest = two_sum(old[k], -old[k - lag])
                rest = rest + (old_rest[k] - old_rest[k - lag])
            else:
                total, rest = two_sum(old[k], new[k - lag])
                rest = rest + (old_rest[k] + new_rest[k - lag])
            new[k], new_rest[k] = _settled(total, rest)
    return prune(builder.finish())
