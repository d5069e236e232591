"""What functions cost at most on a Cortex-M4F: flash, stack and instructions, from their statements alone.

A generated text may depend on no compiler that happens to be installed, so nothing is measured here: bounds are linear in what
a Program holds, fitted above what gcc 12 makes of it (-Os, -O2 a quarter more), and `make firmware` holds them against
measurements. The C library's own code and stack come on top where a scene leaves sines and cosines to it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from typing import Final

from phichain.emit.c.storage import own_storage, shared_storage
from phichain.emit.printed import Printed
from phichain.errors import UnsupportedError
from phichain.ir.nodes import Local, Op, Program, SinCos, Statement, Store, walk
from phichain.ir.passes import total_operations

#: Bytes: of a call with its saved registers; of a statement, and of one more where registers run out; of sine and cosine; of a loop.
_ENTRY, _STATEMENT, _SPILL, _SPILLS_FROM, _ANGLE, _LOOP = 72, 4.2, 2.2, 480, 10, 34
#: What bytes are multiplied by in double precision, which the M4F computes by calls; and at -O2.
_DOUBLE, _FASTER = 3.0, 1.25
#: Bytes of the sine-cosine kernel by who computes them, and of its frame with what it calls.
_KERNEL: Final = {"float": {"libm": 64, "hook": 64, "bundled": 500, None: 480}, "double": {"libm": 64, "hook": 64, "bundled": 1500, None: 1300}}
_KERNEL_STACK: Final = {"float": 64, "double": 200}
#: Instructions of the kernel an angle, and of an operation in a loop, indices and memory included.
_ANGLE_INSTRUCTIONS, _LOOPED = 66, 2.6
#: Bytes of a word of C in a flow, and more where columns of derivatives are carried; the stack of a flow by its coordinates.
_WORD, _COLUMNS, _FLOW_STACK, _COORDINATE_STACK = 0.95, 1.3, 300, 170


@dataclass(frozen=True)
class Cost:
    """At most, on a Cortex-M4F.

    Attributes:
        flash: bytes of code and constants at -Os, the sine-cosine kernel not counted.
        fast_flash: the same at -O2.
        stack: bytes, those of what it calls included.
        instructions: of one call at -Os; None in double precision, whose operations are calls, and for flows.
    """

    flash: int
    fast_flash: int
    stack: int
    instructions: int | None


def cost_of(program: Program, real: str, is_plain: bool = False) -> Cost:
    """Bounds of a Program's function.

    Args:
        program: the function.
        real: its type of numbers.
        is_plain: whether its arrays share cells, as where nothing is written for a host's vectors.
    """
    counts = Counter(_kind(statement) for statement in walk(program.body))
    plain = sum(count for kind, count in counts.items() if kind not in ("sin", "cos"))
    flash = _ENTRY + plain * (_STATEMENT + min(_SPILL, plain / _SPILLS_FROM)) + _ANGLE * (counts["sin"] + counts["cos"]) / 2 + _LOOP * counts["For"]
    flash = ceil(flash * (_DOUBLE if real == "double" else 1))
    return Cost(flash, ceil(flash * _FASTER), _stack(program, real, is_plain), _instructions(program, flash) if real == "float" else None)


def _kind(statement: Statement) -> str:
    return statement.kind if isinstance(statement, Op) else type(statement).__name__


def _angles(program: Program) -> int:
    """Angles whose sine or cosine a call of straight-line code takes."""
    return len({s.args[0] for s in program.body if isinstance(s, Op) and s.kind in ("sin", "cos")})


def _stack(program: Program, real: str, is_plain: bool) -> int:
    number, callees = 8 if real == "double" else 4, [_stack(callee, real, is_plain) for callee in program.callees.values()]
    kinds = {_kind(statement).rstrip("0123456789") for statement in walk(program.body)}
    beyond = max([*callees, _KERNEL_STACK[real] * (2 if "besselj" in kinds else 1) if kinds & {"SinCos", "sin", "cos", "besselj"} else 0])
    if program.is_straight_line:
        own = 48 + 2 * number * _angles(program) + 6 * number // 4 * _most_alive(program)
    else:
        own = 272 + number * (shared_storage if is_plain else own_storage)(program).cells
    return (own + beyond + 7) // 8 * 8


def _most_alive(program: Program) -> int:
    """How many values wait for their last use at once, at most."""
    last = {name: place for place, statement in enumerate(program.body) for name in _read(statement)}
    alive: set[str] = set()
    most = 0
    for place, statement in enumerate(program.body):
        if isinstance(statement, Op) and statement.result in last and statement.kind not in ("sin", "cos"):
            alive.add(statement.result)
        most = max(most, len(alive))
        alive -= {name for name in _read(statement) if last[name] == place}
    return most


def _read(statement: Statement) -> Iterator[str]:
    operands = statement.args if isinstance(statement, Op) else (statement.value,) if isinstance(statement, Store) else ()
    return (operand.name for operand in operands if isinstance(operand, Local))


def _instructions(program: Program, flash: int) -> int:
    if program.is_straight_line:
        return ceil(flash / 3.9 + _ANGLE_INSTRUCTIONS * _angles(program) + 20)
    turned = sum(s.count for s in walk(program.body) if isinstance(s, SinCos))
    turned += sum(sum(s.count for s in walk(callee.body) if isinstance(s, SinCos)) for callee in program.callees.values()) * 4
    return ceil(_LOOPED * total_operations(program) + _ANGLE_INSTRUCTIONS * turned + 60 + 4 * sum(a.size for a in program.outputs))


def costs(printed: Printed) -> dict[str, Cost]:
    """Bounds of every function of a scene by its name, helpers and flows included."""
    real = printed.scene.real
    found = {function.name: cost_of(function.program, real, printed.scene.trig is not None) for function in printed.programs.functions}
    for flow in printed.flows:
        code = re.sub(r"/\*.*?\*/", "", flow.text.definitions, flags=re.DOTALL)
        words, is_wide, is_double = len(re.findall(r"\w+|[^\w\s]", code)), printed.scene.variational, real == "double"
        flash = ceil(words * _WORD * (_DOUBLE if is_double else 1) * (_COLUMNS if is_wide else 1))
        stack = (_FLOW_STACK + _COORDINATE_STACK * printed.scene.nq) * (4 if is_wide else 1) * (2 if is_double else 1)
        found[flow.name] = Cost(flash, ceil(flash * _FASTER), stack, None)
    return found


def kernel_flash(printed: Printed) -> int:
    """Bytes of the sine-cosine kernel at -Os, 0 where nothing wants it."""
    uses = printed.programs.uses.union(*(flow.text.uses for flow in printed.flows))
    return _KERNEL[printed.scene.real][printed.scene.trig] if uses & {"sincos", "sincos_pairs"} else 0


def demand_room(printed: Printed) -> None:
    """Go on only where every function keeps to the scene's limits.

    Raises:
        UnsupportedError: one may not; it is named.
    """
    scene, known = printed.scene, costs(printed)
    hungry = max(known, key=lambda name: known[name].stack)
    if scene.stack_max is not None and known[hungry].stack > scene.stack_max:
        raise UnsupportedError(
            "target.stack_max", scene.stack_max, f"is less than {hungry} may take on a Cortex-M4F, {known[hungry].stack} bytes",
            f"raise it, or leave {hungry} out of want{_other_form(scene.code)}", function=hungry, bytes=known[hungry].stack,
        )  # fmt: skip
    total, large = sum(cost.flash for cost in known.values()) + kernel_flash(printed), max(known, key=lambda name: known[name].flash)
    if scene.flash_max is not None and total > scene.flash_max:
        raise UnsupportedError(
            "target.flash_max", scene.flash_max,
            f"is less than the functions may take on a Cortex-M4F, {total} bytes, of which {large} {known[large].flash}",
            f"raise it, or leave {large} out of want{_other_form(scene.code)}", function=large, bytes=total,
        )  # fmt: skip


def _other_form(code: str) -> str:
    return ', or set code = "loops"' if code != "loops" else ""
