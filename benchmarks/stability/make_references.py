"""Makes benchmarks/stability/references.json: states, condition numbers, cross-checks of the extreme cases.

    python -m benchmarks.stability.make_references            # those that are missing
    python -m benchmarks.stability.make_references S17 S18    # these, anew
    python -m benchmarks.stability.make_references --kappa    # condition numbers of motions alone

Each reference comes from the engine (dense Lagrangian in binary128), from closed forms or from the 50-digit oracle of
phichain.reference, and is checked by a second way: another order and tolerance in 80-bit arithmetic, the
closed form against the engine, the oracle against the engine, heyoka's Taylor method in binary128 on another
formulation. The condition number is the amplification of a relative change, signs at random, the worst of three, in the
norms that errors are measured in: of every parameter and entry of the state for forward dynamics; for motions of the state,
at the start and again on the way, as every method's rounding changes it.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

import mpmath as mp

from benchmarks.stability.cases import shared
from benchmarks.stability.cases.case import Case
from benchmarks.stability.cases.table import all_cases, work_cases
from benchmarks.stability.means import elliptic, engine, long_chain, quad_taylor
from benchmarks.stability.references import FILE, gap, read
from phichain.reference import reference as oracle

AMOUNT = 1e-8
DRAWS = 3
KICKS = 15
LONG = 8  # links from which fewer digits are asked, as with stiff springs, whose forces cancel; and one change is tried


def main(arguments: Sequence[str] | None = None) -> int:
    chosen = list(sys.argv[1:] if arguments is None else arguments)
    stored = read()
    if "--kappa" in chosen:
        return _conditions(stored, [name for name in chosen if name != "--kappa"])
    for case in [*all_cases(), *work_cases()]:
        if case.id not in (chosen or [case.id]) or (not chosen and case.id in stored):
            continue
        begin = time.perf_counter()
        entry = make(case)
        _keep(case, entry)
        words = f"kappa {entry['kappa']}, cross-check {entry['crosscheck']}"
        print(f"{case.id} {case.title}: {words}, {time.perf_counter() - begin:.0f} s", flush=True)
    return 0


def _conditions(stored: dict[str, dict[str, Any]], chosen: Sequence[str]) -> int:
    """Condition numbers of stored motions, anew."""
    for case in [*all_cases(), *work_cases()]:
        entry = stored.get(case.id)
        if case.kind != "motion" or case.means == "sweep" or entry is None or case.id not in (chosen or [case.id]):
            continue
        with mp.workdps(elliptic.DIGITS):
            exact = [[mp.mpf(x) for x in row] for row in entry["rows"]]
            found = _condition(case, exact, entry["fastest"])
        stated = shared.condition(case.id) if case.means == "given" else None
        entry["kappa"] = [max(pair) for pair in zip(found, stated or found, strict=True)]
        _keep(case, entry)
        print(f"{case.id} {case.title}: kappa {entry['kappa']}", flush=True)
    return 0


def _keep(case: Case, entry: dict[str, Any]) -> None:
    """Put one entry into the file, in the order of the cases; another run may have written to it since it was read."""
    content = {**read(), case.id: entry}
    known = [other.id for other in [*all_cases(), *work_cases()]]
    FILE.write_text(json.dumps({name: content[name] for name in known if name in content}, indent=1) + "\n")


def make(case: Case) -> dict[str, Any]:
    """One entry of the file."""
    with mp.workdps(elliptic.DIGITS):
        if case.means == "constant":
            return {"rows": [], "kappa": [_energy_condition(case)], "fastest": 0.0, "made": "the energy at the start",
                    "crosscheck": {}}  # fmt: skip
        return {
            "dynamics": _dynamics, "motion": _motion, "period": _period,
        }[case.kind](case)  # fmt: skip


def _dynamics(case: Case) -> dict[str, Any]:
    scene, x0 = case.plain(), (*case.q, *case.v)
    by_engine = [mp.mpf(text) for text in engine.accelerations(scene, x0, u=case.u)]
    checks = {}
    if case.means == "given":
        made, rows = "stated in extreme_cases.json", shared.rows(case.id)[0]
        checks["the engine (binary128, dense)"] = _relative([mp.mpf(x) for x in rows], by_engine)
    elif case.means == "oracle":
        inputs = {"q": case.q, "v": case.v, "u": case.u}
        exact = oracle(scene, "forward_dynamics", inputs, digits=40)["a"]
        made, rows = "phichain.reference, 40 digits, dense", [mp.nstr(x, 34) for x in exact]
        checks["the engine (binary128, dense)"] = _relative(exact, by_engine)
    else:
        made, rows = "the engine: dense Lagrangian, binary128", [mp.nstr(x, 34) for x in by_engine]
        narrow = [mp.mpf(text) for text in engine.accelerations(scene, x0, u=case.u, wide=False)]
        checks["the same in 80-bit arithmetic"] = _relative(by_engine, narrow)
    stated = shared.condition(case.id) if case.means == "given" else None
    kappa = stated or [max(_relative(by_engine, _nudged(case, seed)) / AMOUNT for seed in range(DRAWS))]
    return {"rows": [rows], "kappa": kappa, "fastest": 0.0, "made": made, "crosscheck": checks}


def _nudged(case: Case, seed: int) -> list[mp.mpf]:
    scene = case.plain()
    change = engine.nudge(scene, AMOUNT, seed)
    return [mp.mpf(x) for x in engine.accelerations(scene, (*case.q, *case.v), u=case.u, change=change)]


def _relative(exact: Sequence[mp.mpf], other: Sequence[mp.mpf]) -> float:
    worst = max(abs(a - b) for a, b in zip(exact, other, strict=True))
    return float(worst / max(abs(a) for a in exact))


def _motion(case: Case) -> dict[str, Any]:
    if case.means == "sweep":
        return _swept(case)
    scene, x0, stiff = case.plain(), (*case.q, *case.v), _is_stiff(case)
    options: dict[str, Any] = {"stages": 9, "tol": 1e-21} if stiff else {"tol": 1e-25}
    if scene.links >= LONG or (scene.stiffness and not stiff):
        options = {"tol": 1e-20, "columns": 12}
    run = engine.integrate(scene, x0, case.times, u=case.u, **options)
    checks = {}
    if case.means == "elliptic":
        made, rows = "Jacobi elliptic functions, 110 digits", [_texts(_closed(case, t)) for t in case.times]
    elif case.means == "given":
        made, rows = "stated in extreme_cases.json", shared.rows(case.id)
    else:
        way = "Radau IIA of 9 stages" if stiff else "extrapolation"
        made, rows = f"the engine: dense Lagrangian, binary128, {way}", [list(row) for row in run.states]
    exact = [[mp.mpf(x) for x in row] for row in rows]
    if case.means in ("elliptic", "given"):
        checks["the engine (binary128, dense)"] = gap(exact, run.numbers(), run.fastest)
    else:
        way, second = _second(case, stiff)
        checks[way] = gap(exact, second.numbers(), run.fastest)
        if quad_taylor.serves(case):
            way = "heyoka's Taylor method, binary128, link-frame recursion"
            checks[way] = gap(exact, quad_taylor.states(case), run.fastest)
    stated = shared.condition(case.id) if case.means == "given" else None
    found = _condition(case, exact, run.fastest)
    kappa = [max(pair) for pair in zip(found, stated or found, strict=True)]
    return {"rows": rows, "kappa": kappa, "fastest": run.fastest, "made": made, "crosscheck": checks}


def _swept(case: Case) -> dict[str, Any]:
    """A chain too long for the engine's steps: see `long_chain`; the engine confirms an acceleration on the way."""
    fine = long_chain.states(case, 1e-4, 7)
    half = len(case.q)
    fastest = max(float(abs(x)) for row in fine for x in row[half:])
    other = long_chain.states(case, 1.25e-4, 6)
    moved = long_chain.states(case, 1.25e-4, 6, case.round_off)
    kappa = [gap([a], [b], fastest) / case.round_off for a, b in zip(fine, moved, strict=True)]
    check = {"order 12, other steps": gap(fine, other, fastest), "the engine's acceleration at the end": long_chain.acceleration_gap(case, fine[-1])}
    made = "the link-frame recursion in 80-bit arithmetic, extrapolation of order 14"
    return {"rows": [_texts(row) for row in fine], "kappa": kappa, "fastest": fastest, "made": made, "crosscheck": check}


