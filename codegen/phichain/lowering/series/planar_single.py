"""Taylor recurrences of one planar link on a fixed base: two products, since its only force is its weight.

With psi the angle from the link's direction at the step's start, C and S its cosine and sine, w its rate, in scaled time

    S' = C w,   C' = -S w,   w' = (a_x S - a_y C) / r + tau / (m r^2)

where (a_x, a_y) = rho^2 g (-cos phi_0, sin phi_0) is gravity as the acceleration of the base in the link's frame; a moving base
adds its own. With a rotor at the joint 1 / r becomes m r / (m r^2 + A), and 1 / (m r^2) likewise.

Where weight and a constant torque are all that acts, the two products become one and half a square. With f and g the weight's
part of w' and the same a quarter turn on, and d the torque's,

    w' = f + d,   f' = g w,   g' = -f w,   hence   w'' = g w,   g = const - w^2 / 2 + d psi

the last being the energy. Order n of w wants those up to n - 2 alone, so orders come in pairs that do not wait for each other. Products are then of g
and f, from which derivatives by the state start as (-f, g) times that of the angle.
"""

from __future__ import annotations

from phichain.ir.builder import Builder, Expr
from phichain.ir.nodes import Program
from phichain.ir.passes import prune, unroll
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.units import units_of_links
from phichain.lowering.planar.joint_state import loses_bends
from phichain.lowering.planar.joints import input_couples
from phichain.lowering.series.dry import KINDS, Dry, places
from phichain.lowering.series.dry import runs as dry_runs
from phichain.lowering.series.held import Layout
from phichain.lowering.series.planar_factor import directions
from phichain.lowering.series.series import (
    COEFFICIENT,
    HELD,
    HIGHEST,
    LEAD,
    LEFT,
    LOST,
    NEWEST,
    NEXT,
    NOW,
    RIGHT,
    ROWS,
    SCALE,
    SUMS,
    Series,
)
from phichain.mechanics import Model
from phichain.scene import Scene


def single_series(model: Model) -> Series:
    """The recurrences of a planar scene of one link without a cart."""
    scene = model.scene
    return Series(
        factor=_factor(model),
        order=_order(model),
        columns=_columns(scene) if scene.variational else None,
        lanes=2,
        rights=1,
        squares=0,
        held=_held(scene).size,
        dry=places(scene),
        outright=_outright(scene) if _is_free(scene) else None,
    )


def _held(scene: Scene) -> Layout:
    """Weight along and across the link, then what there is of input, spring and damper, a forced spring's angle of rest, what rounding took from its bend, and dry friction."""
    runs = [("weight", 2), ("drive", int(bool(scene.actuated_joints))), ("stiffness", int(scene.stiffness is not None))]
    return Layout([*runs, ("damping", int(scene.damping is not None)), ("rest", int(_holds_rest(scene))), ("bend", int(loses_bends(scene))), *dry_runs(scene)])


def _holds_rest(scene: Scene) -> bool:
    return scene.forced is not None and scene.rest_angle is not None


