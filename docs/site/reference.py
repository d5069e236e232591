"""The reference pages, made from what the code itself reads: the keys' table, the contract's table, the commands, the docstrings."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout

NAMES = ("scene.md", "functions.md", "command.md", "api.md")

PACKAGES = (
    "phichain", "phichain.scene", "phichain.rigs", "phichain.motion", "phichain.continuation", "phichain.orbits", "phichain.control",
    "phichain.laws", "phichain.identification", "phichain.fractional", "phichain.studies", "phichain.system", "phichain.errors",
)  # fmt: skip
"""Packages whose public names have a reference."""


def pages() -> dict[str, str]:
    """The pages by file name."""
    return {"scene.md": scene(), "functions.md": functions(), "command.md": command(), "api.md": api()}


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown; bars within cells are escaped."""
    cells = [list(map(_cell, row)) for row in rows]
    lines = ["| " + " | ".join(row) + " |" for row in (list(head), ["---"] * len(head), *cells)]
    return "\n".join(lines)


def _cell(text: str) -> str:
    return text.replace("|", r"\|").replace("*", r"\*").replace("<", r"\<") or " "


def scene() -> str:
    """Every key of a scene file."""
    from phichain.scene.described import BY_NAME
    from phichain.scene.keys import REQUIRED, TABLES

    def rows(names: Iterable[str]) -> list[list[str]]:
        found = []
        for key in (BY_NAME[name] for name in names):
            only = "".join(f'; with {name} = "{word}" only' for name, word in key.only)
            default = "must be given" if key.name in REQUIRED else key.default or f"none{'; needed with a cart' * (key.name == 'cart_mass')}"
            found.append([f"`{key.name}`", key.text + only, key.holds, key.unit, default, key.since])
        return found

    head = ("key", "what it is", "what it holds", "unit", "unless given", "since")
    text = (
        "One TOML file says which chain, and which functions of it are wanted. `phichain schema` prints a JSON Schema of it, by which "
        "editors complete keys and mark slips: in VS Code with Even Better TOML, `#:schema ./scene.schema.json` as the first line. Units are the "
        "user's, as long as they are consistent; here they are SI."
    )
    parts = ["# The scene file", text, table(head, rows(["name"]))]
    for name, keys in TABLES.items():
        parts += [f"## `[{name}]`", table(head, rows(keys))]
    parts += ["## Scenes that come along", _bundled()]
    return "\n\n".join(parts) + "\n"


def _bundled() -> str:
    from phichain.scene.library import bundled_scenes
    from phichain.scene.load import load_scene

    rows = []
    for name, path in bundled_scenes().items():
        found = load_scene(path)
        comment = " ".join(line.lstrip("# ") for line in path.read_text().splitlines() if line.startswith("#"))
        rows.append([f"`{name}`", f"{found.links} links, {found.space}, {found.base}", comment])
    return table(("name", "chain", "what it is"), rows)


def functions() -> str:
    """Every function of the contract, with its arguments."""
    from phichain.app.console import chains
    from phichain.contract.chain import worded
    from phichain.contract.functions import TABLE
    from phichain.scene.scene import Scene

    kinds = [Scene("shown", 2, space, mass="runtime", length=1.0, actuated=pushed) for space, pushed in (("planar", "all"), ("spatial", "none"))]
    parts = ["# Functions that a scene can want", "From the table by which they are generated; [docs/functions.md](../docs/functions.md) says what they are for."]
    parts.append(table(("function", "computes", "chains"), [[f"[`{row.name}`](#{row.name})", row.doc, chains(row)] for row in TABLE]))
    for row in TABLE:
        parts += [f"({row.name})=\n## `{row.name}`", row.doc]
        if row.on_request:
            parts.append(f"Asked for by name: {row.on_request}.")
        kind = next(kind for kind in kinds if row.absence(kind) is None)
        given = row.flow.arguments if row.flow else row.arguments
        rows = [[f"`{argument.name}`", getattr(argument, "direction", "in"), worded(getattr(argument, "meaning", "") or getattr(argument, "doc", ""), kind)] for argument in given]
        parts.append(table(("argument", "direction", "meaning"), rows))
        parts += [f"- Some chains have none: it {absence.problem}. Remedy: {absence.remedy}." for absence in row.absent]
    return "\n\n".join(parts) + "\n"


def command() -> str:
    """What every command says of itself."""
    import typer

    from phichain.app.cli import app

    group = typer.main.get_command(app)
    context = typer.Context(group, info_name="phichain")
    parts = ["# The command `phichain`"]
    parts.append("Exit status: 0 done; 2 refused, with one line that says why; 3 a run ended before its end or some tasks of a study failed; 130 ended by Ctrl-C, what there is kept.")
    for name in group.list_commands(context):  # type: ignore[attr-defined]
        one = group.get_command(context, name)  # type: ignore[attr-defined]
        rows = []
        for parameter in one.params:
            words = ", ".join(f"`{word}`" for word in (*parameter.opts, *parameter.secondary_opts)) if parameter.param_type_name == "option" else f"`{parameter.metavar or parameter.name}`"
            default = "" if parameter.default in (None, False, ()) or callable(parameter.default) else str(parameter.default)
            rows.append([words, getattr(parameter, "help", "") or "", default if "Sentinel" not in default else ""])
        parts += [f"## `phichain {name}`", (one.help or "").replace("*", r"\*")]
        if rows:
            parts.append(table(("word", "meaning", "unless given"), rows))
    return "\n\n".join(parts) + "\n"


def api() -> str:
    """Every public name, by its docstring."""
    import inspect
    from importlib import import_module

    parts = ["# Python", "Every public name; `from phichain import ...` brings the first ones."]
    documented: set[int] = set()
    for package in PACKAGES:
        module = import_module(package)
        names = getattr(module, "__all__", None) or [name for name, value in vars(module).items() if inspect.isclass(value) and value.__module__ == package]
        parts.append(f"## `{package}`")
        with redirect_stdout(io.StringIO()):
            found = [(name, getattr(module, name)) for name in names]
        for name, value in found:
            if id(value) in documented or not (inspect.isclass(value) or inspect.isfunction(value)):
                continue
            documented.add(id(value))
            kind = "autoclass" if inspect.isclass(value) else "autofunction"
            members = "\n   :members:" if kind == "autoclass" else ""
            parts.append(f"```{{eval-rst}}\n.. {kind}:: {package}.{name}{members}\n```")
    return "\n\n".join(parts) + "\n"