def _is_stiff(case: Case) -> bool:
    return case.means == "radau" or case.id == "B10"


def _second(case: Case, stiff: bool) -> tuple[str, engine.Run]:
    """The same motion by another order, other steps and, where long, other arithmetic."""
    options: dict[str, Any] = {"tol": 1e-22, "columns": 10}
    way = "order 20, other steps"
    if case.plain().links >= LONG or (case.plain().stiffness and not stiff):
        options, way = {"tol": 1e-18, "columns": 9}, "order 12, other steps"
    elif stiff:
        options, way = {"stages": 7, "tol": 1e-19}, "7 stages, other steps"
    return way, engine.integrate(case.plain(), (*case.q, *case.v), case.times, u=case.u, **options)


def _closed(case: Case, t: float) -> list[mp.mpf]:
    chain = case.plain()
    omega0 = mp.sqrt(mp.mpf(chain.gravity) / mp.mpf(chain.length[0]))
    return list(elliptic.state(mp.mpf(case.q[0]), mp.mpf(case.v[0]), omega0, mp.mpf(t)))


def _texts(values: Sequence[mp.mpf]) -> list[str]:
    return [mp.nstr(x, 34) for x in values]


def _condition(case: Case, exact: list[list[mp.mpf]], fastest: float) -> list[float]:
    """What a backward stable method cannot avoid, per time, over round-off: the worst of a few changes.

    Every entry of the state changes by one round-off, relative, at the start and again at some times on the way: near a
    separatrix it is those that count. The change is as large as that, so nothing is assumed to be linear.
    """
    scene, found = case.plain(), []
    stiff = _is_stiff(case)
    options: dict[str, Any] = {"stages": 7, "tol": 1e-20} if stiff else {"tol": 1e-23}
    long = scene.links >= LONG
    if long or (scene.stiffness and not stiff):
        options = {"tol": 1e-18, "columns": 9}
    for seed in range(1 if long else DRAWS):
        change = engine.kicked(scene, case.round_off, seed, case.times[-1], 3 if long else KICKS)
        moved = engine.integrate(scene, (*case.q, *case.v), case.times, u=case.u, change=change, **options)
        found.append([
            gap([a], [b], fastest) / case.round_off for a, b in zip(exact, moved.numbers(), strict=True)
        ])  # fmt: skip
    return [max(column) for column in zip(*found, strict=True)]


