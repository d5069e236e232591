"""What the commands print: aligned columns of plain text that read the same on a terminal and in a pipe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from phichain._version import __version__
from phichain.contract.chain import Sample, always
from phichain.contract.function import Function
from phichain.contract.functions import TABLE
from phichain.errors import PhichainError

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.system import System


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Rows of text with every column but the last as wide as its widest entry."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def functions(scene: Scene | None = None) -> str:
    """The table of the contract: name, arguments, where it is or whether the scene wants it, and what it computes."""
    rows = []
    for row in TABLE:
        reason = row.absence(scene) if scene else None
        where = chains(row) if scene is None else "wanted" if row.name in scene.want else "-" if reason is None else "absent"
        rows.append((row.name, arguments(row), where, f"{reason.problem}; {reason.remedy}" if reason else row.doc))
    return columns(rows)


def arguments(row: Function) -> str:
    """The arguments of a function behind p, in the order of the C, those that not every scene has in brackets."""
    given = row.flow.arguments if row.flow else row.arguments
    names = [(argument.name, argument.present is always) for argument in given if argument.name != "p"]
    *first, last = [(f"{name},", needed) for name, needed in names[:-1]] + names[-1:]
    return " ".join(name if needed else f"[{name}]" for name, needed in [*first, last])


def chains(row: Function) -> str:
    """Which chains have a function: all, planar or spatial, undamped, without dry friction, without rotors."""
    spaces = [space for space in ("planar", "spatial") if row.absence(Sample(space == "planar")) is None]
    if not spaces:
        return "runtime parameters"
    where = "all" if len(spaces) == 2 else spaces[0]
    damped = [row.absence(Sample(space == "planar", damping=(1.0,))) for space in spaces]
    rubbed = [row.absence(Sample(space == "planar", friction=(1.0,))) for space in spaces]
    geared = "planar" in spaces and row.absence(Sample(True, armature=(1.0,)))
    kept = f"{where}, undamped" if any(damped) else f"{where}, without dry friction" if any(rubbed) else where
    return kept + ", without rotors" * bool(geared)


def callables(system: System) -> str:
    """The callables of a System, each with its arguments and what it was made from."""
    rows = []
    for name, call in system.functions.items():
        first = (call.__doc__ or "").strip().partition("\n")[0]
        # A compiled callable's first line reads "f(q, v) -> a, compiled from NAME_f."; others say what they like.
        head, found, source = first.partition(", compiled from ")
        if first:
            rows.append((head, source.rstrip(".")) if found else (name, first))
    return columns(rows)


def versions(names: Iterable[str]) -> Mapping[str, str]:
    """Versions of installed packages by name; "not installed" for the others."""
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str] = {}
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def environment() -> list[tuple[str, str]]:
    """What `phichain info` says: versions, compiler, cache, bundled scenes."""
    import platform

    from phichain.native import default_cache, find_compiler
    from phichain.scene.library import bundled_scenes

    def asked(question: Any) -> str:
        try:
            return str(question())
        except PhichainError as refusal:
            return str(refusal)

    packages = ("numpy", "scipy", "sympy", "mpmath", "jinja2", "typer", "rich", "casadi", "matplotlib")
    return [
        ("phichain", __version__),
        ("python", platform.python_version()),
        *versions(packages).items(),
        ("compiler", asked(lambda: find_compiler().version)),
        ("cache", asked(lambda: default_cache().info())),
        ("scenes", ", ".join(bundled_scenes())),
    ]
