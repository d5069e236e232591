"""Processor in the loop: emitted laws on the emulated M4F beside the emitted plant, against the host and against the records.

Each program closes a loop of 1 kHz or less around the plant's emitted `step` and says, call by call, what was measured, what was
decided and which inputs came out, as the words that the floats are. Host and board must say the same text; and the record that the
C was made of, in double precision, must decide the same from the same measurements and want nearly the same inputs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.targets import HOST, M4F, Target
from phichain import Scene, build, generate_swingup, lqr, swing_up
from phichain.control import Sensors, estimator, gain_table, output_law, regulators
from phichain.files import write_folder
from phichain.laws import GainTable, OutputFeedback, TrajectoryLaw
from phichain.pipeline import generate_controller
from phichain.scratch import folder_texts
from phichain.system import System

Vector = NDArray[np.float64]

_PLANT: Final = Scene(
    "loop", 1, base="cart", cart_mass=0.5, cart_damping=2.0, mass=0.1, length=0.2, damping=2e-3, want=("step",), real="float", trig="bundled",
)  # fmt: skip
_CLOSE: Final = 2e-4
"""How near the inputs in single precision must be to the record's, in shares of their limit."""
_KICK: Final = 8.0
_COUNTS: Final = 4096

_MAIN: Final = """
static void say_float(float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    say_word(word);
    say(" ");
}

int checked(void)
{
    float x[2 * LOOP_NQ] = START, next[2 * LOOP_NQ], y[NY], u[LOOP_NU] = {0};
    STATE state;
    int decided = 0;

    MEASURED;
    RESET;
    for (int k = 0; k < CALLS; ++k) {
        MEASURED;
        CALL;
        say_word((uint32_t)decided);
        say(" ");
        for (int i = 0; i < NY; ++i) {
            say_float(y[i]);
        }
        for (int i = 0; i < LOOP_NU; ++i) {
            say_float(u[i]);
        }
        SAID;
        say("\\n");
        if (k == KICKED) {
            x[LOOP_NQ + 1] += KICK;
        }
        loop_step(SAMPLE, x, x + LOOP_NQ, u, next, next + LOOP_NQ);
        memcpy(x, next, sizeof x);
    }
    return 0;
}
"""
_WHOLE: Final = "memcpy(y, x, sizeof y)"
_ENCODERS: Final = (
    "for (int i = 0; i < NY; ++i) { const float step = i ? 6.2831853F / COUNTS : 1e-4F; "
    "y[i] = step * (float)(int32_t)(x[i] / step + (x[i] < 0.0F ? -0.5F : 0.5F)); }"
).replace("COUNTS", f"{_COUNTS}.0F")
Judged = Callable[[int, int, Vector], tuple[int, Vector]]


@dataclass(frozen=True)
class Loop:
    """One closed loop.

    Attributes:
        kind: What it is, for reports.
        folder: The emitted law; its header, source and functions are called as it.
        law: The record.
        start: Where the plant begins.
        call: C that sets `decided` and `u`, with a place for the name of the function.
        reset: Arguments of the reset before the first call.
        measured: C that sets `y`.
        size: Entries of y.
        calls: How many.
        kicked: After which call the link is pushed; -1 for none.
        judged: (call, decision before, y) -> decision, and by the record what is said behind y.
        said: C that says what belongs behind the inputs.
    """

    kind: str
    folder: Path
    law: OutputFeedback | GainTable | TrajectoryLaw
    start: tuple[float, ...]
    call: str
    reset: str
    measured: str
    size: int
    calls: int
    kicked: int
    judged: Judged
    said: str = "(void)0"

    @property
    def sample(self) -> float:
        """Time between two calls, s."""
        return self.law.catch.sample if isinstance(self.law, TrajectoryLaw) else self.law.sample

    def program(self) -> str:
        """Its main."""
        name = self.folder.name
        words = {
            "STATE": f"{name}_state", "START": "{" + ", ".join(map(_number, self.start)) + "}", "MEASURED": self.measured,
            "RESET": f"{name}_reset({self.reset})", "CALL": self.call.format(name), "CALLS": self.calls, "NY": self.size,
            "SAID": self.said, "KICKED": self.kicked, "KICK": _number(_KICK), "SAMPLE": _number(self.sample),
        }  # fmt: skip
        includes = "".join(f'#include {file}\n' for file in ("<string.h>", '"board.h"', '"loop.h"', f'"{name}.h"'))
        return includes + "".join(f"#define {word} {value}\n" for word, value in words.items()) + _MAIN


def _number(value: float) -> str:
    return f"{float(np.float32(value)).hex()}F"


def loops(folders: Mapping[str, Generated]) -> Iterator[str]:
    """Processor in the loop: observer, supervisor and swing-up decide on the M4F as on the host, to the last bit."""
    root = next(iter(folders.values())).folder.parent / "loops"
    plant = write_folder(root / _PLANT.name, folder_texts(_PLANT, False, False))
    for made in (_balanced(root), _supervised(root), _swung(root)):
        yield from _checked(made, plant)


