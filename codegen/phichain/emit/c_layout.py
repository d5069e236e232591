"""Long lines of C, broken as by hand: before an operator or after a comma, rather far out than deep inside parentheses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

#: Longest line of an emitted file.
WIDTH = 110

_INDENT = 4
#: Operators before which a line may be broken: the looser one binds, the better.
_TIGHTNESS = {"+": 0.0, "-": 0.0, "=": 1.0, "*": 3.0, "/": 3.0}
#: What an empty line would cost, in levels of parentheses.
_FULL = 6.0


def laid_out_text(text: str) -> str:
    """A whole text with its long lines broken."""
    return "".join(f"{line}\n" for whole in text.splitlines() for line in laid_out(whole))


def laid_out(text: str) -> list[str]:
    """A line of C as lines that are not too long; comment lines and what offers no place to break stay whole."""
    if len(text) <= WIDTH or text.lstrip().startswith(("/*", "*", "#")):
        return [text]
    indent = len(text) - len(text.lstrip())
    lines: list[str] = []
    depth = 0
    while len(text) > WIDTH:
        place = min(_places(text, depth), default=None)
        if place is None:
            break
        _, at, depth = place
        lines.append(text[:at].rstrip())
        text = " " * (indent + _INDENT) + text[at:].lstrip()
    return [*lines, text]


def _places(text: str, depth: int) -> Iterator[tuple[float, int, int]]:
    """(cost, position, depth) of every space where the line may be broken, none inside an index."""
    brackets = 0
    for position in range(len(text) - len(text.lstrip()), WIDTH + 1):
        letter = text[position]
        depth += (letter in "({") - (letter in ")}")
        brackets += (letter == "[") - (letter == "]")
        word = text[position + 1 : text.find(" ", position + 1)]
        is_comma = text[position - 1] == ","
        if letter == " " and not brackets and (is_comma or word in _TIGHTNESS):
            room = (WIDTH - position) / WIDTH
            yield depth + (0 if is_comma else _TIGHTNESS[word]) + _FULL * room, position, depth


def aligned(rows: Iterable[tuple[str, ...]]) -> list[str]:
    """Lines whose words stand below each other."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [" ".join(f"{word:{width}}" for word, width in zip(row, widths, strict=True)).rstrip() for row in table]
