"""Taylor recurrences of planar chains: link frames at rest in the directions that the links have at the step's start.

With psi the angle of a link counted from its direction there, C and S its cosine and sine, w its rate, (a_x, a_y) the
acceleration of its joint less gravity, A = [X Z; Z Y] and p the articulated inertia and force of the chain beyond, all in
scaled time, the coefficients of order n obey

    S''_n = (n + 1) (w_{n+1} + sum_{j=0..n} C_{j+1} w_{n-j}),        C''_n = -(n + 1) sum_{j=0..n} S_{j+1} w_{n-j}
    Hy_n + sum_{j=0..n-1} (C_{j+1} Hy_{n-1-j} - S_{j+1} Hx_{n-1-j}) = tau_n,      H = m r (a + r (C'', S'')) + l F

F the force at the link's tip. That is the sweep of `lowering.planar.articulated` with C''_n for -w^2 and constant matrices: with
s, c sine and cosine of the joint's angle, X, Z, E = X Y - Z^2 of the chain beyond in its own frame, e = X s + Z c,

    D = m r^2 + l^2 A_yy,   A_yy = (e^2 + c^2 E) / X,   kappa = m r (l - r) / D,   U_x = l A_xy,   U_y = m r + l A_yy
    Q = [(c m r^2 + l^2 (e Z + c E) / X) / D, -(s m r^2 + l^2 e) / D; -kappa s, -kappa c]
    p' = Q p + (m r + l (X' - m), -kappa U_x) C''_n + (U_x, U_y) y / D,                  y = tau_n - (the sum above)
    a_beyond = Q^T (a + (l C''_n, 0)) + l z (s, c),    z = (y - l (s p_x + c p_y)) / D,   S''_n = z - (l U_x C''_n + U.a) / D

Q holds what turning and eliminating do to a force, multiplied out so that nothing cancels (docs/theory.md). A cart is the
same with m r^2 -> m_c, l -> 1 and the vertical for the link's direction. Where joints carry rotors, moments go along with the
forces (`lowering.planar.geared`).
"""

from __future__ import annotations

from phichain.ir.builder import Builder
from phichain.ir.nodes import Program
from phichain.ir.passes import prune, unroll
from phichain.lowering.chain.body import point_masses
from phichain.lowering.planar.joints import absolute, difference
from phichain.lowering.series.dry import KINDS, Dry, places
from phichain.lowering.series.geared_factor import GearedFactor
from phichain.lowering.series.geared_order import GearedOrder
from phichain.lowering.series.held import Layout
from phichain.lowering.series.planar_factor import Factor, planar_factor
from phichain.lowering.series.planar_held import inverts, planar_layout
from phichain.lowering.series.planar_order import Order, planar_order
from phichain.lowering.series.series import HELD, LEAD, LEFT, RIGHT, Series
from phichain.lowering.series.two_links.factor import TwoFactor
from phichain.lowering.series.two_links.order import TwoOrder
from phichain.mechanics import Model
from phichain.scene import Scene

#: Links up to which the Programs are straight-line code.
UNROLLED = 4


def planar_series(model: Model) -> Series:
    """The recurrences of a planar scene."""
    scene = point_masses(model.scene)
    layout, rubbing = planar_layout(scene), places(scene)
    elimination, substitution = (Factor, Order) if scene.armature is None else (GearedFactor, GearedOrder)
    if inverts(scene):
        elimination, substitution = TwoFactor, TwoOrder
    written = unroll if scene.links <= UNROLLED else (lambda program: program)
    return Series(
        factor=written(planar_factor(model, layout, elimination)),
        order=written(planar_order(model, layout, substitution)),
        columns=written(_columns(scene, layout)) if scene.variational else None,
        lanes=2 * scene.links,
        rights=2,
        squares=0,
        held=layout.size,
        dry=rubbing,
        by_links=True,
    )


def _columns(scene: Scene, layout: Layout) -> Program:
    """Variations of rows 0: psi_k varies with the link's angle, and its cosine and sine of order 0 with it."""
    links, offset, rubbing = scene.links, int(scene.has_cart), places(scene)
    builder = Builder("flow_columns", "Derivatives of rows 0 along a variation of the state.")
    held = builder.input(HELD, (layout.size,), "constants of the step") if rubbing else None
    right = builder.input(RIGHT, (4 * links,), "the links' rates")
    dq, dv = builder.input("dq", (scene.nq,), "variation"), builder.input("dv", (scene.nv,), "variation, scaled time")
    lead = builder.output(LEAD, (2 * links,), "of the links' cosines and sines themselves")
    d_left = builder.output(f"d_{LEFT}", (2 * links + KINDS * rubbing,), "of row 0")
    d_right = builder.output(f"d_{RIGHT}", (4 * links,), "of row 0")
    angle = absolute(builder, scene, "angle", dq.shifted(offset))
    rate = absolute(builder, scene, "rate", dv.shifted(offset))
    zero = builder.lift(0)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        lead[k], lead[k + links] = zero, angle[k]
        d_left[k], d_left[k + links] = -(angle[k] * right[k]), rate[k]
        d_right[k], d_right[k + links] = rate[k], rate[k]
        d_right[k + 2 * links], d_right[k + 3 * links] = zero, zero
    if held is not None:
        slip = None if scene.friction is None else difference(builder, scene, "joint_rate", dv.shifted(offset))
        Dry(builder, scene, layout, held, 2 * links).vary(slip, dv[0] if offset else None, d_left)
    return prune(builder.finish())
