"""Growth with the number of links: operations of the forward dynamics, bytes of code of the loops form.

Operations are as the manifest counts them: + - * / sqrt one each, a fused multiply-add two, sin and cos one
each. The expert's row counts the recursion that CasADi and heyoka run in the same way.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import ours, plan
from benchmarks.building import objects
from benchmarks.chains import Chain, planar_chain, spatial_chain, tip_chain
from benchmarks.peers import present
from benchmarks.table import Table

HEADING = "Growth with the number of links"
SIZES = (2, 4, 8, 16, 32, 64)
LOOPS = 8
"""Links from which the code of the loops form is compared."""
KINDS = {
    "P, with torques": planar_chain,
    "P, unforced": lambda n: planar_chain(n, forced=False),
    "planar, tip masses, unforced": tip_chain,
    "S": spatial_chain,
}


def expert_operations(chain: Chain) -> int:
    """Operations of the expert's recursion, constants folded.

    Raises:
        PeerAbsent: CasADi, which counts them, is not installed.
    """
    ca = present.module("casadi")
    nothing = (ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST, ca.OP_PARAMETER)
    function = present.module("benchmarks.peers.casadi_recursion").expert_function(chain)
    return sum(function.instruction_id(i) not in nothing for i in range(function.n_instructions()))


def ours_at(chain: Chain, code: str) -> tuple[int, int]:
    """Operations and bytes of code of phichain's forward dynamics."""
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        folder = ours.generate(chain, Path(scratch), code)
        return ours.operations(folder), objects.inspect(ours.source(folder), ("-Os",)).text


def tables(run: plan.Plan) -> list[Table]:
    """Operations by size, then the loops form's code by size."""
    sizes = run.few(SIZES, 2)
    operations, code = [], []
    for name, make in run.few([*KINDS.items()]):
        chains = [make(n) for n in sizes]
        operations.append(_row(f"**phichain**, {name}", [ours_at(chain, "unrolled")[0] for chain in chains], sizes))
        try:
            operations.append(_row(f"expert, {name}", [expert_operations(chain) for chain in chains], sizes))
        except present.PeerAbsent as absent:
            operations.append((f"expert, {name}: skipped: {absent}", *("-" for _ in sizes), "-", "-"))
        longer = [make(max(n, LOOPS)) for n in sizes if n >= LOOPS or run.tiny]
        bytes_of = [ours_at(chain, "loops")[1] for chain in longer]
        spread = 100 * (max(bytes_of) / min(bytes_of) - 1)
        code.append((name, *map(str, bytes_of), f"{spread:.1f} %"))
    last = sizes[-1]
    heads = ("operations, N =", *map(str, sizes), f"{last} over {_middle(sizes)}", "per further link")
    loops = [str(n) for n in sizes if n >= LOOPS or run.tiny]
    return [
        Table("Operations of the forward dynamics, straight-line form", heads, tuple(operations)),
        Table("Bytes of code of the loops form, -Os", (".text, N =", *loops, "spread"), tuple(code)),
    ]


def _middle(sizes: Sequence[int]) -> int:
    return LOOPS if LOOPS in sizes else sizes[0]


def _row(label: str, counts: Sequence[int], sizes: Sequence[int]) -> tuple[str, ...]:
    per_link = (counts[-1] - counts[-2]) / (sizes[-1] - sizes[-2])
    return (label, *map(str, counts), f"{counts[-1] / counts[sizes.index(_middle(sizes))]:.2f}", f"{per_link:.1f}")


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("growth", "benchmarks.building.growth", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
