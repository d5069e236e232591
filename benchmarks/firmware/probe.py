"""The program that a target runs: the self-test, then functions at many states, with the bits, instructions and stack of each."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, Final

#: States of one function.
STATES: Final = 1000
#: Arguments that lie elsewhere than within +-pi: bounds by name.
_WITHIN: Final = {"v": 4.0, "u": 2.0, "a": 4.0, "h": 0.001, "omega": 4.0, "amplitude": 2.0, "p": 1.0}
_HEAD: Final = """\
#include "{name}.h"
#include "board.h"
#include <string.h>

int {name}_selftest(void);

static uint32_t seed, least, most, bits;
#define real {name}_real

/* A number of the sequence: 23 random bits over +-reach, the same on every processor. */
static real drawn(real reach)
{{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return (real)((int32_t)(seed >> 9) - 4194304) * (reach / (real)4194304);
}}

static void fill(real *array, int count, real reach)
{{
    for (int i = 0; i < count; ++i) {{
        array[i] = drawn(reach);
    }}
}}

static void take_in(const void *result, uint32_t count)
{{
    const unsigned char *bytes = result;
    for (uint32_t i = 0; i < count; ++i) {{
        bits = (bits ^ bytes[i]) * 16777619u;
    }}
}}

static void timed(uint32_t from, uint32_t to)
{{
    const uint32_t taken = (to - from) & 0xFFFFFFu; /* as many bits as a system tick has */
    least = taken < least ? taken : least;
    most = taken > most ? taken : most;
}}

static void begin(void)
{{
    seed = 2463534242u;
    least = 0xFFFFFFFFu;
    most = 0;
    bits = 2166136261u;
}}

static void told(const char *what, uint32_t stack)
{{
    say(what);
    say(" ");
    say_word(bits);
    say(" ");
    say_word(least);
    say(" ");
    say_word(most);
    say(" ");
    say_word(stack);
    say("\\n");
}}

