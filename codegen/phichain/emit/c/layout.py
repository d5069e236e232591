"""Long lines of C, broken as by hand: before an operator or after a comma, rather far out than deep inside parentheses."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from textwrap import wrap

#: Longest line of an emitted file.
WIDTH = 110

_INDENT = 4
#: What it costs to break a line: for each level of parentheses, inside a product that is part of a sum, and to leave the
#: line empty.
_LEVEL, _TORN_PRODUCT, _EMPTY = 1.25, 3.0, 5.0


def laid_out_text(text: str) -> str:
    """A whole text with its long lines broken and its long comments filled anew."""
    lines: list[str] = []
    comment: list[str] = []
    of_macro = False  # whether the line goes on with a macro's definition, each of whose lines but the last ends in a backslash
    for line in text.splitlines():
        if of_macro:
            *broken, last = laid_out(line, WIDTH - 2)
            lines += [*(f"{part} \\" for part in broken), last]
        elif comment or line.lstrip().startswith("/*"):
            comment.append(line)
            if "*/" in line:
                lines += _filled(comment)
                comment = []
        elif len(line) > WIDTH and line.endswith("*/"):
            # A remark too long to stand beside what it explains goes above it.
            code, remark = line.split("/*", 1)
            indent = line[: len(line) - len(line.lstrip())]
            lines += [*_filled([f"{indent}/*{remark}"]), code.rstrip()]
        else:
            lines += laid_out(line)
        of_macro = not comment and line.endswith("\\")
    return "".join(f"{line}\n" for line in lines)


def _filled(comment: list[str]) -> list[str]:
    """A comment, its paragraphs filled anew if a line of it is too long; lines set further in are kept."""
    if max(map(len, comment)) <= WIDTH:
        return comment
    indent = comment[0][: len(comment[0]) - len(comment[0].lstrip())]
    ends_alone = comment[-1].strip() == "*/"
    bodies = [re.sub(r"^\s*(/\*|\*(?!/))? ?", "", line) for line in comment[: -1 if ends_alone else None]]
    bodies[-1] = bodies[-1].rstrip().removesuffix("*/").rstrip()
    lines: list[str] = []
    paragraph: list[str] = []
    for body in [*bodies, ""]:
        if body and not body.startswith(" "):
            paragraph.append(body)
            continue
        lines += wrap(" ".join(paragraph), WIDTH - len(indent) - 6, break_on_hyphens=False, break_long_words=False)
        paragraph = []
        lines.append(body)
    lines.pop()
    first, *rest = lines
    text = [f"{indent}/* {first}", *(f"{indent} * {line}".rstrip() for line in rest)]
    return [*text, f"{indent} */"] if ends_alone else [*text[:-1], f"{text[-1]} */"]


def laid_out(text: str, width: int = WIDTH) -> list[str]:
    """A line of C as lines that are not too long; comment lines and what offers no place to break stay whole."""
    if len(text) <= width or text.lstrip().startswith(("/*", "* ", "*/", "#")):
        return [text]
    indent = len(text) - len(text.lstrip())
    lines: list[str] = []
    while len(text) > width:
        at = min(_places(text, width), default=None)
        if at is None:
            break
        lines.append(text[: at[1]].rstrip())
        text = " " * (indent + _INDENT) + text[at[1] :].lstrip()
    return [*lines, text]


def _places(text: str, width: int) -> Iterator[tuple[float, int]]:
    """(cost, position) of every space where the line may be broken, none inside an index."""
    spaces = list(_spaces(text))
    outermost = min((space.depth for space in spaces), default=0)
    sums = {space.group for space in spaces if space.word in ("+", "-")}
    for space in spaces:
        if space.position > width:
            return
        cost = _LEVEL * (space.depth - outermost)
        if space.word == "=":
            cost += _LEVEL
        elif space.word in ("*", "/") and space.group in sums:
            cost += _TORN_PRODUCT
        empty = (width - space.position) / width
        yield cost + _EMPTY * (empty * empty), space.position


@dataclass(frozen=True)
class _Space:
    """A space before an operator or after a comma: where, how deep in which parentheses, and the operator."""

    position: int
    depth: int
    group: int
    word: str


def _spaces(text: str) -> Iterator[_Space]:
    """The spaces of a piece of C at which it may be broken; it may begin inside parentheses."""
    groups, opened = [0], 0
    depth = brackets = 0
    for position in range(len(text) - len(text.lstrip()), len(text)):
        letter = text[position]
        brackets += (letter == "[") - (letter == "]")
        if letter in "({":
            opened, depth = opened + 1, depth + 1
            groups.append(opened)
        elif letter in ")}":
            opened, depth = opened + 1, depth - 1
            groups = groups[:-1] or [opened]
        elif letter == " " and not brackets:
            word = text[position + 1 : text.find(" ", position + 1)]
            if text[position - 1] == "," or word in ("+", "-", "*", "/", "="):
                yield _Space(position, depth, groups[-1], "," if text[position - 1] == "," else word)


def aligned(rows: Iterable[tuple[str, ...]]) -> list[str]:
    """Lines whose words stand below each other."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [" ".join(f"{word:{width}}" for word, width in zip(row, widths, strict=True)).rstrip() for row in table]
