"""Work arrays that share cells: never two that are needed at the same time, as the printed C itself shows."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest

from phichain.emit.c.function import c_function
from phichain.emit.c.names import CNames
from phichain.emit.c.storage import own_storage, shared_storage
from phichain.ir.builder import Builder
from phichain.ir.nodes import Program
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene


@pytest.fixture(scope="module")
def jacobian() -> Program:
    scene = Scene("chain", 5, mass=0.2, length=0.2, com=0.1, actuated="all", real="float", trig="bundled", want=("dynamics_and_jacobian",))
    return lower_function(derive(scene), "dynamics_and_jacobian", "loops")


def parts(lines: tuple[str, ...]) -> list[str]:
    """The outermost statements of a printed body, loops whole; declarations of arrays left out."""
    found: list[str] = []
    for line in lines:
        outermost = line.startswith("    ") and not line.startswith(("     ", "    }"))
        if outermost:
            found.append(line)
        elif found:
            found[-1] += line
    return [part for part in found if not re.match(r"    chain_real \w+\[\d+\];", part)]


def test_arrays_that_share_cells_are_never_needed_at_once(jacobian: Program) -> None:
    """By the C as it is printed where every array has a place of its own."""
    tables = {(name, values): name for name, values in jacobian.tables.items()}
    storage, text = shared_storage(jacobian), parts(c_function(jacobian, CNames("chain", "float", tables), {}).lines)
    assert len(storage.guests) > 10 and storage.cells < 0.75 * own_storage(jacobian).cells
    for place in set(storage.guests.values()):
        tenants = [place, *(name for name, other in storage.guests.items() if other == place)]
        spans = [[k for k, part in enumerate(text) if re.search(rf"\b{name}\b", part)] for name in tenants]
        for before, after in pairwise(spans):
            assert before[-1] < after[0], tenants
        assert max(array.size for array in jacobian.work if array.name in tenants) == storage.sizes[place]


def test_arrays_of_one_length_are_fields_of_records(jacobian: Program) -> None:
    """Each by the names of all that stand there, long enough for all of them; those that sines want whole stay apart."""
    storage = shared_storage(jacobian)
    tables = {(name, values): name for name, values in jacobian.tables.items()}
    text = "\n".join(c_function(jacobian, CNames("chain", "float", tables, is_plain=True), {}).lines)
    assert len(set(storage.fields.values())) > 15 and f"}} link[{storage.extent}];" in text
    assert not {"sine", "cosine"} & set(storage.fields) and re.search(r"sincos\(5, q, sine, cosine\)", text)
    for name, field in storage.fields.items():
        assert name in field.split("_then_") and f"chain_real {field};" in text
        assert storage.sizes[storage.guests.get(name, name)] <= storage.extent
    indices = {int(index) for index in re.findall(r"link\[(\d+)\]\.", text)}
    assert max(indices) < storage.extent


def test_what_is_written_where_it_is_used_is_read_there() -> None:
    """`a` is read by the last statement, after `b` has been written, though the Program reads it before."""
    builder = Builder("late", "Reads late.")
    x, out = builder.input("x", (2,)), builder.output("out", (2,))
    a = builder.array("a", 2)
    with builder.loop("i", 0, 2) as loop:
        a[loop.index] = x[loop.index] * 2
    late = a[0] - a[1]
    b = builder.array("b", 2)
    with builder.loop("j", 0, 2) as loop:
        b[loop.index] = x[loop.index] * 3
    out[0] = late
    with builder.loop("k", 1, 2) as loop:
        out[loop.index] = b[loop.index]
    program = builder.finish()
    assert not shared_storage(program).guests
    lines = c_function(program, CNames("late", "float", {}, is_plain=True), {}).lines
    assert [line for line in lines if "a[0]" in line] == ["    out[0] = a[0] - a[1];"]


def test_an_array_longer_than_most_stays_apart() -> None:
    """One cell more would cost a whole record more."""
    scene = Scene("chain", 6, mass=1 / 6, length=1 / 6, com=1 / 12, actuated="all", real="float", trig="bundled", want=("dynamics_and_jacobian",), code="loops")
    program = lower_function(derive(scene), "dynamics_and_jacobian", "loops")
    storage = shared_storage(program)
    assert storage.extent == 6 and 7 in storage.sizes.values()
    assert storage.cells < 7 * len(set(storage.fields.values()))


def test_sines_in_pairs_take_in_nobody() -> None:
    builder = Builder("served", "Uses sines, then others.")
    x, out = builder.input("x", (2,)), builder.output("out", (2,))
    sine, cosine = builder.sincos(x, 2)
    with builder.loop("i", 0, 2) as loop:
        out[loop.index] = sine[loop.index] * cosine[loop.index]
    later = builder.array("later", 4)
    with builder.loop("j", 0, 4) as loop:
        later[loop.index] = out[0] * 2
    with builder.loop("k", 0, 2) as loop:
        out[loop.index] = later[loop.index]
    program = builder.finish()
    assert shared_storage(program).guests == {"later": "cosine"}
    assert not shared_storage(program, has_pairs=True).guests