static void nothing(void)
{{
    begin();
    for (int k = 0; k < 10; ++k) {{
        const uint32_t from = ticks();
        __asm__ volatile("" ::: "memory");
        timed(from, ticks());
    }}
    told("nothing", 0);
}}
"""
_FUNCTION: Final = """
static void at_states_{function}(void)
{{
{arrays}
    uint32_t stack = 0;
    begin();
    for (int k = 0; k < {states}; ++k) {{
{fills}
        if (k == 0) {{
            paint_stack();
        }}
        const uint32_t from = ticks();
        {name}_{function}({call});
        const uint32_t to = ticks();
        if (k == 0) {{
            stack = stack_used();
        }}
        timed(from, to);
{takes}
    }}
    told("{function}", stack);
}}
"""
_FLOW: Final = """
/* Ordinary motions: 1 s from anywhere, slowly. How each ends is said in place of instructions. */
static void motions_{function}(void)
{{
    static {name}_{workspace} work;
    uint32_t stack = 0;
    begin();
    for (int k = 0; k < {runs}; ++k) {{
        {name}_{struct} flow;
        real q[{nq}], v[{nv}];
        memset(&flow, 0, sizeof flow);
        flow.work = &work;
        flow.tolerance = k % 2 == 0 ? (real)1e-3 : (real)1e-6;
        fill(q, {nq}, (real)3.125);
        fill(v, {nv}, (real)0.5);
        if (k == 0) {{
            paint_stack();
        }}
        const int result = {name}_{function}(&flow, (real)1, 100000, {forcing}q, v, {event}0, 0, 0, 0);
        if (k == 0) {{
            stack = stack_used();
        }}
        timed(0, (uint32_t)result);
        take_in(q, sizeof q);
        take_in(v, sizeof v);
    }}
    told("{function}", stack);
}}
"""
#: Flows that the probe runs on chains without inputs and runtime parameters: their structs, and whether they take an event.
_FLOWS: Final = {"propagate": ("workspace", "flow", "0, "), "propagate_stiff": ("stiff_workspace", "stiff", "")}
#: Motions of a flow.
RUNS: Final = 8
_TAIL: Final = """
int checked(void)
{{
    const int failed = {selftest};
    say("selftest ");
    say_word((uint32_t)failed);
    say("\\nreal {real}\\n");
    nothing();
{calls}
    return failed;
}}
"""


@dataclass(frozen=True)
class Seen:
    """What a target told of one function.

    Attributes:
        bits: a hash of every bit of its results.
        least, most: instructions of a call.
        stack: bytes of stack it used.
        ending: of a flow, the largest of the numbers that say how its motions ended; 0 where all are done.
    """

    bits: str
    least: int
    most: int
    stack: int
    ending: int = 0


def probe(folder: Path, functions: tuple[str, ...] | None = None, selftest: bool = True) -> Path:
    """Write probe.c for a generated folder: those of its functions, or all, without runtime parameters."""
    manifest = json.loads((folder / "manifest.json").read_text())
    name, known = manifest["name"], manifest["functions"]
    chosen = [one for one in known if functions is None or one in functions]
    text = _HEAD.format(name=name)
    text += "".join(_function(name, one, known[one]) for one in chosen)
    flows = [one for one in manifest.get("flows", {}) if one in _FLOWS and functions is None]
    for one in flows:
        workspace, struct, event = _FLOWS[one]
        forcing = "(real)0.5, (real)3, " if "amplitude" in _prototype(folder / f"{name}.h", f"{name}_{one}") else ""
        text += _FLOW.format(name=name, function=one, workspace=workspace, struct=struct, event=event, runs=RUNS, forcing=forcing, nq=f"{name.upper()}_NQ", nv=f"{name.upper()}_NV")
    calls = "\n".join([*(f"    at_states_{one}();" for one in chosen), *(f"    motions_{one}();" for one in flows)])
    text += _TAIL.format(calls=calls, real=manifest["real"], selftest=f"{name}_selftest()" if selftest else "0")
    path = folder / "probe.c"
    path.write_text(text)
    return path


def _prototype(header: Path, symbol: str) -> str:
    """The arguments that a header declares."""
    return header.read_text().split(f"int {symbol}(", 1)[1].split(");", 1)[0]


def _function(name: str, function: str, row: dict[str, Any]) -> str:
    assert not row["params"], "the probe knows no runtime parameters"
    arrays, fills, takes, call = [], [], [], []
    for array in row["inputs"]:
        size, own = prod(array["shape"]), array["name"]
        arrays.append(f"    real {own}[{size}];")
        fills.append(f"        fill({own}, {size}, (real){_WITHIN.get(own, 3.125)});")
        call.append(own if array["shape"] else f"{own}[0]")
    for array in row["outputs"]:
        size, own = prod(array["shape"]), array["name"]
        arrays.append(f"    real {own}[{size}];")
        takes.append(f"        take_in({own}, sizeof {own});")
        call.append(own)
    return _FUNCTION.format(
        name=name, function=function, arrays="\n".join(arrays), states=STATES, fills="\n".join(fills), call=", ".join(call),
        takes="\n".join(takes),
    )  # fmt: skip


def read(told: str, ticks: float) -> dict[str, Seen]:
    """What a probe said, by function; instructions less those of reading the clock."""
    rows = {words[0]: words[1:] for words in map(str.split, told.splitlines()) if len(words) == 5}
    idle = int(rows.pop("nothing")[1], 16)

    def instructions(word: str) -> int:
        return round((int(word, 16) - idle) / ticks) if ticks else 0

    return {
        name: Seen(bits, 0, 0, int(stack, 16), int(most, 16)) if name in _FLOWS else Seen(bits, instructions(least), instructions(most), int(stack, 16))
        for name, (bits, least, most, stack) in rows.items()
    }


def failing_case(told: str) -> int:
    """The number of the failing case of the self-test; 0 where all passed."""
    return int(next(line.split()[1] for line in told.splitlines() if line.startswith("selftest")), 16)
