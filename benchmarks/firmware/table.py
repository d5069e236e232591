"""benchmarks/results/firmware.md: what generated C costs on a Cortex-M4F, beside CasADi's and a form written by hand."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Final

from benchmarks.firmware import peers
from benchmarks.firmware.accuracy import worst_error, worst_spatial_error
from benchmarks.firmware.peers.solvers import answers, cvxpygen, missing, osqp
from benchmarks.firmware.probe import probe, read
from benchmarks.firmware.reach import refusals
from benchmarks.firmware.scenes import chain, spatial
from benchmarks.firmware.targets import M4F
from benchmarks.firmware.tools import run
from phichain.files import write_folder
from phichain.scratch import folder_texts

RESULTS: Final = Path(__file__).parents[1] / "results" / "firmware.md"
_HEAD: Final = "| code | -O | text, bytes | instructions | stack, bytes | worst error |\n|---|---|---:|---:|---:|---:|\n"


def write() -> None:
    """Measure everything and write the table."""
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)
        parts = [
            _intro(), *_forward(root), *_jacobians(root), *_spatial(root), *_double(root), *_points(root), *_flows(),
        ]  # fmt: skip
    RESULTS.write_text("\n".join(parts))
    print(f"wrote {RESULTS}")


def _intro() -> str:
    versions = [run("arm-none-eabi-gcc", "--version").splitlines()[0], run("qemu-system-arm", "--version").splitlines()[0]]
    return (
        "# Firmware: generated C on a Cortex-M4F\n\n"
        "`make firmware WRITE=1` writes this page; `make firmware` holds the checks behind it. Compilers: " + ", ".join(versions) + ".\n"
        "Single precision, paper A's chain (m = l = 1/N, r = l/2, all joints actuated), 1000 states with |q| <= 3.125, |v| <= 4, |u| <= 2. "
        "Text is the function with its sine-cosine kernel, the C library's own code not counted; instructions are counted by the emulated "
        "board's clock (QEMU mps2-an386, -icount), fewest to most over the states; stack is painted memory, what the C library takes "
        "included. The error is that of the worst state against extended precision, max norm over max norm. `-ffp-contract=off`: the same "
        "bits on x86-64, Cortex-M0, M3, M4F, M7 and RV32.\n"
    )


def _row(label: str, folder: Path, links: int, level: str) -> str:
    name = next(path.stem for path in folder.glob("*.h"))
    probe(folder, ("forward_dynamics",), selftest=False)
    program = M4F.build([folder / f"{name}.c", folder / "probe.c"], folder / "table.elf", level, "-fno-math-errno")
    seen = read(M4F.run(program), M4F.ticks)["forward_dynamics"]
    text = M4F.text(M4F.compile(folder / f"{name}.c", level, "-fno-math-errno"))
    span = f"{seen.least}" if seen.most - seen.least <= 1 else f"{seen.least} to {seen.most}"
    return f"| {label} | {level} | {text} | {span} | {seen.stack} | {worst_error(folder, links):.1e} |\n"


def _forward(root: Path) -> Iterator[str]:
    for links in (2, 4, 10):
        rows = []
        for level in ("-Os", "-O2"):
            for trig in ("bundled", "libm"):
                for code, label in (("auto", ""), ("loops", ", loops")):
                    scene = chain(f"t{links}_{trig}_{code}", links, ("forward_dynamics",), trig=trig, code=code)
                    folder = write_folder(root / scene.name, folder_texts(scene, False, False))
                    rows.append(_row(f"phichain, {trig}{label}", folder, links, level))
            rows.append(_row("by hand, lean kernel (to 1e3 rad)", peers.expert(root / f"own{links}", links, True), links, level))
            rows.append(_row("by hand, libm", peers.expert(root / f"lib{links}", links, False), links, level))
            rows.append(_row("CasADi", peers.casadi(root / f"casadi{links}", links), links, level))
        yield f"## Forward dynamics, N = {links}\n\n{_HEAD}{''.join(rows)}"


def _jacobians(root: Path) -> Iterator[str]:
    rows = []
    for links, code in ((2, "unrolled"), (4, "unrolled"), (4, "loops"), (10, "loops")):
        scene = chain(f"j{links}_{code}", links, ("dynamics_and_jacobian",), code=code)
        folder = write_folder(root / scene.name, folder_texts(scene, False, False))
        probe(folder, selftest=False)
        for level in ("-Os", "-O3"):
            program = M4F.build([folder / f"{scene.name}.c", folder / "probe.c"], folder / "table.elf", level)
            seen = read(M4F.run(program), M4F.ticks)["dynamics_and_jacobian"]
            text = M4F.text(M4F.compile(folder / f"{scene.name}.c", level))
            rows.append(f"| N = {links}, {code} | {level} | {text} | {seen.most} | {seen.stack} |\n")
    yield "## Forward dynamics and Jacobian together, bundled trigonometry\n\n| code | -O | text, bytes | instructions | stack, bytes |\n|---|---|---:|---:|---:|\n" + "".join(rows)


def _spatial(root: Path) -> Iterator[str]:
    rows = []
    for function, code in (("forward_dynamics", "auto"), ("state_jacobian", "auto"), ("state_jacobian", "unrolled")):
        scene = spatial(f"s5_{function}_{code}", 5, (function,), code=code)
        folder = write_folder(root / scene.name, folder_texts(scene, False, False))
        probe(folder, selftest=False)
        error = f"{worst_spatial_error(folder, 5):.1e}" if function == "forward_dynamics" else ""
        for level in ("-Os", "-O2"):
            program = M4F.build([folder / f"{scene.name}.c", folder / "probe.c"], folder / "table.elf", level)
            seen = read(M4F.run(program), M4F.ticks)[function]
            text = M4F.text(M4F.compile(folder / f"{scene.name}.c", level))
            rows.append(f"| {function}, {code} | {level} | {text} | {seen.most} | {seen.stack} | {error} |\n")
    yield (
        "## Five spatial links on a cart, masses at their ends\n\nThe error over 1000 states of unit vectors, against (16) of paper B, dense "
        f"in extended precision.\n\n{_HEAD}{''.join(rows)}"
    )


def _double(root: Path) -> Iterator[str]:
    rows = []
    for label, trig in (("bundled, in integers", "bundled"), ("kernel of hosts", None)):
        scene = chain(f"d4_{trig}", 4, ("forward_dynamics",), real="double", trig=trig)
        folder = write_folder(root / scene.name, folder_texts(scene, False, False))
        probe(folder, selftest=False)
        program = M4F.build([folder / f"{scene.name}.c", folder / "probe.c"], folder / "table.elf", "-Os")
        seen = read(M4F.run(program), M4F.ticks)["forward_dynamics"]
        text = M4F.text(M4F.compile(folder / f"{scene.name}.c", "-Os"))
        rows.append(f"| {label} | {text} | {seen.least} to {seen.most} | {seen.stack} |\n")
    yield (
        "## Double precision, which the M4F computes by calls: forward dynamics, N = 4, -Os\n\n"
        "| sines and cosines | text, bytes | instructions | stack, bytes |\n|---|---:|---:|---:|\n" + "".join(rows)
    )


def _points(root: Path) -> Iterator[str]:
    """Points of the list that firmware projects ask for, by the same questions of OSQP's C."""
    scene = chain("points2", 2, ("forward_dynamics", "step_jacobian"))
    mine = write_folder(root / "points", folder_texts(scene, False, False))
    columns = {"phichain": answers(mine, lambda: write_folder(root / "again", folder_texts(scene, False, False)), [mine / "points2.c"])}
    note = ""
    for name, package, made in (("OSQP", "osqp", osqp), ("CVXPYgen", "cvxpygen", cvxpygen)):
        if missing(package):
            note += f"\n{name} is not installed and left out: {missing(package)}.\n"
            continue
        theirs = made(root / package)
        own = sorted(path for path in theirs.rglob("*.c") if path.name not in ("emosqp.c", "cpg_example.c"))
        columns[name] = answers(theirs, partial(made, root / f"{package}_again"), own)
    rows = [f"| {question} | {' | '.join(column[question] for column in columns.values())} |\n" for question in columns["phichain"]]
    yield (
        "## Points of the list, by the same questions of emitted solvers\n\nThe chain of two links; phichain: forward dynamics and sampled "
        "system with bundled trigonometry; OSQP: its regulator of ten steps, emitted for single precision without printing and timing "
        "(benchmarks/firmware/peers/solvers.py). CVXPYgen's interface offers no "
        "single precision: its column is in double, where nothing is there to promote. The points' numbers are those of the checks of `make firmware`.\n\n"
        f"| point | {' | '.join(columns)} |\n|---|{'---|' * len(columns)}\n" + "".join(rows) + note
    )


def _flows() -> Iterator[str]:
    rows = [
        f"| {one.links} | {one.tolerance:g} | {one.refused} of {one.runs} | {one.typical:.1e} | {one.worst:.3f} | {one.worst_double:.3f} "
        f"| {one.of_rounding:.2f} | {one.workspace} |\n"
        for one in refusals()
    ]
    yield (
        "## The Taylor flow in single precision\n\n1 s, q within +-pi, |v| <= 0.5; the error of the end against double precision at 1e-12, "
        "rates in units of the fastest. A chaotic motion carries on what each step does to it: the worst error over what is allowed is that over the "
        "tolerance times the largest growth of a disturbance, from any time to the end, in any direction, by transition matrices; in double "
        "precision at the same tolerance beside it. The worst error over rounding is that over what accelerations and rates wrong by half a "
        "unit in the last place may make of the end, whatever integrates them (benchmarks/firmware/reach.py).\n\n"
        "| N | tolerance | refused | median error | worst error over what is allowed | in double | worst error over rounding | workspace, bytes |\n"
        "|---:|---:|---:|---:|---:|---:|---:|---:|\n" + "".join(rows)
    )
