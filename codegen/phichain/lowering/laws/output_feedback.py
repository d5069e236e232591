"""Output feedback as Programs: one call of it, and its start, both with the memory as arguments.

    z = z_expected + L w(y - y_0 - C z_expected),    u = clip(u_0 - K w(z) - K_i I, low, high),
    z_expected = F w(z) + H (u - u_0),               I = I + T w(y_i - y_0i) where nothing winds up.

What a call leaves in the memory is computed whole before any of it is stored, and has names of its own: a backend may let what
comes in and what goes out be the same cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isfinite
from typing import Final

from phichain.errors import EmissionError
from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Local, Program, Store
from phichain.ir.passes import prune
from phichain.ir.piecewise import wrapped
from phichain.laws import OutputFeedback
from phichain.lowering.laws.state_feedback import full_turn, limited

NEXT: Final = "_next"
"""What a call leaves in the memory is called as what it finds there, with this behind."""

_WITHIN: Final = Fraction(2**100)
"""Whatever is measured is smaller, or not finite; its square is a float."""


def output_feedback(law: OutputFeedback) -> Program:
    """`controller([expected,] [integral,] y_meas) -> [expected_next,] [integral_next,] u`, straight-line code."""
    builder = Builder("controller", f"Inputs of {law.name} that lead it to its target, from what is measured of it.")
    memory = {name: builder.input(name, (size,), _KEPT[name]) for name, size in law.memory.items()}
    measured = builder.input("y_meas", (len(law.measured_names),), "measurement")
    kept = {name: builder.output(f"{name}{NEXT}", (size,), _KEPT[name]) for name, size in law.memory.items()}
    inputs = builder.output("u", (len(law.input_names),), "inputs")
    off = _off(builder, law, measured, law.wraps if law.observer is None else (False,) * len(law.wraps))
    z = off if law.observer is None else _corrected(builder, law, memory["expected"], off)
    wanted = [_wanted(builder, law, row, z, memory.get("integral")) for row in range(len(law.gains))]
    u = [builder.let(f"{name}_held", limited(value, *bounds)) for name, value, *bounds in zip(law.input_names, wanted, law.low, law.high, strict=True)]
    following = {"expected": _expected(builder, law, z, u), "integral": _integrals(builder, law, measured, memory, wanted, u)}
    for name, cells in kept.items():
        for i, value in enumerate(following[name]):
            cells[i] = value
    for row, value in enumerate(u):
        inputs[row] = value
    return _in_place(prune(builder.finish()))


def output_feedback_reset(law: OutputFeedback) -> Program:
    """`reset(y_meas) -> [expected_next,] [integral_next]`: the memory at the first measurement, the chain at rest."""
    builder = Builder("reset", "The memory before the first call, at rest where it is measured to be.")
    measured = builder.input("y_meas", (len(law.measured_names),), "measurement") if law.observer else None
    kept = {name: builder.output(f"{name}{NEXT}", (size,), _KEPT[name]) for name, size in law.memory.items()}
    if law.observer and measured:
        off = [finite(value) for value in _off(builder, law, measured, law.wraps)]
        for i, row in enumerate(law.observer.start):
            kept["expected"][i] = _sum(builder, row, off)
    for i in range(len(law.integrated)):
        kept["integral"][i] = builder.lift(0)
    return prune(builder.finish())


_KEPT: Final = {"expected": "deviation that is expected at the next call", "integral": "integrals of deviations over time"}


def _off(builder: Builder, law: OutputFeedback, measured: ArrayRef, wraps: Sequence[bool]) -> list[Expr]:
    """y - y_0, less whole turns where it is said."""
    found = []
    for i, (name, offset, turns) in enumerate(zip(law.measured_names, law.offsets, wraps, strict=True)):
        away = measured[i] - offset
        found.append(builder.let(f"{name}_away", wrapped(away, full_turn()) if turns else away))
    return found


def _corrected(builder: Builder, law: OutputFeedback, expected: ArrayRef, off: Sequence[Expr]) -> list[Expr]:
    """w(z)."""
    assert law.observer is not None
    n = range(len(law.deviation_names))
    innovations = []
    for name, value, row, turns in zip(law.measured_names, off, law.observer.seen, law.wraps, strict=True):
        apart = value - _sum(builder, row, [expected[i] for i in n])
        apart = builder.let(f"{name}_apart", wrapped(apart, full_turn()) if turns else apart)
        innovations.append(builder.let(f"{name}_innovation", finite(apart)))
    found = []
    for i, name in enumerate(law.deviation_names):
        value = expected[i] + _sum(builder, law.observer.correction[i], innovations)
        value = builder.let(f"{name}_estimate", value)
        found.append(builder.let(f"{name}_off", wrapped(value, full_turn())) if law.turns[i] else value)
    return found


def _wanted(builder: Builder, law: OutputFeedback, row: int, z: Sequence[Expr], integral: ArrayRef | None) -> Expr:
    """One input without its limits."""
    u = builder.lift(law.rest[row])
    for gain, away in zip(law.gains[row], z, strict=True):
        u = u - gain * away
    for k, gain in enumerate(law.integral_gains[row]):
        assert integral is not None
        u = u - gain * integral[k]
    return builder.let(f"{law.input_names[row]}_wanted", u)


def _expected(builder: Builder, law: OutputFeedback, z: Sequence[Expr], u: Sequence[Expr]) -> list[Expr]:
    """F z + H (u - u_0)."""
    if law.observer is None:
        return []
    pushed = [value - rest for value, rest in zip(u, law.rest, strict=True)]
    rows = zip(law.deviation_names, law.observer.advance, law.observer.drive, strict=True)
    return [builder.let(f"{name}_next", _sum(builder, (*flow, *drive), [*z, *pushed])) for name, flow, drive in rows]


def _integrals(
    builder: Builder, law: OutputFeedback, measured: ArrayRef, memory: dict[str, ArrayRef], wanted: Sequence[Expr], u: Sequence[Expr]
) -> list[Expr]:
    """Integrals at the next call; what would drive an input further beyond its limit is held."""
    found = []
    for k, i in enumerate(law.integrated):
        away = measured[i] - law.offsets[i]
        away = wrapped(away, full_turn()) if law.wraps[i] else away
        gains = [row[k] for row in law.integral_gains]
        grows = grown(law, law.sample * finite(away), gains, wanted, u)
        found.append(builder.let(f"{law.measured_names[i]}_integral", memory["integral"][k] + grows))
    return found


def grown(law: OutputFeedback, grows: Expr, gains: Sequence[Expr | float], wanted: Sequence[Expr], u: Sequence[Expr]) -> Expr:
    """What an integral grows by: nothing while an input that it acts on is at a limit and would be driven beyond."""
    for row, (gain, low, high) in enumerate(zip(gains, law.low, law.high, strict=True)):
        if (isinstance(gain, Expr) or gain) and (isfinite(low) or isfinite(high)):
            beyond = (wanted[row] - u[row]) * (gain * grows)
            grows = grows.builder.apply("select", beyond, 0, 0, grows)
    return grows


def finite(value: Expr) -> Expr:
    """The value, or zero where it is not finite; a comparison with NaN does not hold."""
    return value.builder.apply("select", value * value, _WITHIN, value, 0)


def _sum(builder: Builder, factors: Sequence[float], values: Sequence[Expr]) -> Expr:
    total = builder.lift(0)
    for factor, value in zip(factors, values, strict=True):
        total = total + factor * value
    return total


def _in_place(program: Program) -> Program:
    """The Program, if every cell of its memory is stored from a value of its own, after all that is computed.

    Raises:
        EmissionError: One is not: a backend that keeps one memory would read what was just written.
    """
    named = {array.name for array in program.outputs}
    first = next(i for i, statement in enumerate(program.body) if isinstance(statement, Store))
    for statement in program.body[first:]:
        if not isinstance(statement, Store) or statement.cell.array not in named or not _is_own(statement):
            problem = "is stored before what is computed of it"
            raise EmissionError("law", program.name, problem, "give every entry of the memory a row that is not zero")
    return program


def _is_own(store: Store) -> bool:
    """A named value: no cell that another store may have changed, no expression written where it is stored."""
    return isinstance(store.value, Local) and not store.value.name.startswith("_")
