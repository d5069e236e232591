"""Every integrator on one motion: phichain's methods, heyoka, CVODES, SciPy, MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from benchmarks.harness import BenchmarkError
from benchmarks.peers import present
from benchmarks.stability.others import absolute, mujoco_model
from benchmarks.stability.references import gap, references
from benchmarks.work_precision.problems import Work
from benchmarks.work_precision.rows import Candidate
from benchmarks.work_precision.setup import built_afresh, processor_seconds
from phichain import build
from phichain.motion import METHODS, simulate
from phichain.scene import Scene
from phichain.system import System, rhs_jacobian

TAYLOR = "phichain taylor"
TOLERANCES = (1e-6, 1e-9, 1e-12, 1e-15)
_FEWER = (1e-6, 1e-9, 1e-12)

Error = Callable[[Any], float]


def candidates(work: Work, quick: bool) -> list[Candidate]:
    """All of them, built."""
    known = references()[work.case.id]

    def error(state: Any) -> float:
        return gap([known.rows[-1]], [list(state)], known.fastest)

    makers: Sequence[tuple[str, Callable[[Work, Error, bool], Iterator[Candidate]]]] = (
        ("phichain", _ours),
        ("heyoka", _heyoka),
        ("casadi", _sundials),
        ("heyoka", _scipy),
        ("mujoco", _mujoco),
    )
    found: list[Candidate] = []
    for needed, maker in makers:
        try:
            present.module(needed)
            found += maker(work, error, quick)
        except BenchmarkError as refusal:
            print(f"  {maker.__name__.strip('_')} left out: {refusal}", flush=True)
    return found


def _ours(work: Work, error: Error, quick: bool) -> Iterator[Candidate]:
    case = work.case
    system = build(case.scene())
    q, v, end = np.array(case.q), np.array(case.v), case.times[-1]
    if system.has("propagate") and not work.stiff:
        setup = _setup(work, "propagate")
        for tol in TOLERANCES:
            yield Candidate(
                TAYLOR, f"{tol:.0e}", True, lambda tol=tol: _propagated(system, q, v, end, tol), error, setup
            )
    for name, tolerances in _named(work, quick):
        setup = _setup(work, "propagate_stiff") if name == "rosenbrock" else float("nan")
        for tol in tolerances:
            yield Candidate(
                f"phichain {name}", f"{tol:.0e}", True, _simulated(system, case, name, tol), error, setup
            )
    if not work.stiff:
        for name in _fixed(system):
            for count in (1000,) if quick else (1000, 4000):
                solve = _simulated(system, case, name, None, end / count)
                yield Candidate(f"phichain {name}", f"{count} steps", True, solve, error)


def _setup(work: Work, function: str) -> float:
    """Seconds to something callable of that one function."""
    return built_afresh(Scene("lean", **{**work.case.chain, "want": [function]}))[1]


def _named(work: Work, quick: bool) -> list[tuple[str, tuple[float, ...]]]:
    """Methods of `simulate` with the tolerances they are run at."""
    if work.stiff:
        wanted = [
            ("auto", _FEWER),
            ("rosenbrock", (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)),
            ("cvodes", _FEWER),
            ("Radau", (1e-6, 1e-9)),
        ]
    else:
        wanted = [("auto", _FEWER), ("rosenbrock", (1e-4, 1e-6)), ("DOP853", (1e-6,))]
    return [
        (name, tolerances[:2] if quick else tolerances)
        for name, tolerances in wanted
        if name == "auto" or name in METHODS
    ]


def _fixed(system: System) -> list[str]:
    return [name for name in ("step", "step_lie4", "step_variational") if system.has(name)]


def _propagated(system: System, q: np.ndarray, v: np.ndarray, end: float, tol: float) -> np.ndarray:
    found = system.propagate(q, v, 0.0, end, tol)
    if found.outcome != "done":
        raise BenchmarkError(found.outcome)
    return np.concatenate([found.q, found.v])


def _simulated(
    system: System, case: Any, name: str, tol: float | None, h: float | None = None
) -> Callable[[], Any]:
    options: dict[str, Any] = {"h": h} if tol is None else {"tol": tol}

    def solve() -> Any:
        grid = (0.0, case.times[-1] / 2, case.times[-1])
        path = simulate(
            system, (np.array(case.q), np.array(case.v)), grid, method=name, max_steps=100_000_000, **options
        )
        if path.status != "complete":
            raise BenchmarkError(path.reason)
        return path.x[-1]

    return solve


def _heyoka(work: Work, error: Error, quick: bool) -> Iterator[Candidate]:
    import heyoka as hy

    from benchmarks.peers.heyoka.taylor import equations

    hy.llvm_state.set_diskcache_enabled(False)
    case, scene = work.case, work.case.plain()
    for form in work.forms:
        for compact in (False,) if scene.links <= 2 else (False, True):
            start, stop = absolute(scene, form)
            initial = start(np.array([*case.q, *case.v]))
            for tol in (1e-12,) if work.stiff else (1e-9, 1e-12) if quick else TOLERANCES[1:]:
                hy.llvm_state.clear_memcache()
                begin = processor_seconds()
                flow = hy.taylor_adaptive(equations(scene, form), initial, tol=tol, compact_mode=compact)
                setup = processor_seconds() - begin

                def solve(flow: Any = flow, initial: np.ndarray = initial, stop: Any = stop) -> Any:
                    flow.time = 0.0
                    flow.state[:] = initial
                    flow.propagate_until(case.times[-1])
                    return stop(np.array(flow.state))

                label = f"heyoka, {form}" + (", compact" if compact else "")
                yield Candidate(label, f"{tol:.0e}", False, solve, error, setup)


def _sundials(work: Work, error: Error, quick: bool) -> Iterator[Candidate]:
    import casadi as ca

    from benchmarks.peers.casadi_motion import right_hand_side

    case, end = work.case, work.case.times[-1]
    x, f = right_hand_side(case.plain())
    kinds = ("bdf",) if work.stiff else ("adams",)
    for kind in kinds:
        for tol in (1e-9, 1e-12) if quick else (1e-8, 1e-10, 1e-12, 1e-14):
            options = {
                "linear_multistep_method": kind, "reltol": tol, "abstol": tol / 100, "max_num_steps": 100_000_000,
                "jit": True, "compiler": "shell", "jit_options": {"flags": ["-O3", "-march=native"]},
            }  # fmt: skip
            if kind == "adams":
                options["nonlinear_solver_iteration"] = "functional"
            begin = processor_seconds()
            flow = ca.integrator("flow", "cvodes", {"x": x, "ode": f}, 0.0, end, options)
            setup = processor_seconds() - begin
            initial = ca.DM([*case.q, *case.v])
            yield Candidate(
                f"CVODES {'Adams' if kind == 'adams' else 'BDF'} (jit)", f"{tol:.0e}", False,
                lambda flow=flow, initial=initial: np.asarray(flow(x0=initial)["xf"]).ravel(), error, setup,
            )  # fmt: skip


def _scipy(work: Work, error: Error, quick: bool) -> Iterator[Candidate]:
    from scipy.integrate import solve_ivp

    case, end, initial = work.case, work.case.times[-1], np.array([*work.case.q, *work.case.v])
    begin = processor_seconds()
    f = _compiled_field(work)
    setup = processor_seconds() - begin
    if work.stiff:
        system = build(case.scene())
        slope = rhs_jacobian(system)
        chosen = [
            ("Radau", tol, {"jac": lambda t, x: slope(t, x)})
            for tol in (1e-6, 1e-9, *(() if quick else (1e-11,)))
        ]
    else:
        chosen = [("DOP853", tol, {}) for tol in ((1e-9,) if quick else (1e-6, 1e-9, 1e-12))]
        chosen += [("Radau", 1e-6, {})] if work.words == "regular" and not quick else []
    for name, tol, options in chosen:

        def solve(name: str = name, tol: float = tol, options: dict[str, Any] = options) -> Any:
            return solve_ivp(f, (0.0, end), initial, method=name, rtol=tol, atol=tol / 100, **options).y[
                :, -1
            ]

        yield Candidate(f"SciPy {name}, compiled right-hand side", f"{tol:.0e}", False, solve, error, setup)


def _compiled_field(work: Work) -> Callable[[float, np.ndarray], np.ndarray]:
    """x' = f(t, x) as heyoka's compiled function of the whole state: nothing but one call per evaluation.

    The tension form's or the link frame's coordinates are the scene's own.
    """
    import heyoka as hy

    from benchmarks.peers.heyoka.taylor import equations

    form = next(form for form in reversed(work.forms))
    system = equations(work.case.plain(), form)
    function = hy.cfunc([right for _, right in system], vars=[left for left, _ in system], fast_math=True)
    return lambda t, x: function(np.ascontiguousarray(x))


def _mujoco(work: Work, error: Error, quick: bool) -> Iterator[Candidate]:
    import mujoco

    if work.stiff:
        raise BenchmarkError("MuJoCo resets itself on the stiff scene (see the stability table)")
    case, end = work.case, work.case.times[-1]
    begin = processor_seconds()
    model = mujoco_model(case.plain(), "RK4")
    setup = processor_seconds() - begin
    for step in (1e-3,) if quick else (2e-3, 1e-3):

        def solve(step: float = step) -> Any:
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = case.q, case.v
            count = round(end / step)
            model.opt.timestep = end / count
            mujoco.mj_step(model, data, count)
            return np.concatenate([data.qpos, data.qvel])

        yield Candidate("MuJoCo RK4", f"{1e3 * step:g} ms", False, solve, error, setup)
