"""Makes benchmarks/flows/references.json: where the motions end, from 80-bit arithmetic, checked by another formulation.

    python -m benchmarks.flows.make_references

heyoka's Taylor method at 1e-18; where a chain has two formulations, both, and their largest difference is written down.
Double round-off is 2000 times larger than the arithmetic's own.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np

from benchmarks.flows.cases import FILE, motions
from benchmarks.peers import present


def main() -> int:
    flows = present.module("benchmarks.peers.heyoka.flows")
    ends, checks = {}, {}
    for motion in motions():
        begin = time.perf_counter()
        q, v = motion.starts()
        by_form = [
            [flows.extended(motion.chain, form, a, b, motion.span) for a, b in zip(q, v, strict=True)]
            for form in motion.forms
        ]
        ends[motion.name] = by_form[0]
        values = np.array(by_form, dtype=float)
        checks[motion.name] = float(np.max(np.abs(values[0] - values[-1]))) if len(motion.forms) > 1 else None
        print(f"{motion.name}: {checks[motion.name]}, {time.perf_counter() - begin:.0f} s", flush=True)
    FILE.write_text(json.dumps({"made": __doc__.split("\n\n")[2].replace("\n", " "), "crosscheck": checks, "ends": ends}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