def _factor(model: Model) -> Program:
    scene = model.scene
    builder = Builder("flow_factor", "What is constant over a step.")
    points = point_masses(scene)
    parameters = Parameters(builder, model, units_of_links(points), points)
    q, v = builder.input("q", (1,), "configuration"), builder.input("v", (1,), "rates in scaled time")
    u = builder.input("u", (scene.nu,), "inputs") if scene.nu else None
    scale = builder.input(SCALE, (2,), "unit of time and its square")
    lost = builder.input(LOST, (2,), "what rounding took from q and v")
    layout = _held(scene)
    held = builder.output(HELD, (layout.size,), "constants of the step")
    left = builder.output(LEFT, (2 + KINDS * places(scene),), "the link's cosine and sine")
    right = builder.output(RIGHT, (2,), "the link's rate, twice")
    sine, cosine = directions(builder, scene, q, lost)
    bodies, rotor = parameters.bodies, parameters.armature
    fall = carried(builder, scene, parameters, u).parameters.fall
    if bodies is None and rotor is None:
        inverse = 1 / (parameters.mass[0] * parameters.com[0] * parameters.com[0])
        aside, weight = (scale[1] * (entry / parameters.com[0]) for entry in fall)
    else:
        first, second = _moments(parameters)
        inverse = 1 / (second if rotor is None else second + rotor[0])
        aside, weight = (scale[1] * (entry * (first * inverse)) for entry in fall)
    held[0], held[1] = -(weight * cosine[0] + aside * sine[0]), aside * cosine[0] - weight * sine[0]
    couple = input_couples(builder, scene, parameters, u)
    if couple is not None:
        layout.of(held, "drive")[0] = scale[1] * (couple[0] * inverse)
    if parameters.stiffness is not None:
        layout.of(held, "stiffness")[0] = scale[1] * (parameters.stiffness[0] * inverse)
    if parameters.damping is not None:
        layout.of(held, "damping")[0] = scale[0] * (parameters.damping[0] * inverse)
    if "rest" in layout and parameters.rest_angle is not None:
        layout.of(held, "rest")[0] = parameters.rest_angle[0]
    if "bend" in layout:
        layout.of(held, "bend")[0] = lost[0]
    left[0], left[1] = (held[0], held[1]) if _is_free(scene) else (builder.lift(1), builder.lift(0))
    right[0], right[1] = v[0], v[0]
    if places(scene):
        Dry(builder, scene, layout, held, 2).begin(parameters, scale, v, None, left, inverse)
    return prune(unroll(builder.finish()))


def _moments(parameters: Parameters) -> tuple[Expr, Expr]:
    """First and second moment of the link about its joint."""
    if parameters.bodies is not None:
        return parameters.bodies.first[0], parameters.bodies.second[0]
    moment = parameters.mass[0] * parameters.com[0]
    return moment, moment * parameters.com[0]


def _order(model: Model) -> Program:
    scene, builder = model.scene, Builder("flow_order", "Coefficients of order n + 1 of the Taylor series.")
    rest = None if scene.rest_angle is None else Parameters(builder, model, units_of_links(scene)).rest_angle
    layout, rubbing = _held(scene), places(scene)
    held = builder.input(HELD, (layout.size,), "constants of the step")
    if "rest" in layout:
        rest = layout.of(held, "rest")
    sums = builder.input(SUMS, (2 + 2 * rubbing,), "products of cosine, sine and rate")
    newest = builder.input(NEWEST, (2 + KINDS * rubbing,), "coefficients of order n of cosine and sine")
    coefficient = builder.input(COEFFICIENT, (2,), "coefficients of order n of the state")
    now = builder.input(NOW, (4,), "n + 1, 1 / (n + 1), 1 / ((n + 1) (n + 2)), and whether n = 0")
    left = builder.output(LEFT, (2 + KINDS * rubbing,), "coefficients n + 1 of cosine and sine")
    right = builder.output(RIGHT, (2,), "coefficient n + 1 of the rate, twice")
    following = builder.output(NEXT, (2,), "coefficients of order n + 1 of the state")
    swing = newest[1] if _is_free(scene) else held[0] * newest[1] + held[1] * newest[0]
    if "drive" in layout:
        swing = swing + now[3] * layout.of(held, "drive")[0]
    if "stiffness" in layout:
        bend = coefficient[0] if rest is None else coefficient[0] - now[3] * rest[0]
        if "bend" in layout:
            bend = bend + now[3] * layout.of(held, "bend")[0]
        swing = swing - layout.of(held, "stiffness")[0] * bend
    if "damping" in layout:
        swing = swing - layout.of(held, "damping")[0] * coefficient[1]
    dry = Dry(builder, scene, layout, held, 2)
    if rubbing:
        swing = swing - dry.saturated(newest, 0)
    rate = builder.let("rate", now[1] * swing)
    left[0], left[1] = -(now[1] * sums[1]), now[1] * sums[0]
    right[0], right[1] = rate, rate
    following[0], following[1] = now[1] * coefficient[1], rate
    if rubbing:
        dry.follow(now, sums.shifted(2), right, None, left)
    return prune(unroll(builder.finish()) if rubbing else builder.finish())


