"""A law along a family of orbits -> Programs: between the nodes of its table, about its target, and against the chain's motion."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import sqrt
from typing import Final

from phichain.ir.builder import Builder, Expr
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.piecewise import maximum, minimum, wrapped
from phichain.laws import FamilyLaw
from phichain.laws.family import SLIP, SOFT
from phichain.lowering.laws import full_turn

STENCIL: Final = 4
"""Nodes that the cubic of Catmull and Rom goes through."""


def following(law: FamilyLaw) -> Program:
    """`following(x_meas, below, above, slow, f, g, side) -> u, slip, rate, load, off`: the law a share f above one rung, a share g behind one node.

    `below` and `above` are four nodes each of two rungs, the way being between the second and the third; a node is x_r, r, K. With
    c_i(g) the cubics of Catmull and Rom and b_i(g) their derivatives, times nodes a half period,

        (x_r, r, K) = sum_i c_i ((1 - f) below_i + f above_i),   x_r' = sum_i b_i ((1 - f) below_i + f above_i).

    side is 1 in the half period of the table, -1 in its mirror image. load is |K e_n| / limit, off |e_n|^2.
    """
    nx, nodes = len(law.catch.state_names), law.states.shape[1]
    width = 2 * nx + 1
    builder = Builder("following", f"Input of {law.name} between two orbits, and how the chain lies to them.")
    measured = builder.input("x_meas", (nx,), "measured state, (q, v)")
    rungs = [builder.input(name, (STENCIL * width,), "four nodes of a rung") for name in ("below", "above")]
    slow = builder.input("slow", (2,), "weights of squared rates on both rungs, s^2")
    f = builder.input("f", (), "share of the way to the rung above")[0]
    g = builder.input("g", (), "share of the way from node to node")[0]
    side = builder.input("side", (), "1 in the half period of the table, -1 in its mirror image")[0]
    names = ("u", "slip", "rate", "load", "off")
    texts = ("input", "how far ahead the chain is, half periods", "half periods a second", "share of the limit", "squared distance, rad^2")
    u, slip_out, rate, load, off = (builder.output(name, (1,) if name == "u" else (), text) for name, text in zip(names, texts, strict=True))

    def blended(basis: Sequence[Expr], entry: int, name: str) -> Expr:
        low, high = (_sum(basis[i] * rung[i * width + entry] for i in range(STENCIL)) for rung in rungs)
        return builder.let(name, low + f * (high - low))

    cubic, slope = _catmull_rom(builder, g, nodes - 1)
    labels = law.catch.state_names
    wanted = [blended(cubic, i, f"{labels[i]}_wanted") for i in range(nx)]
    along = [blended(slope, i, f"{labels[i]}_along") for i in range(nx)]
    gains = [blended(cubic, nx + 1 + i, f"{labels[i]}_gain") for i in range(nx)]
    away = [_turned(builder, law, side * measured[i] - wanted[i], i, f"{labels[i]}_away") for i in range(nx)]
    weight = builder.let("weight", slow[0] + f * (slow[1] - slow[0]))

    def product(one: list[Expr], other: list[Expr]) -> Expr:
        terms = [a * b for a, b in zip(one, other, strict=True)]
        return _sum(terms[: nx // 2]) + weight * _sum(terms[nx // 2 :])

    ahead = product(along, away) / (product(along, along) + Fraction(SOFT))
    slip = builder.let("ahead", minimum(maximum(ahead, -Fraction(SLIP)), Fraction(SLIP)))
    across = [builder.let(f"{labels[i]}_across", away[i] - slip * along[i]) for i in range(nx)]
    push = builder.let("push", -_sum(k * e for k, e in zip(gains, across, strict=True)))
    limit = Fraction(law.limit)
    u[0] = side * minimum(maximum(push, -limit), limit)
    slip_out[0] = slip
    rate[0] = blended(cubic, nx, "rate_wanted")
    load[0] = maximum(push, -push) * (1 / limit)
    off[0] = product(across, across)
    return prune(builder.finish())


def catching(law: FamilyLaw) -> Program:
    """`catching(x_meas) -> u, level`: the regulator of the target, and |W w(x - target)|^2."""
    catch = law.catch
    nx = len(catch.state_names)
    builder = Builder("catching", f"Input of {law.name} about the target, and how far the chain is from it.")
    measured = builder.input("x_meas", (nx,), "measured state, (q, v)")
    u, level = builder.output("u", (1,), "input"), builder.output("level", (), "at most 1 where it may take over")
    away = [_turned(builder, law, measured[i] - Fraction(catch.target[i]), i, f"{catch.state_names[i]}_away") for i in range(nx)]
    push = _sum(-Fraction(k) * e for k, e in zip(catch.gains[0], away, strict=True)) + Fraction(catch.rest[0])
    u[0] = minimum(maximum(push, -Fraction(law.limit)), Fraction(law.limit))
    parts = [_sum(Fraction(w) * e for w, e in zip(row, away, strict=True) if w) for row in law.shape.tolist()]
    level[0] = _sum(part * part for part in (builder.let(f"part_{k + 1}", part) for k, part in enumerate(parts)))
    return prune(builder.finish())


def calming(law: FamilyLaw) -> Program:
    """`calming(x_meas) -> u, size`: -limit v / (|v| + v_0) of the input's joint, and the weighed square of the motion about hanging.

    v_0 is a tenth of a radian in the time that the weights measure rates by.
    """
    catch = law.catch
    nx = len(catch.state_names)
    builder = Builder("calming", f"Input that takes energy from {law.name}, and how much it moves.")
    measured = builder.input("x_meas", (nx,), "measured state, (q, v)")
    u, size = builder.output("u", (1,), "input"), builder.output("size", (), "squared size of the motion, rad^2")
    rate = measured[driven(law)]
    slow = Fraction(0.1 / sqrt(float(law.weights[-1])))
    u[0] = -Fraction(law.limit) * rate / (maximum(rate, -rate) + slow)
    away = [_turned(builder, law, measured[i], i, f"{catch.state_names[i]}_away") for i in range(nx)]
    size[0] = _sum(Fraction(weight) * e * e for weight, e in zip(law.weights.tolist(), away, strict=True))
    return prune(builder.finish())


def driven(law: FamilyLaw) -> int:
    """The entry of the state that is the rate of the input's joint."""
    half = len(law.catch.state_names) // 2
    return half + int(law.catch.input_names[0].rpartition("_")[2]) - 1


def _catmull_rom(builder: Builder, g: Expr, intervals: int) -> tuple[list[Expr], list[Expr]]:
    """The cubics of four nodes, and their derivatives by the phase in half periods."""
    half = Fraction(1, 2)
    cubic = (-half * g * (1 - g) * (1 - g), 1 + half * g * g * (3 * g - 5), half * g * (1 + g * (4 - 3 * g)), half * g * g * (g - 1))
    slope = (g * (2 - 3 * half * g) - half, g * (9 * half * g - 5), half + g * (4 - 9 * half * g), g * (3 * half * g - 1))
    names = ("before", "here", "next", "behind")
    return (
        [builder.let(f"share_{name}", value) for name, value in zip(names, cubic, strict=True)],
        [builder.let(f"slope_{name}", intervals * value) for name, value in zip(names, slope, strict=True)],
    )


def _turned(builder: Builder, law: FamilyLaw, away: Expr, i: int, name: str) -> Expr:
    return builder.let(name, wrapped(away, full_turn()) if law.catch.wraps[i] else away)


def _sum(terms: object) -> Expr:
    total: Expr | None = None
    for term in terms:  # type: ignore[attr-defined]
        total = term if total is None else total + term
    assert total is not None
    return total
