"""A controller and its plant on an emulated Cortex-M4F, from scene and weights to the trace that the board says.

    python examples/firmware/run.py            writes generated/firmware, builds, runs, prints the trace
    python examples/firmware/run.py --check    compares it with trace.txt beside this file

Needs arm-none-eabi-gcc and qemu-system-arm; `make firmware` runs the check.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from phichain import build, generate, load_scene, lqr
from phichain.pipeline import generate_controller

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from benchmarks.firmware.targets import M4F, Target


def trace(out: Path, target: Target = M4F) -> str:
    """Generate plant and controller, build both for a target, and run them."""
    scene = load_scene(HERE / "double.toml")
    plant = generate(scene, out)
    # Gains come from the same chain in double precision; the law is emitted in single precision, held for a millisecond.
    model = build(replace(scene, real="double", trig=None, want=("forward_dynamics", "energy", "linearization", "state_jacobian")))
    gains = lqr(model, np.array([-1.0, -1.0]), 1.0, 0.1, sample=0.001)
    controller = generate_controller(gains.law(limit=15.0), out, real="float")
    sources = [HERE / "main.c", plant / "plant.c", controller / "plant_controller.c"]
    program = target.build(sources, Path(out).resolve() / "firmware.elf", "-O2", f"-I{plant}", f"-I{controller}")
    return target.run(program)


def main(words: list[str]) -> int:
    """Print the trace, or compare it."""
    told = trace(Path("generated") / "firmware")
    if "--check" not in words:
        print(told, end="")
        return 0
    expected = (HERE / "trace.txt").read_text()
    print("the trace is the committed one" if told == expected else "the trace differs from trace.txt")
    return 0 if told == expected else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
