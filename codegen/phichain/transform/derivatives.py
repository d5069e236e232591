"""Partial derivatives of each scalar operation: the one table both forms of the tangent pass read."""

from __future__ import annotations

from phichain.errors import EmissionError
from phichain.ir.builder import Builder, Expr


def directional(
    builder: Builder, kind: str, args: list[Expr], result: Expr, directions: list[Expr | None]
) -> Expr | None:
    """The derivative of ``result = kind(args)`` when the arguments move along `directions` (None: they do not).

    Returns:
        The derivative, or None when it is structurally zero.
    """
    if kind == "select":
        below, above = (builder.lift(0) if given is None else given for given in directions[2:])
        slope = builder.apply("select", *args[:2], below, above)
        return None if slope.is_zero else slope
    if kind == "floor":
        return None
    total: Expr | None = None
    for position, direction in enumerate(directions):
        if direction is None:
            continue
        term = _term(builder, kind, args, result, position, direction)
        total = term if total is None else total + term
    return None if total is None or total.is_zero else total


def _term(builder: Builder, kind: str, args: list[Expr], result: Expr, position: int, direction: Expr) -> Expr:
    match kind, position:
        case ("add", _) | ("sub", 0):
            return direction
        case ("sub", 1) | ("neg", 0):
            return -direction
        case "mul", _:
            return args[1 - position] * direction
        case "div", 0:
            return (1 / args[1]) * direction
        case "div", 1:
            return -((1 / args[1]) * result * direction)
        case "sqrt", 0:
            return (1 / (2 * result)) * direction
        case "sin", 0:
            return builder.cos(args[0]) * direction
        case "cos", 0:
            return -(builder.sin(args[0]) * direction)
        case "tanh", 0:
            return ((1 - result) * (1 + result)) * direction
    return _bessel(builder, int(kind[-1]), args[0]) * direction


def _bessel(builder: Builder, order: int, x: Expr) -> Expr:
    """J_0' = -J_1 and J_n' = (J_{n-1} - J_{n+1}) / 2."""

    if order >= 4:
        raise EmissionError(
            "besselj4", order, "its derivative needs J_5, which no backend has", "differentiate phi once, not twice"
        )

    def bessel(n: int) -> Expr:
        return builder.apply(f"besselj{n}", x)

    return -bessel(1) if order == 0 else (bessel(order - 1) - bessel(order + 1)) / 2
