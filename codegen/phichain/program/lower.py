"""Scene functions -> Programs: which lowering serves which function of which scene."""

from __future__ import annotations

from phichain.program import planar_articulated, planar_tension, spatial_articulated, spatial_tension
from phichain.program.builder import ArrayRef, Builder
from phichain.program.nodes import Program
from phichain.program.parameters import Parameters
from phichain.program.planar_joints import planar_state
from phichain.scene import Scene


def forward_dynamics(scene: Scene) -> Program:
    builder = Builder("forward_dynamics", "Accelerations: the equations of motion solved.")
    parameters = Parameters(builder, scene)
    q = builder.input("q", (scene.nq,))
    v = builder.input("v", (scene.nv,))
    u = builder.input("u", (scene.nu,)) if scene.nu else None
    a = builder.output("a", (scene.nv,))
    if scene.is_planar:
        form = planar_tension if scene.tip_masses else planar_articulated
        form.accelerations(builder, scene, parameters, planar_state(builder, scene, q, v), u, a)
    else:
        form = spatial_tension if scene.tip_masses else spatial_articulated
        form.accelerations(builder, scene, parameters, q, v, u, a)
    return builder.finish()
