"""AUTO-07p on paper A's double pendulum: compiled from Debian's package with gfortran, its constants written, its answer read.

Two forms of one family, mode 1 from 0.01 rad to theta_1 = -2.5:

* a quarter period as a boundary-value problem, at rest at the start and straight at the end (IPS = 4): no multipliers;
* a period as a periodic orbit with a damper that unfolds the energy (IPS = 2), with its Floquet multipliers.

Both have the closed form in absolute angles and exact Jacobians. AUTO writes eleven digits.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import numpy as np

from benchmarks import ONE_THREAD

HOME = Path(os.environ.get("AUTO_DIR", "/usr/lib/auto-07p"))
EQUATIONS = Path(__file__).with_name("auto_double.f90")
OPTIONS = ("-O3", "-march=native")
_CONSTANTS = """NDIM=4, IRS=0, ILP=0, IAD=3, ISW=1, IPLT=0, NINT=0, NMX=20000, NPR=20000, MXBF=0, IID=2, ITMX=9, ITNW=7, NWTN=3, JAC=1
EPSL=1e-11, EPSU=1e-11, EPSS=1e-9, DSMIN=1e-7, IADS=1, UZR={{2:1.2}}, UZSTOP={{2:-2.5}}
NTST={ntst}, NCOL={ncol}, DS={ds}, DSMAX={ds_max}
"""
_FORMS = {
    "quarter": "IPS=4, ISP=0, NBC=5, ICP=[2,1]\n",
    "periodic": "IPS=2, ISP=2, NBC=0, ICP=[4,11,2]\n",
}
_PERIOD = {"quarter": 1, "periodic": 11}
_IN_A_LINE, _USER = 7, "-4"


def missing() -> str:
    """What there is not of AUTO-07p, with Debian's remedy; empty where nothing is missing."""
    if shutil.which("gfortran") is None:
        return "gfortran is not installed: apt install gfortran"
    if not (HOME / "lib" / "bvp.o").exists():
        return "AUTO-07p is not installed: apt install auto-07p (or set AUTO_DIR to where it is)"
    return ""


@dataclass(frozen=True)
class Run:
    """One run of AUTO.

    Attributes:
        seconds: Processor time, user and system.
        early: T where theta_1 is first 1.2, s; NaN where it did not get there.
        late: T at theta_1 = -2.5, s.
        points: Points of its family.
    """

    seconds: float
    early: float
    late: float
    points: int


def compiled(folder: Path) -> Path:
    """The program, made in a folder.

    Raises:
        subprocess.CalledProcessError: gfortran refuses.
    """
    program = folder / "double"
    objects = sorted(str(path) for path in (HOME / "lib").glob("*.o"))
    words = ["gfortran", *OPTIONS, "-fopenmp", "-J", str(folder), str(EQUATIONS), *objects, "-o", str(program)]
    subprocess.run(words, check=True, capture_output=True)
    return program


def run(program: Path, form: str, ntst: int, ncol: int, ds: float = 0.01, ds_max: float = 0.2) -> Run:
    """One run in a folder of its own, on one core.

    Args:
        program: From `compiled`.
        form: "quarter" or "periodic".
        ntst: Intervals of the mesh.
        ncol: Collocation points in each.
        ds: First step.
        ds_max: Largest step, in AUTO's own norm.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "fort.2").write_text(_FORMS[form] + _CONSTANTS.format(ntst=ntst, ncol=ncol, ds=ds, ds_max=ds_max))
        (folder / "start").write_text("{:.17g} {:.17g} {:.1f}\n".format(*_linear_mode(), float(form == "quarter")))
        child = subprocess.Popen(
            [program], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, **dict.fromkeys(ONE_THREAD, "1")}
        )
        _, _, used = os.wait4(child.pid, 0)
        child.returncode = 0
        points = abs(int((folder / "fort.7").read_text().splitlines()[-1].split()[1]))
        found = _solutions((folder / "fort.8").read_text().splitlines(), _PERIOD[form])
    early, late = ([period for at, period in found if abs(at - wanted) < 1e-6] for wanted in (1.2, -2.5))
    return Run(used.ru_utime + used.ru_stime, (early or [float("nan")])[0], (late or [float("nan")])[0], points)


def _solutions(lines: list[str], period: int) -> list[tuple[float, float]]:
    """(theta_1 at the start, T) of the solutions that were asked for, in order: a header says how many lines follow, the parameters last."""
    found = []
    at = 0
    while at < len(lines):
        header = lines[at].split()
        rows, parameters = int(header[8]), int(header[11])
        block = lines[at + 1 : at + 1 + rows]
        if header[2] == _USER:
            numbers = [float(word) for word in " ".join(block[-ceil(parameters / _IN_A_LINE) :]).split()]
            found.append((numbers[1], numbers[period - 1]))
        at += 1 + rows
    return found


def _linear_mode() -> tuple[float, float]:
    """Frequency, rad/s, and phi_2 / phi_1 of the slow mode, m = l = 1/2, com = 1/4."""
    mass = np.array([[0.15625, 0.0625], [0.0625, 0.03125]])
    squares, shapes = np.linalg.eig(np.linalg.solve(mass, np.diag([9.81 * 0.375, 9.81 * 0.125])))
    slow = int(np.argmin(squares))
    return float(np.sqrt(squares[slow])), float(shapes[1, slow] / shapes[0, slow])
