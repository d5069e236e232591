"""Long lines of C, broken as a careful engineer breaks them: before an operator or after a comma, as far out as possible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

#: Longest line of an emitted file.
WIDTH = 110

_INDENT = 4
#: Operators before which a line may be broken: the looser one binds, the better.
_TIGHTNESS = {"+": 1, "-": 1, "*": 2, "/": 2, "=": 3}


def laid_out(text: str) -> list[str]:
    """A line of C as lines that are not too long; comment lines and what offers no place to break stay whole."""
    if len(text) <= WIDTH or text.lstrip().startswith(("/*", "*", "#")):
        return [text]
    indent = len(text) - len(text.lstrip())
    lines, depth = [], 0
    while len(text) > WIDTH:
        place = min(_places(text, depth), default=None)
        if place is None:
            break
        at, depth = -place[2], place[0]
        lines.append(text[:at].rstrip())
        text = " " * (indent + _INDENT * (1 + depth)) + text[at:].lstrip()
    return [*lines, text]


def listed(head: str, items: Iterable[str], tail: str) -> str:
    """``head item, item, ... tail`` over as many lines as it takes; continuation lines are indented once."""
    lines, line = [], head
    items = list(items)
    for position, item in enumerate(items):
        piece = item + ("," if position + 1 < len(items) else tail)
        gap = " " if position and line.strip() else ""
        if len(line) + len(gap) + len(piece) > WIDTH and line.strip():
            lines.append(line.rstrip())
            line, gap = " " * _INDENT, ""
        line += gap + piece
    return "\n".join([*lines, line])


def _places(text: str, depth: int) -> Iterator[tuple[int, int, int]]:
    """(depth, tightness, -position) of every space where the line may be broken, none inside an index."""
    brackets = 0
    for position in range(len(text) - len(text.lstrip()), WIDTH + 1):
        letter = text[position]
        depth += (letter in "({") - (letter in ")}")
        brackets += (letter == "[") - (letter == "]")
        if letter != " " or brackets:
            continue
        word = text[position + 1 : text.find(" ", position + 1)]
        if text[position - 1] == ",":
            yield depth, 0, -position
        elif word in _TIGHTNESS:
            yield depth, _TIGHTNESS[word], -position
