"""The code blocks of the pages: Python is run, page by page, TOML is loaded, commands are parsed, C is compiled."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
_COMMAND = re.compile(r"^    (phichain (?:.*\\\n)*.+)$", re.MULTILINE)
"""An indented command, whose lines may go on behind a backslash."""
_LEFT = re.compile(r"^    (?:from \w[\w.]* import |import \w|[a-z_]\w*(?:, [a-z_]\w*)* = \w[\w.]*\(|print\()(?!.*;$)", re.MULTILINE)
"""An indented line that is Python, and so is not run."""
_LIMIT = 600


@dataclass(frozen=True)
class Block:
    """One block of a page."""

    page: Path
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def _pages(root: Path) -> tuple[Path, ...]:
    return (root / "README.md", *sorted((root / "docs").glob("*.md")), *sorted((root / "docs" / "notebooks").glob("*.md")))


def indented(root: Path) -> Iterator[str]:
    """Where Python stands that nothing runs."""
    for page in _pages(root):
        text = _FENCED.sub(lambda fenced: "\n" * fenced[0].count("\n"), page.read_text())
        for match in _LEFT.finditer(text):
            yield f"{page.relative_to(root)}:{text[: match.start()].count(chr(10)) + 1}: is Python that nothing runs; fence it as ```python"


def blocks(root: Path) -> Iterator[Block]:
    """Every block of README and docs, fenced, and every indented line that is a command."""
    for page in _pages(root):
        text = page.read_text()
        for match in _FENCE.finditer(text):
            yield Block(page.relative_to(root), text[: match.start()].count("\n") + 2, match[1], match[2])
        for match in _COMMAND.finditer(text):
            yield Block(page.relative_to(root), text[: match.start()].count("\n") + 1, "sh", match[1])


def faults(root: Path) -> list[str]:
    """What is wrong with the blocks: one line each."""
    found = list(indented(root))
    pages: dict[Path, list[Block]] = {}
    for block in blocks(root):
        if block.language == "python":
            pages.setdefault(block.page, []).append(block)
            continue
        check = {"toml": _toml, "sh": _command, "c": _c}.get(block.language)
        problem = check(block.text) if check else "" if block.language in ("text", "console", "json", "make", "cmake") else "is in a language that nothing checks"
        found += [f"{block}: {problem}"] if problem else []
    for page, parts in pages.items():
        problem = _python(root, parts)
        found += [f"{page}: {problem}"] if problem else []
    return found


def _toml(text: str) -> str:
    from phichain.errors import PhichainError
    from phichain.scene.load import scene_from_dict
    from phichain.studies import plan_of

    try:
        tables = tomllib.loads(text)
        if "scene" in tables:
            assert plan_of(tables).outputs
        elif {"name", "chain"} <= tables.keys():
            scene_from_dict(tables)
        else:
            _part(tables)
    except (PhichainError, ValueError) as fault:
        return str(fault)
    return ""


def _part(tables: dict[str, Any]) -> None:
    """Part of a scene: its keys are keys."""
    from phichain.scene.keys import flatten

    whole = {"name": "part", **tables}
    whole["chain"] = {"links": 1, "mass": 1.0, "length": 1.0, **tables.get("chain", {})}
    flatten(whole)


def _command(text: str) -> str:
    """The command and its options are there; names in capitals stand for what a user has."""
    import typer

    from phichain.app.cli import app

    words = shlex.split(text.replace("\\\n", " ").split("  #")[0].split(" #")[0])[1:]
    group = typer.main.get_command(app)
    context = typer.Context(group, info_name="phichain")
    if words[0].startswith("-"):
        return ""
    one = group.get_command(context, words[0])  # type: ignore[attr-defined]
    if one is None:
        return f"phichain has no command {words[0]}"
    known = {word for parameter in one.params for word in (*parameter.opts, *parameter.secondary_opts)} | {"--help", "-h"}
    lost = [word for word in words[1:] if word.startswith("-") and not re.fullmatch(r"-[\d.].*", word) and word.split("=")[0] not in known]
    return f"{words[0]} has no option {', '.join(lost)}" if lost else ""


def _c(text: str) -> str:
    """A fragment parses at the top of a file or within a function; names that only a generated header knows count as known."""
    compiler = shutil.which("cc")
    if compiler is None or "#include" in text:
        return ""  # the README's is compiled and run by the tests
    types = sorted(set(re.findall(r"\b[a-z]\w*_(?:real|params|flow|event|workspace|state|law|memory)\b", text)))
    known = "".join(f"typedef struct {{ double t, tolerance; }} {name};\n" if not name.endswith("_real") else f"typedef double {name};\n" for name in types)
    complaints = []
    for source in (f"{known}{text}", f"{known}void page(void)\n{{\n{text}\n}}\n"):
        words = [compiler, "-std=c99", "-fsyntax-only", "-w", "-xc", "-"]
        done = subprocess.run(words, input=source, capture_output=True, text=True, check=False)
        errors = [line for line in done.stderr.splitlines() if " error: " in line and not re.search(r"undeclared|has no member", line)]
        if not errors:
            return ""
        complaints.append(errors[0])
    return complaints[-1]


def _python(root: Path, parts: list[Block]) -> str:
    """One page's Python, run in one go in a folder of its own, where a page may generate what it imports."""
    with tempfile.TemporaryDirectory() as folder:
        text = "\n".join(part.text for part in parts)
        for name in set(re.findall(r"^import (planar\d+|\w+)_casadi$", text, re.MULTILINE)):
            subprocess.run([sys.executable, "-m", "phichain", "generate", name, "--out", folder], cwd=root, env=_environment(root), check=True, capture_output=True)
            for path in Path(folder, name).iterdir():
                shutil.copy(path, folder)
        script = Path(folder, "page.py")
        script.write_text(text)
        try:
            done = subprocess.run([sys.executable, str(script)], cwd=folder, env=_environment(root), capture_output=True, text=True, check=False, timeout=_LIMIT)
        except subprocess.TimeoutExpired:
            return f"its Python takes longer than {_LIMIT} s"
    return "" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["its Python fails"])[-1]


def _environment(root: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(root / "codegen"), str(root)]), "MPLBACKEND": "agg"}
