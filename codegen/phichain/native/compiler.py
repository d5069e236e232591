"""The system C compiler: found, identified, and run with a checked exit code and a time limit.

A shared object built with ``-march=native`` runs only on processors like the one it was built on, and a cache
may be shared between machines. The compiler's identity therefore includes every macro it predefines under our
flags: its version, its target, and each instruction set that ``native`` stands for here.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shlex
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final, NoReturn

from phichain.errors import CompilerError, OutputError
from phichain.files import write_synced
from phichain.native.process import OutlastedError, finished
from phichain.reading import MEBIBYTE, read_regular

CANDIDATES: Final = ("cc", "gcc", "clang")
_NATIVE: Final = "-march=native"
_PROBE_SECONDS: Final = 20.0
_SHOWN_LINES: Final = 12
_LONGEST_LINE: Final = 200
_LARGEST_LIBRARY: Final = 1024 * MEBIBYTE


@dataclass(frozen=True)
class CompilerOptions:
    """How the C is compiled.

    Attributes:
        flags: Flags before the sources. Contraction to fused multiply-adds is allowed (it only saves
            roundings); NaN and infinities keep their meaning, errno and floating-point traps do not. Loops are
            vectorised; straight-line code is faster without.
        libraries: Flags after the sources.
        timeout: Seconds after which a compilation counts as hanging.
    """

    flags: tuple[str, ...] = (
        "-std=c99",
        "-O3",
        _NATIVE,
        "-ffp-contract=fast",
        "-fno-math-errno",
        "-fno-trapping-math",
        "-fno-tree-slp-vectorize",
        "-fPIC",
        "-shared",
    )
    libraries: tuple[str, ...] = ("-lm",)
    timeout: float = 300.0

    def __post_init__(self) -> None:
        if not self.timeout > 0.0:
            raise CompilerError(
                "timeout", self.timeout, "the time limit must be positive", "give it in seconds"
            )

    @property
    def digest(self) -> str:
        """SHA-256 over everything that may change the code; the time limit does not."""
        return hashlib.sha256(json.dumps([self.flags, self.libraries]).encode()).hexdigest()

    def portable(self) -> CompilerOptions:
        """The same without ``-march=native``."""
        return replace(self, flags=tuple(flag for flag in self.flags if flag != _NATIVE))


@dataclass(frozen=True)
class Compiler:
    """A compiler that was found and answered.

    Attributes:
        command: The words that start it; the first is an absolute path.
        version: First line of ``--version``.
        target: What ``-dumpmachine`` says, e.g. ``x86_64-linux-gnu``.
        macros: SHA-256 over the macros it predefines under `options`: its version and the processor it
            compiles for.
        libc: The C library of this machine, whose symbols the shared object will want.
        options: The options as this compiler takes them (without ``-march=native`` where it refuses that).
    """

    command: tuple[str, ...]
    version: str
    target: str
    macros: str
    libc: str
    options: CompilerOptions

    @property
    def digest(self) -> str:
        """SHA-256 over the compiler's identity and its options; not over where it is installed."""
        identity = [self.version, self.target, self.macros, self.libc, self.options.digest]
        return hashlib.sha256(json.dumps(identity).encode()).hexdigest()


def find_compiler(
    options: CompilerOptions | None = None, environment: Mapping[str, str] | None = None
) -> Compiler:
    """Find the system C compiler: ``$CC`` when set, else the first of cc, gcc, clang.

    Args:
        options: How it will be used; the defaults when None.
        environment: Where to look for CC and PATH; this process's environment when None.

    Raises:
        CompilerError: There is none, it does not answer, or it refuses our flags.
    """
    command = _command(os.environ if environment is None else environment)
    stat = os.stat(command[0])
    return _identified(command, options or CompilerOptions(), (stat.st_mtime_ns, stat.st_size))


def compile_shared(compiler: Compiler, sources: Mapping[str, bytes], folder: Path, label: str) -> bytes:
    """Compile and link C sources into one shared object and return its bytes.

    The compiler runs inside `folder` and sees bare file names, so neither its messages nor the object hold a
    path.

    Args:
        compiler: From `find_compiler`.
        sources: Contents by file name; every ``.c`` is compiled, the rest (headers) only stands beside.
        folder: An empty private folder on the disk of the result.
        label: Name of what is compiled, for messages.

    Raises:
        CompilerError: It failed, hung, or claimed success without a result.
        OutputError: The disk is full.
    """
    for name, text in sources.items():
        write_synced(folder / name, text)
    units = sorted(name for name in sources if name.endswith(".c"))
    options = compiler.options
    command = (*compiler.command, *options.flags, *units, "-o", "library.so", *options.libraries)
    run(command, folder, options.timeout, label)
    try:
        return read_regular(folder / "library.so", _LARGEST_LIBRARY)
    except OSError as error:
        problem = f"reported success but wrote no shared object: {error.strerror}"
        _fail(command, label, problem, "check what CC names", "")


