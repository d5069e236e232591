"""Emitted solvers beside emitted laws: which of the points that firmware asks for hold of OSQP's and CVXPYgen's C, by the same questions.

The task is paper A's chain of two links held at rest: its A_d and B_d (`step_jacobian`, 10 ms) in a receding-horizon regulator of ten steps
with bounded torques, which OSQP solves; CVXPYgen is given it in words of CVXPY and writes OSQP's C with its own around it. What is compared is not the task's cost, but what kind of C comes out.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from benchmarks.firmware.points.analysis import STRICT
from benchmarks.firmware.targets import COMMON, M4F
from benchmarks.firmware.tools import run

HORIZON: Final = 10
_OWN: Final = {"memcpy", "memmove", "memset"}


def missing(package: str) -> str:
    """What to install where a peer is not there; empty where it is."""
    return "" if find_spec(package) else f"pip install {package}"


def _sampled() -> tuple[Any, Any]:
    """A_d and B_d of the chain of two links, hanging at rest."""
    import numpy as np

    import phichain
    from benchmarks.firmware.scenes import chain

    system = phichain.build(chain("sampled2", 2, ("step_jacobian",), real="double", trig=None), prove=False)
    *_, a, b = system.step_jacobian(0.01, np.zeros(2), np.zeros(2), np.zeros(2))
    return a, b


def cvxpygen(folder: Path) -> Path:
    """CVXPYgen's C for the same regulator, whose start is a parameter; in double precision: its interface offers no other."""
    import cvxpy
    from cvxpygen import cpg

    a, b = _sampled()
    start = cvxpy.Parameter(len(a), name="start")
    x, u = cvxpy.Variable((len(a), HORIZON + 1), name="x"), cvxpy.Variable((b.shape[1], HORIZON), name="u")
    held = [x[:, 0] == start, x[:, 1:] == a @ x[:, :-1] + b @ u, cvxpy.abs(u) <= 2.0]
    problem = cvxpy.Problem(cvxpy.Minimize(0.5 * cvxpy.sum_squares(x) + 0.05 * cvxpy.sum_squares(u)), held)
    cpg.generate_code(problem, code_dir=str(folder), solver="OSQP", wrapper=False)
    return folder


def osqp(folder: Path) -> Path:
    """OSQP's C for the regulator, in single precision, without printing and timing; the bounds may be updated."""
    import numpy as np
    import osqp as solver
    from scipy import sparse

    a, b = _sampled()
    states, inputs, steps = len(a), b.shape[1], HORIZON
    weights = sparse.block_diag([sparse.eye((steps + 1) * states), 0.1 * sparse.eye(steps * inputs)], format="csc")
    moves = sparse.kron(sparse.eye(steps + 1), -sparse.eye(states)) + sparse.kron(sparse.eye(steps + 1, k=-1), a)
    pushes = sparse.kron(sparse.vstack([sparse.csc_matrix((1, steps)), sparse.eye(steps)]), b)
    rows = sparse.vstack([sparse.hstack([moves, pushes]), sparse.eye(weights.shape[0])], format="csc")
    held = np.concatenate([-np.full(states, 0.1), np.zeros(steps * states)])
    most = np.concatenate([np.full((steps + 1) * states, 1e3), np.full(steps * inputs, 2.0)])
    problem: Any = solver.OSQP()
    problem.setup(weights, np.zeros(weights.shape[0]), rows, np.concatenate([held, -most]), np.concatenate([held, most]), verbose=False)
    problem.codegen(
        str(folder), parameters="vectors", use_float=True, printing_enable=False, profiling_enable=False, force_rewrite=True, compile=False,
        extension_name="mpc",
    )  # fmt: skip
    return folder