def _is_free(scene: Scene) -> bool:
    """Whether weight and a constant torque are all that acts, derivatives are by the state alone, and code may be straight-line."""
    hindered = scene.stiffness is not None or scene.damping is not None or places(scene) or scene.forced is not None
    return not hindered and not scene.varied and scene.code != "loops"


def _outright(scene: Scene) -> Program:
    """All orders, in pairs; the newest factors enter last, since everything else is there before they are."""
    builder, layout, highest = Builder("flow_outright", "Coefficients of all orders of the Taylor series."), _held(scene), HIGHEST[scene.real]
    held = builder.input(HELD, (layout.size,), "constants of the step")
    right = builder.input(RIGHT, (2,), "the link's rate, twice")
    slope = builder.input("slope", (2,), "coefficients of order 1 of the state")
    drive = layout.of(held, "drive")[0] if "drive" in layout else None
    w, g = [right[0], slope[1]], [held[0]]

    def height(n: int) -> Expr:
        """-g of order n but for what torque does, halves of the square's pairs; pairs with the newest rates last."""
        terms = [w[j] * w[n - j] for j in range((n - 1) // 2, -1, -1)]
        return _sum([w[n // 2] * w[n // 2] / 2, *terms] if n % 2 == 0 else terms)

    def extend() -> None:
        n = len(g)
        value = -height(n) if drive is None else drive * w[n - 1] / n - height(n)
        g.append(builder.let(f"g_{n}", value))

    extend()
    for n in range(0, highest - 1, 2):
        for order in (n, n + 1)[: highest - 1 - n]:
            terms = sorted(((max(j, order - j), g[j] * w[order - j]) for j in range(order + 1)), key=lambda term: term[0])
            w.append(builder.let(f"w_{order + 2}", _sum([term for _, term in terms]) / ((order + 1) * (order + 2))))
        while len(g) < len(w):
            extend()
    if scene.variational:
        left = builder.output(LEFT, (2 * highest,), "g and f of all orders but the highest")
        ahead = builder.output("rates", (2 * (highest + 1),), "the rate of all orders, twice")
        for n in range(highest):
            left[2 * n], left[2 * n + 1] = g[n], (n + 1) * w[n + 1] if n else held[1]
        for n, rate in enumerate(w):
            ahead[2 * n], ahead[2 * n + 1] = rate, rate
    rows = builder.output(ROWS, (2 * (highest + 1),), "coefficients of all orders of what the state moves by")
    for n, rate in enumerate(w):
        rows[2 * n] = slope[0] if n == 1 else w[n - 1] / n if n else builder.lift(0)
        rows[2 * n + 1] = rate
    return prune(builder.finish())


def _sum(terms: list[Expr]) -> Expr:
    """Terms added in two chains that do not wait for each other, the last two terms last."""
    if len(terms) < 5:
        return sum(terms[1:], terms[0])
    *early, before, last = terms
    one, other = early[0::2], early[1::2]
    return sum(one[1:], one[0]) + sum(other[1:], other[0]) + before + last


def _columns(scene: Scene) -> Program:
    builder, layout, rubbing = Builder("flow_columns", "Derivatives of rows 0 along a variation of the state."), _held(scene), places(scene)
    held = builder.input(HELD, (layout.size,), "constants of the step") if rubbing or _is_free(scene) else None
    dq, dv = builder.input("dq", (1,), "variation"), builder.input("dv", (1,), "variation, scaled time")
    lead = builder.output(LEAD, (2,), "of what stands before row 0: nothing")
    left = builder.output(f"d_{LEFT}", (2 + KINDS * rubbing,), "of cosine and sine")
    right = builder.output(f"d_{RIGHT}", (2,), "of the rate")
    lead[0], lead[1] = builder.lift(0), builder.lift(0)
    left[0], left[1] = (-(held[1] * dq[0]), held[0] * dq[0]) if held is not None and not rubbing else (builder.lift(0), dq[0])
    right[0], right[1] = dv[0], dv[0]
    if held is None or not rubbing:
        return builder.finish()
    Dry(builder, scene, layout, held, 2).vary(dv, None, left)
    return prune(unroll(builder.finish()))