def _period(case: Case) -> dict[str, Any]:
    rows = shared.rows(case.id)
    scene = case.plain()
    omega0 = mp.sqrt(mp.mpf(scene.gravity) / mp.mpf(scene.length[0]))
    closed = elliptic.frequency(mp.mpf(case.q[0]), omega0)
    checks = {"pi omega_0 / (2 K), 110 digits": _relative([closed], [mp.mpf(rows[0][0])])}
    return {"rows": rows, "kappa": shared.condition(case.id), "fastest": 0.0,
            "made": "stated in extreme_cases.json", "crosscheck": checks}  # fmt: skip


def _energy_condition(case: Case) -> float:
    """Of the energy above the hanging rest, by the oracle: parameters stay, the state changes."""
    scene = case.plain()

    def height(q: Sequence[mp.mpf]) -> mp.mpf:
        energies = [
            oracle(scene, "energy", {"q": [*x], "v": case.v}, digits=40) for x in (q, [0.0] * scene.nq)
        ]
        return (
            energies[0]["kinetic"]
            + energies[0]["potential"]
            - energies[1]["kinetic"]
            - energies[1]["potential"]
        )

    here = height(case.q)
    there = height([x * (1 + 2.0**-30) for x in case.q])
    return max(1.0, float(abs(there - here) / here * 2**30))


if __name__ == "__main__":
    sys.exit(main())
