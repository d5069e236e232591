"""Growth with the number of links: operations of the forward dynamics, bytes of code of the loops form.

Operations are as the manifest counts them: + - * / sqrt one each, a fused multiply-add two, sin and cos one
each. The expert's column counts the recursion that CasADi and heyoka run in the same way.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import casadi as ca

from benchmarks import objects, ours, table
from benchmarks.chains import Chain, planar_chain, spatial_chain
from benchmarks.peers import casadi_recursion

SIZES = (2, 4, 8, 16, 32, 64)
_NOT_OPERATIONS = (ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST, ca.OP_PARAMETER)


def _tip_masses(links: int) -> Chain:
    chain = planar_chain(links, forced=False)
    return replace(chain, com=chain.length)


KINDS = {
    "P, with torques": planar_chain,
    "P, unforced": lambda n: planar_chain(n, forced=False),
    "planar, tip masses, unforced": _tip_masses,
    "S": spatial_chain,
}


def expert_operations(chain: Chain) -> int:
    """Operations of the expert's recursion, constants folded."""
    function = casadi_recursion.expert_function(chain)
    return sum(function.instruction_id(i) not in _NOT_OPERATIONS for i in range(function.n_instructions()))


def ours_at(chain: Chain, code: str) -> tuple[int, int]:
    """Operations and bytes of code of phichain's forward dynamics."""
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        folder = ours.generate(chain, Path(scratch), code)
        return ours.operations(folder), objects.inspect(ours.source(folder), ("-Os",)).text


def tables() -> list[table.Table]:
    """Operations by size, then the loops form's code by size."""
    operations, code = [], []
    for name, make in KINDS.items():
        chains = [make(n) for n in SIZES]
        unrolled = [ours_at(chain, "unrolled")[0] for chain in chains]
        expert = [expert_operations(chain) for chain in chains]
        for label, counts in ((f"**phichain**, {name}", unrolled), (f"expert, {name}", expert)):
            per_link = (counts[-1] - counts[-2]) / (SIZES[-1] - SIZES[-2])
            factor = counts[-1] / counts[SIZES.index(8)]
            operations.append((label, *map(str, counts), f"{factor:.2f}", f"{per_link:.1f}"))
        sizes = [ours_at(chain, "loops")[1] for chain in chains[SIZES.index(8) :]]
        spread = 100 * (max(sizes) / min(sizes) - 1)
        code.append((name, *map(str, sizes), f"{spread:.1f} %"))
    heads = ("operations, N =", *map(str, SIZES), "64 over 8", "per further link")
    return [
        table.Table("Operations of the forward dynamics, straight-line form", heads, tuple(operations)),
        table.Table(
            "Bytes of code of the loops form, -Os",
            (".text, N =", "8", "16", "32", "64", "spread"),
            tuple(code),
        ),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--write", action="store_true", help="write benchmarks/results/growth.md")
    options = p.parse_args(arguments)
    found = tables()
    print("\n".join(t.markdown() for t in found))
    if options.write:
        print(
            table.write(
                "growth", "Growth with the number of links", found, "python -m benchmarks.growth --write"
            )
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
