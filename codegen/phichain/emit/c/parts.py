"""What the printer of C functions asks of a Program and of a statement: names that are taken, where results begin, `+=`."""

from __future__ import annotations

from collections.abc import Iterator

from phichain.ir.nodes import Array, For, Op, Program, Statement, Store, walk


def names_in(program: Program) -> set[str]:
    """Everything a function calls something by."""
    arrays = (*program.params, *program.inputs, *program.outputs, *program.work)
    named = {array.name for array in arrays} | {"p"}
    for statement in walk(program.body):
        match statement:
            case Op(result=result):
                named.add(result)
            case For(variable=variable, carries=carries):
                named |= {variable, *(carry.name for carry in carries)}
            case _:
                pass
    return named


def first_result(program: Program) -> Statement | None:
    """The first of the stores that close straight-line code, where they are all that it has."""
    stores = [statement for statement in program.body if isinstance(statement, Store)]
    return stores[0] if stores and program.body[-len(stores)] is stores[0] else None


def assignment(name: str, text: str) -> str:
    """``name = text;``, or ``name += rest;`` where the text is the name and one more term, so that no sum is reordered."""
    for operator in ("+", "-"):
        start = f"{name} {operator} "
        if text.startswith(start) and not _has_terms(text.removeprefix(start)):
            return f"{name} {operator}= {text.removeprefix(start)};"
    return f"{name} = {text};"


def in_pieces(prefix: str, array: str, texts: list[str], widths: tuple[int, ...] = (4, 2, 1)) -> Iterator[tuple[str, frozenset[str]]]:
    """Statements that fill an array in pieces as wide as those it is read in, such as four, two or one, and the kernel of each."""
    start = 0
    for width in widths:
        while len(texts) - start >= width:
            target, values = f"&{array}[{start}]" if start else array, ", ".join(texts[start : start + width])
            if width == 1:
                yield f"{array}[{start}] = {values};", frozenset()
            else:
                yield f"{prefix}_write_{width}({target}, {values});", frozenset({f"write_{width}"})
            start += width


def _has_terms(text: str) -> bool:
    """Whether a sum stands outside all brackets."""
    depth = 0
    for position, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0 and text.startswith((" + ", " - "), position):
            return True
    return False


def words(text: str) -> set[str]:
    """The identifiers in a piece of C."""
    cleaned = "".join(c if c.isalnum() or c == "_" else " " for c in text)
    return set(cleaned.split())


def declaration(array: Array, prefix: str, is_output: bool, definition: bool) -> str:
    """How an argument is declared: scalars by value or pointer, arrays with their extent."""
    if array.shape == () and not is_output:
        return f"{'const ' if definition else ''}{prefix}_real {array.name}"
    if array.shape == ():
        return f"{prefix}_real *{array.name}"
    restrict = f"{prefix.upper()}_RESTRICT " if definition and is_output else ""
    return f"{'' if is_output else 'const '}{prefix}_real {array.name}[{restrict}{array.size}]"
