"""Leaving out, measured: operations, bytes of code and exported symbols of full scenes against pruned ones.

The full scenes hold everything their space can carry: cart, masses inside the links, joint laws, every
parameter open until run time, every function. The others are what people ask for. Then the same small chain
with each key of a rig and without.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks import plan, table
from benchmarks.building import keys
from benchmarks.building.measured import SMALL, Measured, measure

HEADING = "Leaving out"
ROOT = Path(__file__).resolve().parents[2]
SCENES = {
    "planar4_full": (
        "planar4_full",
        "planar4_no_phi",
        "paper_a_4",
        "planar4_damped_springs",
        "planar4_forward_only",
        "planar4_tip_masses_forward_only",
    ),
    "spatial4_full": (
        "spatial4_full",
        "paper_b",
        "spatial5_cart_forward_only",
        "spatial4_fixed_forward_only",
    ),
}


def committed(name: str) -> Measured:
    """A committed scene, measured."""
    from phichain import load_scene

    return measure(load_scene(ROOT / "scenes" / f"{name}.toml"))


def tables(run: plan.Plan) -> list[table.Table]:
    """One table of sizes, one of names, and what each key costs."""
    rows, names = [], []
    for full, scenes in run.few([*SCENES.items()]):
        yardstick = committed(full)
        for scene in run.few(scenes):
            found = yardstick if scene == full else committed(scene)
            operations = sum(found.operations.values())
            rows.append(
                (
                    f"**{found.name}**" if scene == full else found.name,
                    str(len(found.operations)),
                    str(operations),
                    str(found.text),
                    str(len(found.symbols)),
                    f"{100 * operations / sum(yardstick.operations.values()):.1f} %",
                    f"{100 * found.text / yardstick.text:.1f} %",
                )
            )
            names.append((found.name, ", ".join(found.symbols)))
    heads = (
        "scene",
        "functions",
        "operations",
        ".text bytes",
        "symbols",
        "operations of full",
        ".text of full",
    )
    notes = (
        "Operations are summed over the scene's functions as the manifest counts them; code is compiled by"
        + f" itself with `{' '.join(SMALL)}`; a bold row is the yardstick of the rows below it.",
    )
    return [
        table.Table("Sizes", heads, tuple(rows), notes),
        table.Table("Exported symbols", ("scene", "symbols"), tuple(names)),
        *keys.tables(run),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("leaving_out", "benchmarks.building.leaving_out", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
