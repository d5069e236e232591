"""What docs/theory.md promises of its parts: one figure and one table of symbols each, symbols that occur, names that exist."""

from __future__ import annotations

import re
import tokenize
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

PAGE: Final = Path("docs", "theory.md")
HEAD: Final = ("symbol", "meaning", "shape", "unit", "in the code")
"""Columns of a table of symbols."""
_HEADING: Final = re.compile(r"^#{2,3} (.+)$", re.MULTILINE)
_FIGURE: Final = re.compile(r"^!\[[^\]]+\]\((img/theory/[\w-]+\.svg)\)$", re.MULTILINE)
_TABLE: Final = re.compile(r"^Symbols, and their names in ((?:`[^`\n]+`(?:, )?)+):\n\n((?:\|.*\|\n)+)", re.MULTILINE)
_FORMULA: Final = re.compile(r"\$\$(.+?)\$\$|\$(.+?)\$", re.DOTALL)
_TOKEN: Final = re.compile(r"\\[A-Za-z]+|\\.|[^\s]")
_SPACES: Final = frozenset({r"\,", r"\;", r"\!", r"\ ", r"\big", r"\Big", r"\left", r"\right", r"\bigl", r"\bigr", "&"})


@dataclass(frozen=True)
class Symbol:
    """One row of a table.

    Attributes:
        written: The symbols, as TeX.
        cells: What stands beside them: meaning, shape, unit.
        names: What the code calls them; none where it has no name for them.
    """

    written: tuple[str, ...]
    cells: tuple[str, ...]
    names: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """What stands between two headings.

    Attributes:
        title: The heading.
        text: All of it.
        prose: Without its table.
        figures: Addresses of its figures.
        files: Where the names of its table are, one tuple a table.
        symbols: The rows of its tables.
    """

    title: str
    text: str
    prose: str
    figures: tuple[str, ...]
    files: tuple[tuple[str, ...], ...]
    symbols: tuple[Symbol, ...]


def parts(text: str) -> list[Part]:
    """The parts of the page that have prose, in order."""
    headings = list(_HEADING.finditer(text))
    found = []
    for heading, following in zip(headings, [*headings[1:], None], strict=True):
        body = text[heading.end() : following.start() if following else len(text)]
        if body.strip():
            found.append(_part(heading[1], body))
    return found


def _part(title: str, body: str) -> Part:
    tables = list(_TABLE.finditer(body))
    rows = [row for table in tables for row in table[2].strip().splitlines()[2:]]
    files = tuple(tuple(re.findall(r"`([^`]+)`", table[1])) for table in tables)
    return Part(title, body, _TABLE.sub("", body), tuple(_FIGURE.findall(body)), files, tuple(map(_symbol, rows)))


def _symbol(row: str) -> Symbol:
    cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip().strip("|"))]
    first, *between, last = cells
    return Symbol(tuple(a or b for a, b in _FORMULA.findall(first)), tuple(between), tuple(re.findall(r"`([^`]+)`", last)))


def tokens(tex: str) -> list[str]:
    """A formula as TeX reads it, without what is only space."""
    return [token for token in _TOKEN.findall(tex) if token not in _SPACES]


def _occurs(symbol: list[str], formula: list[str]) -> bool:
    return any(formula[k : k + len(symbol)] == symbol for k in range(len(formula) - len(symbol) + 1))


@cache
def names_of(path: Path) -> frozenset[str]:
    """Every name of a source file: identifiers, and words of strings that are no docstrings; of C every word outside comments."""
    text = path.read_text()
    if path.suffix != ".py":
        return frozenset(re.findall(r"\w+", re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)))
    found: set[str] = set()
    with path.open("rb") as file:
        for token in tokenize.tokenize(file.readline):
            if token.type == tokenize.NAME:
                found.add(token.string)
            elif token.type == tokenize.STRING and not token.string.endswith('"""') or token.type == getattr(tokenize, "FSTRING_MIDDLE", -1):
                found.update(re.findall(r"\w+", token.string))
    return frozenset(found)


def source(root: Path, name: str) -> Path:
    """The file of the package, or of the repository, that a page calls so."""
    path = root / "codegen" / "phichain" / name
    return path if path.is_file() else root / name


def faults(root: Path, text: str | None = None) -> list[str]:
    """What is missing or wrong, one line each.

    Args:
        root: The repository.
        text: The page, its own by default.
    """
    return [f"{PAGE}: {part.title}: {problem}" for part in parts((root / PAGE).read_text() if text is None else text) for problem in _wrong(root, part)]


def _wrong(root: Path, part: Part) -> list[str]:
    found = [] if len(part.figures) == 1 else [f"has {len(part.figures)} figures, not one"]
    found += [f"there is no {address}" for address in part.figures if not (root / "docs" / address).is_file()]
    found += [] if len(part.files) == 1 and part.symbols else [f"has {len(part.files)} tables of symbols, not one"]
    paths = [source(root, name) for names in part.files for name in names]
    found += [f"there is no file {path.relative_to(root)}" for path in paths if not path.is_file()]
    formulas = [tokens(a or b) for a, b in _FORMULA.findall(part.prose)]
    known = frozenset[str]().union(*(names_of(path) for path in paths if path.is_file()))
    for symbol in part.symbols:
        if len(symbol.cells) != len(HEAD) - 2 or not all(symbol.cells) or not symbol.written:
            found.append(f"the row of {symbol.written} is not {', '.join(HEAD)}")
        found += [f"${written}$ does not occur" for written in symbol.written if not any(_occurs(tokens(written), formula) for formula in formulas)]
        found += [f"no file that it names has the name {name}" for name in symbol.names if name not in known]
    return found
