"""State feedback as a Program: a target, whole turns taken from angles, gains and limits."""

from __future__ import annotations

from fractions import Fraction
from math import isfinite

from mpmath import libmp

from phichain.ir.builder import Builder, Expr
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.piecewise import maximum, minimum, wrapped
from phichain.laws import StateFeedback

_BITS = 240


def full_turn() -> Fraction:
    """2 pi to 70 digits: whatever a backend rounds it to is rounded once."""
    # Whole numbers all the way, the same on every machine.
    return Fraction(2 * libmp.pi_fixed(_BITS), 2**_BITS)


def controller(law: StateFeedback) -> Program:
    """`controller(x_meas) -> u` with u = clip(u_0 - K w(x_meas - x_target), low, high), straight-line code.

    w takes whole turns from the deviations of angles that are to be wrapped: d - 2 pi floor(d / 2 pi + 1/2), in
    [-pi, pi). Gains and targets that are zero cost nothing. An input is NaN where a measurement that acts on it is.
    """
    builder = Builder("controller", f"Inputs of {law.name} that lead it to its target, from its measured state.")
    measured = builder.input("x_meas", (len(law.state_names),), "measured state, (q, v)")
    inputs = builder.output("u", (len(law.input_names),), "inputs")
    away = [_deviation(builder, law, measured[i], i) for i in range(len(law.state_names))]
    for row, gains in enumerate(law.gains):
        u = builder.lift(law.rest[row])
        for gain, deviation in zip(gains, away, strict=True):
            u = u - gain * deviation
        inputs[row] = limited(u, law.low[row], law.high[row])
    return prune(builder.finish())


def _deviation(builder: Builder, law: StateFeedback, value: Expr, i: int) -> Expr:
    away = value - law.target[i]
    name = f"{law.state_names[i]}_away"
    if not law.wraps[i]:
        return builder.let(name, away)
    return builder.let(name, wrapped(away, full_turn()))


def limited(u: Expr, low: float, high: float) -> Expr:
    """u between its limits, those that are finite; NaN where u is."""
    above = maximum(u, low) if isfinite(low) else u
    return minimum(above, high) if isfinite(high) else above
