"""How many runs of a swing-up hold, and how long it takes from the description to checked C: ``python -m benchmarks.swing_up 1 2 3 4 5``.

Cart 0.5 kg, point masses of 0.1 kg on rods of 0.2 m, 20 N, rail 1 m to either side and 1.2 m from four links on, the law in single
precision at 1 kHz, starts within 0.05 rad; nothing that was planned before is looked at. Prints one row of docs/swingup.md a chain.
`3e` is the same with encoders of 4096 counts and 0.1 mm, and the emitted observer.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from phichain.trials import SwingUp

ERRORS: Final = {1: 0.1, 2: 0.1, 3: 0.1, 4: 0.05, 5: 0.02, 6: 0.01}


def measured(links: int, encoders: bool = False) -> str:
    """One row: links, size of the errors, share of the runs that hold, bytes of the table, seconds, CPU seconds."""
    from phichain import Scene, build, generate_swingup, swing_up
    from phichain.control import Sensors

    size, since = ERRORS[links], time.perf_counter()
    scene = Scene(f"swing{links}", links, base="cart", cart_mass=0.5, mass=0.1, length=0.2, want=("forward_dynamics", "linearization"))
    with tempfile.TemporaryDirectory() as folder:
        found = swing_up(
            build(scene), limit=20.0, rail=1.0 if links < 4 else 1.2, errors={"mass": size, "cart_mass": size}, jobs=2,
            sensors=Sensors() if encoders else None,
            report=lambda one: print(one, file=sys.stderr, flush=True),
        )  # fmt: skip
        generate_swingup(found.law, folder)
    took, spent = time.perf_counter() - since, os.times()
    cpu = spent.user + spent.system + spent.children_user + spent.children_system
    low, high = found.trials.interval
    calm = f" ({_calm(found):.1%} with rates of 0.05 rad per swing time)" if encoders else ""
    return (
        f"| {links}{', encoders' if encoders else ''} | {size:.0%} | {found.trials.share:.1%} ({low:.1%} to {high:.1%}){calm} | {4 * found.law.numbers} | {took:.0f} | {cpu:.0f} |"
    )


def _calm(found: SwingUp) -> float:
    """Share of the runs that hold and whose rates end as near as their places: within 0.05 rad per swing time, 0.2473 s for three links."""
    trials, catch = found.trials, found.law.catch
    half = trials.ends.shape[1] // 2
    swing = (half - 1) ** 0.5 * (0.2 / 9.81) ** 0.5
    rates = trials.ends[:, half:] - np.array(catch.target)[half:]
    return float(np.mean(trials.held & np.all(np.abs(rates) * swing < 0.05, axis=1)))


def main() -> None:
    """Measure the chains that are named."""
    for word in sys.argv[1:] or ["1", "2", "3", "4", "5"]:
        with tempfile.TemporaryDirectory() as cache:
            os.environ["PHICHAIN_CACHE"] = cache
            print(measured(int(word.rstrip("e")), word.endswith("e")), flush=True)


if __name__ == "__main__":
    main()
