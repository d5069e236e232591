"""Theory, part by part: one figure and one table of symbols, symbols that occur, names that the code has; figures as they are drawn."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import pytest

from docs.figures import table
from docs.site import theory

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / theory.PAGE).read_text()
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


def test_every_part_has_its_figure_and_its_symbols() -> None:
    assert theory.faults(ROOT) == []
    found = theory.parts(TEXT)
    sections = re.findall(r"^## \d+\. ", TEXT, re.MULTILINE)
    assert len(sections) == 13 and len(found) >= 26 and all(len(part.symbols) >= 4 for part in found)
    assert {Path(address).stem for part in found for address in part.figures} == set(table.figures())


def test_what_is_wrong_with_a_part_is_told() -> None:
    part = next(part for part in theory.parts(TEXT) if part.title.startswith("From both ends"))
    figure, symbol = f"![{part.text.split('![', 1)[1].split(')', 1)[0]})", f"${part.symbols[0].written[0]}$"
    name = next(name for row in part.symbols for name in row.names)
    changes = {
        (figure, ""): "has 0 figures",
        ("Symbols, and their names in", "Symbols in"): "has 0 tables of symbols",
        (f"| {symbol}", r"| $\Xi_0$"): r"$\Xi_0$ does not occur",
        (f"`{name}`", "`nobody`"): "has the name nobody",
        (part.figures[0], "img/theory/nothing.svg"): "there is no img/theory/nothing.svg",
        (f"`{part.files[0][0]}`", "`lowering/nowhere.py`"): "there is no file lowering/nowhere.py",
        (" 2 x 2 ", "  "): "is not symbol, meaning",
    }
    for (old, new), said in changes.items():
        assert old in part.text, old
        problems = theory.faults(ROOT, TEXT.replace(part.text, part.text.replace(old, new, 1)))
        assert problems and said in " ".join(problems), (old, problems)


def test_a_symbol_is_found_as_a_whole() -> None:
    assert theory.tokens(r"\Delta f\,_k") == [r"\Delta", "f", "_", "k"]
    assert not theory._occurs(theory.tokens("D"), theory.tokens(r"\Delta + \dot q"))
    assert theory._occurs(theory.tokens(r"\dot q_k"), theory.tokens(r"a \cdot \dot  q_k"))
    names = theory.names_of(ROOT / "codegen/phichain/lowering/tensions.py")
    assert "base_load" in names and "twisted" not in names  # a word of the docstring alone


@pytest.mark.parametrize("name", sorted(table.figures()))
def test_a_committed_figure_is_what_is_drawn(name: str) -> None:
    drawn, kept = table.written(table.figures()[name]).decode(), (table.FOLDER / f"{name}.svg").read_text()
    assert _labels(drawn) == _labels(kept) and len(kept) < 120_000
    if f"Matplotlib {matplotlib.__version__}" in kept:  # another version may shape outlines in its own way
        assert _NUMBER.sub("#", drawn) == _NUMBER.sub("#", kept)
        apart = max(abs(float(a) - float(b)) for a, b in zip(_NUMBER.findall(drawn), _NUMBER.findall(kept), strict=True))
        assert apart < 0.01


def test_a_figure_is_drawn_in_the_same_bytes_each_time_and_has_no_date() -> None:
    draw = table.figures()["harmonic-balance"]
    assert table.written(draw) == table.written(draw)
    assert b"<dc:date>" not in table.written(draw) and b"matplotlib.org" not in table.written(draw)


def _labels(text: str) -> list[str]:
    """Words and formulas, which Matplotlib leaves as comments beside their outlines."""
    return re.findall(r"<!-- (.*?) -->", text, re.DOTALL)