def _checked(made: Loop, plant: Path) -> Iterator[str]:
    (made.folder / "main.c").write_text(made.program())
    law = made.folder / f"{made.folder.name}.c"
    told = {target.name: _run(target, made, plant, law) for target in (HOST, M4F)}
    if told[M4F.name] != told[HOST.name]:
        lines = zip(told[M4F.name].splitlines(), told[HOST.name].splitlines(), strict=False)
        first = next((k for k, (one, other) in enumerate(lines) if one != other), -1)
        yield f"{made.kind}: board and host differ from call {first} on"
    yield from _judged(made, told[M4F.name])
    # What it would say of another law: a check that nothing fails is none.
    wrong = made.folder / "wrong.c"
    wrong.write_text(_another(law.read_text()))
    if _run(M4F, made, plant, wrong) == told[HOST.name]:
        yield f"{made.kind}: another number in the law is not noticed"


def _run(target: Target, made: Loop, plant: Path, law: Path) -> str:
    sources = [made.folder / "main.c", plant / "loop.c", law]
    program = made.folder / f"{law.stem}_{target.name}.elf"
    return target.run(target.build(sources, program, "-O2", f"-I{plant}", f"-I{made.folder}"))


def _another(text: str) -> str:
    """The text with its largest constant, a gain, changed by a thousandth."""

    def value(found: re.Match[str]) -> float:
        number = found.group()[:-1]
        return float.fromhex(number) if "x" in number else float(number)

    numbers = re.finditer(r"-?(?:0x1\.[0-9a-f]{4,}p[+-]\d+|\d+\.\d{4,}(?:e[+-]\d+)?)F", text)
    # The largest of all say what counts as a number at all.
    at = max((found for found in numbers if abs(value(found)) < 1e6), key=lambda found: abs(value(found)))
    return f"{text[: at.start()]}{_number(value(at) * (1 + 2**-10))}{text[at.end() :]}"


def _judged(made: Loop, told: str) -> Iterator[str]:
    """Decisions and inputs of the record at what the board measured."""
    before, worst, decisions = -1, 0.0, []
    lines, limit = told.splitlines(), float(np.max(made.law.catch.high if isinstance(made.law, TrajectoryLaw) else made.law.high))
    if len(lines) != made.calls:
        yield f"{made.kind}: says {len(lines)} lines of {made.calls}"
        return
    for k, line in enumerate(lines):
        words = [int(word, 16) for word in line.split()]
        decided = int(np.array(words[0], np.uint32).astype(np.int32))
        numbers = np.array(words[1:], np.uint32).view(np.float32).astype(float)
        expected, said = made.judged(k, before, numbers[: made.size])
        if decided != expected:
            yield f"{made.kind}: decides {decided} in call {k}, the record {expected}"
            return
        worst = max(worst, float(np.max(np.abs(numbers[made.size :] - said) / np.maximum(limit, np.abs(said)))))
        before = decided
        decisions.append(decided)
    if worst > _CLOSE:
        yield f"{made.kind}: an input is {worst:.3g} of its limit from the record's"
    wanted = {"observer": 1, "supervisor": 3, "swing-up": 2}[made.kind]
    if len(set(decisions)) < wanted:
        yield f"{made.kind}: nothing was to decide, only {sorted(set(decisions))}"


def _model() -> System:
    return build(replace(_PLANT, real="double", trig=None, want=("forward_dynamics", "linearization")))


def _balanced(root: Path) -> Loop:
    """Upright by a Kalman filter in front of the gains, from encoders."""
    gains = lqr(_model(), [-1], 1.0, 0.1, sample=2e-3)
    law = output_law(gains, estimator(gains), {"x": 1.0}, limit=15.0)
    memory: dict[str, Vector] = {}

    def judged(k: int, _before: int, y: Vector) -> tuple[int, Vector]:
        if not k:
            memory.update(law.reset(y))
        u, following = law.step(memory, y)
        memory.update(following)
        return 0, u

    return Loop(
        "observer", generate_controller(law, root / "observer", "float"), law, (0.02, np.pi + 0.08, 0.0, 0.0), "{}(&state, y, u)",
        "&state, y", _ENCODERS, 2, 1500, 700, judged,
    )  # fmt: skip


def _supervised(root: Path) -> Loop:
    """Held upright, kicked off, let go, and held again where it hangs."""
    table = gain_table(regulators(_model(), sample=2e-3), limit=15.0)

    def judged(k: int, before: int, y: Vector) -> tuple[int, Vector]:
        held, level = table.supervise(before, y)
        return held, np.append(table.inputs(held, y), level)

    return Loop(
        "supervisor", generate_controller(table, root / "supervisor", "float"), table, (0.0, np.pi + 0.01, 0.0, 0.0),
        "decided = {}(&state, y, u)", "&state", _WHOLE, 4, 6000, 300, judged, "say_float(state.level)",
    )  # fmt: skip


def _swung(root: Path) -> Loop:
    """Swung up and held, through an observer along the motion, from encoders."""
    law = swing_up(_model(), limit=15.0, rail=0.6, runs=2, count=1, sensors=Sensors()).law
    memory: list[Vector] = []

    def judged(k: int, _before: int, y: Vector) -> tuple[int, Vector]:
        t = float(np.float32(k) * np.float32(law.catch.sample))
        u, following = law.step(memory.pop() if k else law.reset(y), t, y)
        memory.append(following)
        return int(t >= law.duration), u

    return Loop(
        "swing-up", generate_swingup(law, root / "swingup"), law, (0.0, 0.02, 0.0, 0.0),
        "decided = (int){}(&state, (float)k * SAMPLE, y, u)", "&state, y", _ENCODERS, 2, 3500, -1, judged,
    )  # fmt: skip
