"""A wheel in an environment of its own: how soon it answers, what its commands cost, and the two commands in a clone."""

from __future__ import annotations

import re
import shutil
import sys
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.front_door.processes import Done, clean, megabytes, often, run
from benchmarks.harness import BenchmarkError
from benchmarks.plan import Plan
from benchmarks.table import Table

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Installed:
    """phichain from its wheel.

    Attributes:
        folder: The environment.
        seconds: How long the installation took.
        source: Where its dependencies are from.
    """

    folder: Path
    seconds: float
    source: str

    def command(self, name: str) -> Path:
        """A command of it."""
        return self.folder / "bin" / name


def installed(scratch: Path) -> Installed:
    """Build the wheel and install it; where there is no index to ask, third-party packages are those of this environment."""
    wheels, folder = scratch / "wheel", scratch / "environment"
    run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", wheels], ROOT, clean())
    (wheel,) = wheels.glob("phichain-*.whl")
    run([sys.executable, "-m", "venv", folder], scratch, clean())
    pip = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    try:
        return Installed(folder, run([*pip, wheel], scratch, clean()).wall, "the package index")
    except BenchmarkError:
        version = f"python{sys.version_info.major}.{sys.version_info.minor}"
        (folder / "lib" / version / "site-packages" / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
        done = run([*pip, "--no-deps", wheel], scratch, clean())
        return Installed(folder, done.wall, "this environment, as no package index answers")


def first_result(made: Installed, scratch: Path) -> Table:
    """What happens in the seconds after the installation."""
    environment = clean(PHICHAIN_CACHE=str(scratch / "cache"))
    words = [made.command("phichain"), "simulate", "planar2", "--t", "10", "--out", "motion.csv"]
    first, again = run(words, scratch, environment), run(words, scratch, environment)
    rows = (
        ("first result, nothing cached: `phichain simulate planar2 --t 10 --out motion.csv`", f"{first.wall:.2f} s", "10 s from the install's end"),
        ("the same again", f"{again.wall:.2f} s", "-"),
        ("the installation before it, of phichain and what it needs", f"{made.seconds:.1f} s, {megabytes(made.folder):.0f} MB", "-"),
    )
    return Table("A wheel in a fresh environment", ("what", "measured", "reach"), rows, (f"By the clock. Third-party packages from {made.source}.",))


def commands(made: Installed, scratch: Path, plan: Plan) -> Table:
    """User times of commands that have run before."""
    environment = clean(PHICHAIN_CACHE=str(scratch / "cache"))
    count = 2 if plan.tiny else 15
    phichain, python = made.command("phichain"), made.command("python")
    bare = often([python, "-c", "pass"], scratch, environment, count)
    wanted = (
        ("`phichain build planar4`, built before", [phichain, "build", "planar4"], "0.6 s"),
        ("`phichain --help`", [phichain, "--help"], "0.15 s"),
        ("`phichain --version`", [phichain, "--version"], "0.15 s"),
        ("`python -c 'import phichain'`", [python, "-c", "import phichain"], "0.15 s"),
    )
    rows = [(name, f"{often(words, scratch, environment, count):.3f} s", reach) for name, words, reach in wanted]
    rows.append(("`python -c pass`, which is in all of them", f"{bare:.3f} s", "-"))
    return Table("What a command costs", ("user time", "measured", "reach"), tuple(rows), (f"Medians of {count} processes each, in the environment above.",))


def two_commands(scratch: Path, tests: bool) -> Table:
    """`make run` and `make test` in a clone, with nothing prepared."""
    clone = scratch / "clone"
    run(["git", "clone", "--quiet", "--depth", "1", ROOT.as_uri(), clone], scratch, clean())
    environment = clean(PHICHAIN_CACHE=str(scratch / "clone-cache"), PYTHON=sys.executable)
    rows = [_timed("`make run`: the environment, then the whole path", ["make", "run", f"PYTHON={sys.executable}"], clone, environment)]
    if rows[0][1].startswith("not"):
        return Table("Two commands on a bare machine", ("what", "measured", "reach"), tuple(rows))
    rows.append(_timed("`make run` again", ["make", "run"], clone, environment))
    rows.append(("what it leaves: `.venv`, `generated/`", f"{megabytes(clone / '.venv'):.0f} MB, {megabytes(clone / 'generated'):.1f} MB", "printed"))
    if tests:
        rows.append(_timed("`make test`", ["make", "test"], clone, environment, r"=+ (.*(?:passed|failed).*) =+"))
    shutil.rmtree(clone)
    return Table("Two commands on a bare machine", ("what", "measured", "reach"), tuple(rows), ("A clone with Python, make and a C compiler; by the clock.",))


def _timed(name: str, words: list[str], cwd: Path, environment: Mapping[str, str], closing: str = "") -> tuple[str, str, str]:
    try:
        done: Done = run(words, cwd, environment)
    except BenchmarkError as failure:
        return name, f"not done: {failure}", "works"
    last = re.findall(closing, done.said) if closing else []
    return name, f"{done.wall:.0f} s" + (f"; {last[-1]}" if last else ""), "works"
