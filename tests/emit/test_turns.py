"""What a turn of a loop keeps at hand on targets: pointers to records, cells read again, registers."""

from __future__ import annotations

import re

import pytest

from phichain.emit.c.turns import cells_read_again, rows
from phichain.ir.builder import Builder
from phichain.ir.nodes import For
from phichain.scene import Scene
from phichain.scratch import folder_texts


def text(**more: object) -> str:
    scene = Scene("own", 6, mass=0.5, length=0.5, com=0.25, want=("forward_dynamics",), code="loops", **more)  # type: ignore[arg-type]
    source = folder_texts(scene, False, False)["own.c"]
    return source[source.index("void own_forward_dynamics") :]


def sweep() -> For:
    """A turn that reads kept[k] twice, kept[k - 1] once, given[k] twice, moved[k] twice and writes moved; so often in a loop within."""
    builder = Builder("sweep", "")
    given, out = builder.input("given", (5,)), builder.output("out", (5,))
    kept, moved = builder.array("kept", 5), builder.array("moved", 5)
    with builder.loop("k", 1, 5) as loop:
        k = loop.index
        moved[k] = kept[k] * given[k] + kept[k - 1] * (given[k] * 3 + kept[k])
        out[k] = moved[k] * moved[k]
        with builder.loop("i", 0, k) as within:
            out[within.index] = kept[within.index] * kept[within.index]
    (found,) = [statement for statement in builder.finish().body if isinstance(statement, For)]
    return found


def test_cells_are_held_that_a_turn_reads_again_and_does_not_write() -> None:
    assert {(cell.array, str(cell.index)) for cell in cells_read_again(sweep(), set())} == {("kept", "k"), ("given", "k")}
    assert {cell.array for cell in cells_read_again(sweep(), {"given"})} == {"kept"}


def test_records_are_found_once_a_turn() -> None:
    """By the loop's own index; those of a loop within are found there, and what is used once is found in place."""
    found = rows(sweep(), {"kept", "moved"}, {"given", "out"}, ())
    assert [(row.array, str(row.start), row.is_written) for row in found.values()] == [("", "k", True)]
    assert rows(sweep(), {"kept", "moved"}, {"given", "out"}, found) == {}
    assert [row.is_written for row in rows(sweep(), {"kept"}, {"given", "moved", "out"}, ()).values()] == [False]


def test_rows_of_arrays_are_found_by_their_first_cell_and_in_no_other_array() -> None:
    """Cells 3 k - 1 to 3 k + 1 by one pointer; one cell a turn by none, nor what a loop within alone uses, which may run no turn."""
    builder = Builder("rows", "")
    given, out, far = builder.input("given", (15,)), builder.output("out", (15,)), builder.array("far", 30)
    with builder.loop("k", 1, 5) as loop:
        k = loop.index
        out[k] = given[3 * k + 1] * given[3 * k - 1]
        with builder.loop("i", 0, k - 1) as within:
            far[5 * k + within.index - 10] = given[3 * k - 3] + far[5 * k + within.index - 9]
    (found,) = [statement for statement in builder.finish().body if isinstance(statement, For)]
    assert [(row.array, str(row.start), row.is_written) for row in rows(found, (), (), ()).values()] == [("given", "3 * k - 1", False)]
    (inner,) = [statement for statement in found.body if isinstance(statement, For)]
    assert [(row.array, str(row.start), row.is_written) for row in rows(inner, (), {"given"}, ()).values()] == [("far", "i + 5 * k - 10", True)]


@pytest.mark.parametrize("trig", ["bundled", "libm"])
def test_loops_on_targets_index_nothing_twice(trig: str) -> None:
    source = text(trig=trig, real="float")
    assert re.search(r"OWN_REGISTER const struct forward_dynamics_link \*const at_\d+ = &link\[k\];", source)
    assert "for (OWN_REGISTER int k" in source and "OWN_REGISTER own_real outer_xx = " in source
    for turn in re.findall(r"\n    for [^\n]*\{\n(.*?)\n    \}", source, re.DOTALL):
        cells = [cell for cell in re.findall(r"(?<![&\w])\w+\[k\](?:\[\d\])?(?! =)", turn)]
        assert len(cells) == len(set(cells)), cells


def test_hosts_keep_their_text() -> None:
    assert "REGISTER" not in text() and "struct" not in text()