def answers(folder: Path, make_again: Callable[[], Path], sources: list[Path]) -> dict[str, str]:
    """What a folder of emitted C answers to each question.

    Args:
        folder: where it is.
        make_again: generates it into another folder.
        sources: its .c files, those of a self-test and of examples left out.
    """
    includes = [f"-I{path}" for path in sorted({path.parent for path in folder.rglob("*.h")})]
    headers = sorted(folder.rglob("*.h"))
    objects = []
    for source in sources:
        objects.append(source.with_suffix(".table.o"))
        run("arm-none-eabi-gcc", *M4F.flags, *COMMON, "-Os", "-fno-math-errno", *includes, "-c", source, "-o", objects[-1])
    whole = folder / "whole.o"
    run("arm-none-eabi-ld", "-r", *objects, "-o", whole)
    asked = {line.split()[-1] for line in run("arm-none-eabi-nm", "-u", whole).splitlines() if line.strip()} - _OWN
    text, data, bss = run("arm-none-eabi-size", whole).splitlines()[1].split()[:3]
    told = "\n".join(path.read_text(errors="replace") for path in (*sources, *headers))
    words = [f"{len(sources)} .c, {len(headers)} .h", text, f"{int(data) + int(bss)}", ", ".join(sorted(asked)) or "nothing"]
    return {
        "1 files": words[0], "1 asks for (nm -u)": words[3], "10 text at -Os, bytes": words[1], "3 memory of its own that changes, bytes": words[2],
        "2 doubles in single precision (-Wdouble-promotion)": str(_warnings(sources, includes, "-Wdouble-promotion")),
        "8 headers read by C90 / C99 / C++11": " / ".join(
            _reads(headers, includes, *dialect) for dialect in (("gcc", "-std=c90"), ("gcc", "-std=c99"), ("g++", "-std=c++11"))
        ),
        "8 flash and stack stated": _yes(re.search(r"stack \d+ bytes", told)), "9 the same bytes again": _yes(_same(folder, make_again())),
        "9 names the day": _yes(re.search(r"\b20\d\d\b[- ]\d\d|on [A-Z][a-z]{2} \d{2}, 20\d\d|\d\d:\d\d:\d\d", told)),
        "12 self-test and vectors": _yes(list(folder.rglob("selftest.c"))), "10 manifest with hashes": _yes(list(folder.rglob("manifest.json"))),
        "20 words of gcc at its strictest": str(_warnings(sources, includes, *STRICT[:-1])), "20 rules of MISRA C:2012 broken (cppcheck)": str(_misra(sources, includes)),
    }  # fmt: skip


def _yes(found: object) -> str:
    return "yes" if found else "no"


def _warnings(sources: list[Path], includes: list[str], *flags: str) -> int:
    told = "".join(
        subprocess.run(["gcc", *flags, *includes, "-fsyntax-only", source], capture_output=True, text=True, check=False).stderr for source in sources
    )
    return len(re.findall(r"\b(?:warning|error): ", told))


def _reads(headers: list[Path], includes: list[str], compiler: str, dialect: str) -> str:
    """How many headers a dialect reads by themselves."""
    language = "c++" if compiler == "g++" else "c"
    good = 0
    for header in headers:
        text = f'#include "{header}"\n'
        words = [compiler, "-x", language, dialect, "-pedantic-errors", *includes, "-fsyntax-only", "-"]
        good += subprocess.run(words, input=text, capture_output=True, text=True, check=False).returncode == 0
    return f"{good} of {len(headers)}"


def _misra(sources: list[Path], includes: list[str]) -> int:
    told = run("cppcheck", "--addon=misra", "--std=c99", "--quiet", "--max-configs=1", "--suppress=missingIncludeSystem", *includes, *sources)
    return len(set(re.findall(r"misra-c2012-([\d.]+)", told)))


def _same(folder: Path, other: Path) -> bool:
    files = [path.relative_to(folder) for path in folder.rglob("*") if path.suffix in (".c", ".h") and path.is_file()]
    return all((folder / path).read_bytes() == (other / path).read_bytes() for path in files)
