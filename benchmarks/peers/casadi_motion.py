"""CasADi's equations of motion for SUNDIALS: the expert's recursion of a scene as x' = f(x)."""

from __future__ import annotations

from typing import Any

import casadi as ca

from benchmarks.chains import Chain
from benchmarks.harness import BenchmarkError
from benchmarks.peers import recursions
from phichain.scene import Scene


def right_hand_side(scene: Scene) -> tuple[Any, Any]:
    """(x, x') in the scene's coordinates.

    Raises:
        BenchmarkError: no expert's form is at hand.
    """
    x = ca.SX.sym("x", scene.nq + scene.nv)
    q, v = ca.vertsplit(x)[: scene.nq], ca.vertsplit(x)[scene.nq :]
    com = scene.com or scene.length
    if scene.is_planar and not scene.has_cart:
        rest = (0.0,) * scene.links
        joints = zip(scene.stiffness or rest, scene.damping or rest, q, v, strict=True)
        torque = [-k * a - d * w for k, d, a, w in joints] if scene.stiffness or scene.damping else []
        chain = Chain("planar", scene.mass, scene.length, com, None, False)  # type: ignore[arg-type]
        return x, ca.vertcat(*v, *recursions.planar_link_frame(chain, q, v, torque, ca.sin, ca.cos))
    if scene.is_planar or not scene.has_cart or scene.stiffness or scene.damping or com != scene.length:
        raise BenchmarkError("no expert's form at hand for this chain")
    chain = Chain("spatial", scene.mass, scene.length, com, scene.cart_mass, False)  # type: ignore[arg-type]
    moving = list(v[:2])
    for k in range(2, scene.nq, 3):
        moving += ca.vertsplit(ca.cross(ca.vertcat(*v[k : k + 3]), ca.vertcat(*q[k : k + 3])))
    return x, ca.vertcat(*moving, *recursions.spatial_tension(chain, q, v, ()))