def run(command: Sequence[str], folder: Path | None, timeout: float, label: str) -> str:
    """Run a compiler command and return what it printed.

    It gets its own process group, so that a hanging compiler ends together with the processes it started, and
    the folder as TMPDIR, so that its intermediate files are as private as ours. A command that writes no file
    needs no folder, and none that can be written to.

    Raises:
        CompilerError: It cannot be started, ends with another exit code than 0, or outlasts `timeout`
            seconds.
        OutputError: It says that the disk is full.
    """
    place = {} if folder is None else {"TMPDIR": str(folder)}
    try:
        code, output, complaint = finished(command, folder or Path("/"), {**os.environ, "LC_ALL": "C", **place}, timeout)
    except OutlastedError:
        remedy = "set CC to a working C compiler, or raise the time limit in CompilerOptions"
        _fail(command, label, f"still ran after {timeout:g} s and was stopped", remedy, "")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        _fail(command, label, f"cannot be started: {why}", "set CC to a working C compiler", "")
    if code != 0:
        _explain(command, label, code, complaint or output)
    return output


def _command(environment: Mapping[str, str]) -> tuple[str, ...]:
    chosen = environment.get("CC", "").strip()
    try:
        words = shlex.split(chosen)
    except ValueError as error:
        raise CompilerError(
            "CC", chosen, f"cannot be read: {error}", "set CC to a C compiler's name"
        ) from None
    for name in words[:1] or CANDIDATES:
        found = shutil.which(name, path=environment.get("PATH"))
        if found:
            return (os.path.abspath(found), *words[1:])
    if words:
        problem, remedy = "there is no such C compiler", "set CC to one that is installed, or unset it"
        raise CompilerError("CC", chosen, problem, remedy, command=tuple(words), stderr=())
    problem = f"no C compiler was found (tried {', '.join(CANDIDATES)})"
    remedy = "install gcc or clang (Debian and Ubuntu: apt install gcc), or set CC"
    raise CompilerError("compiler", None, problem, remedy, command=(), stderr=())


@lru_cache(maxsize=32)
def _identified(command: tuple[str, ...], options: CompilerOptions, installed: tuple[int, int]) -> Compiler:
    """Ask the compiler who it is; `installed` makes a compiler that was upgraded meanwhile be asked again."""
    timeout = min(options.timeout, _PROBE_SECONDS)

    def ask(*words: str) -> str:
        return run((*command, *words), None, timeout, "a first question")

    try:
        macros = ask(*options.flags, "-dM", "-E", "-x", "c", os.devnull)
    except CompilerError as refusal:
        if _NATIVE not in options.flags or refusal.data["code"] is None:
            raise
        options = options.portable()
        macros = ask(*options.flags, "-dM", "-E", "-x", "c", os.devnull)
    version = (ask("--version").splitlines() or ["unknown"])[0]
    digest = hashlib.sha256("\n".join(sorted(macros.splitlines())).encode()).hexdigest()
    return Compiler(command, version, ask("-dumpmachine").strip(), digest, _libc(), options)


def _libc() -> str:
    with suppress(ValueError, OSError, AttributeError):
        return os.confstr("CS_GNU_LIBC_VERSION") or "unknown"
    return "unknown"


def _explain(command: Sequence[str], label: str, code: int, complaint: str) -> NoReturn:
    if os.strerror(errno.ENOSPC) in complaint:
        raise OutputError(
            "output", label, "the compiler met a full disk", "free some space on the disk of the cache"
        )
    ended = f"ended with exit code {code}" if code > 0 else f"was ended by signal {-code}"
    lines = _first_lines(complaint)
    worst = next(
        (line for line in lines if "error" in line.lower()), lines[0] if lines else "it said nothing"
    )
    remedy = "generate the folder again; if it was, try another compiler by setting CC"
    _fail(command, label, f"{ended}: {worst}", remedy, complaint, code)


def _fail(
    command: Sequence[str], label: str, problem: str, remedy: str, complaint: str, code: int | None = None
) -> NoReturn:
    raise CompilerError(
        "compiler",
        shlex.join(command),
        f"compiling {label} failed, {Path(command[0]).name} {problem}",
        remedy,
        command=tuple(command),
        stderr=_first_lines(complaint),
        code=code,
    )


def _first_lines(text: str) -> tuple[str, ...]:
    lines = [line.rstrip()[:_LONGEST_LINE] for line in text.splitlines() if line.strip()]
    return tuple(lines[:_SHOWN_LINES])
