"""The public API as a table: what is called, with which arguments, and of which kind each is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from phichain import Scene, build, lqr, simulate, trace
from phichain.continuation import Options
from phichain.control import controllability, equilibrium, feedback, in_phase, linearize
from phichain.fractional import differintegrate, grunwald_letnikov, matrix_power, memory_length
from phichain.motion import Event, Table, Trajectory
from phichain.records import Later
from phichain.scene import load_scene, scene_from_dict
from phichain.system import System, pack, unpack
from phichain.system.propagation import Stop

WANT = (
    "forward_dynamics", "inverse_dynamics", "mass_matrix", "energy", "positions", "linearization", "state_jacobian", "phi",
    "phi_jacobian", "step", "propagate", "propagate_batch", "propagate_stiff", "forward_dynamics_batch",
)  # fmt: skip
PLANAR = Scene("abused", 2, base="cart", cart_mass=1.0, mass="runtime", length=0.5, want=WANT)
SPATIAL = Scene("abused_in_space", 2, "spatial", "cart", cart_mass=1.0, mass=1.0, length=0.5, want=("forward_dynamics", "linearization"))

# Numbers that single precision holds too, so that every layout and type says the same.
Q, V, U, P = np.array([0.25, 0.5, -0.75]), np.array([0.5, -0.25, 1.0]), np.array([0.125]), {"mass": np.array([1.0, 0.5])}
ROWS = np.array([Q, V, -Q])
DIRECTIONS = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Call:
    """One entry of the API.

    Attributes:
        name: Its name.
        run: Calls it on (systems, arguments).
        clean: Arguments that are right.
        kinds: What each argument is: a key of `values.BAD` and `values.SAME`.
        fits: Pairs of an argument and the name of a bad value that is right there.
    """

    name: str
    run: Callable[[Any, dict[str, Any]], Any]
    clean: dict[str, Any]
    kinds: dict[str, str]
    fits: frozenset[tuple[str, str]] = field(default=frozenset())


def systems() -> SimpleNamespace:
    """The systems that all calls share."""
    return SimpleNamespace(planar=build(PLANAR), spatial=build(SPATIAL))


def function(name: str, **arguments: tuple[Any, str]) -> Call:
    """A callable of the planar system."""
    def run(s: Any, given: dict[str, Any]) -> Any:
        return getattr(s.planar, name)(*[given[key] for key in arguments], p=given["p"])

    clean = {key: value for key, (value, _) in arguments.items()} | {"p": P}
    return Call(name, run, clean, {key: kind for key, (_, kind) in arguments.items()} | {"p": "parameters"})


def keyed(name: str, call: Callable[..., Any], fits: tuple[tuple[str, str], ...] = (), **arguments: tuple[Any, str]) -> Call:
    """A function of the systems and of keywords."""
    clean = {key: value for key, (value, _) in arguments.items()}
    kinds = {key: kind for key, (_, kind) in arguments.items() if kind}
    return Call(name, lambda s, given: call(s, **given), clean, kinds, frozenset(fits))


def trajectory(s: Any) -> Trajectory:
    """A short motion."""
    return simulate(s.planar, (Q, V), [0.0, 0.05, 0.1], p=P)


_STATE = {"q": (Q, "vector"), "v": (V, "vector"), "u": (U, "vector")}
_FLOW = {
    "q": (Q, "finite"), "v": (V, "finite"), "t": (0.0, "number"), "t_end": (0.25, "number"), "u": (U, "finite"),
    "max_steps": (1000, "budget"), "lost": (np.zeros(7), "finite"), "p": (P, "parameters"),
}  # fmt: skip
_NONE = (("u", "nothing"), ("lost", "nothing"))

CALLS: tuple[Call, ...] = (
    function("forward_dynamics", **_STATE),
    function("inverse_dynamics", q=(Q, "vector"), v=(V, "vector"), a=(V, "vector")),
    function("mass_matrix", q=(Q, "vector")),
    function("energy", q=(Q, "vector"), v=(V, "vector")),
    function("positions", q=(Q, "vector")),
    function("state_jacobian", **_STATE),
    function("step", h=(0.125, "size"), **_STATE),
    function("phi", amplitude=(Q, "vector"), omega=(2.0, "size")),
    keyed("forward_dynamics of rows", lambda s, q, v, u, p: s.planar.forward_dynamics(q, v, u, p=p),
          q=(ROWS, "rows"), v=(ROWS[::-1].copy(), "rows"), u=(U, ""), p=(P, "parameters")),
    keyed("forward_dynamics_batch", lambda s, q, v, u, p: s.planar.forward_dynamics_batch(q, v, u, p=p),
          q=(ROWS, "rows"), v=(ROWS, "rows"), u=(ROWS[:, :1].copy(), "rows"), p=(P, "parameters")),
    keyed("propagate", lambda s, q, v, t, t_end, tol, **k: s.planar.propagate(q, v, t, t_end, tol, **k), (*_NONE, ("stop", "nothing")),
          tol=(1e-10, "positive"), times=(np.array([0.125]), "times"), stop=(Stop("q", 1, 0.5), "record"), **_FLOW),
    keyed("propagate_stiff", lambda s, q, v, t, t_end, tol, **k: s.planar.propagate_stiff(q, v, t, t_end, tol, **k),
          (*_NONE, ("memory", "nothing")),
          tol=(1e-6, "positive"), times=(np.array([0.125]), "times"), memory=(np.array([0.015625, 0.5]), "finite"), **_FLOW),
    keyed("propagate_batch", lambda s, q, v, t, t_end, tol, **k: s.planar.propagate_batch(q, v, t, t_end, tol, **k),
          (("lost", "nothing"), ("u", "nothing")), q=(ROWS, "finite rows"), v=(ROWS, "finite rows"), t=(0.0, "number"), t_end=(0.25, "number"),
          tol=(1e-10, "positive"), u=(ROWS[:, :1].copy(), "finite rows"), max_steps=(1000, "budget"),
          lost=(np.zeros((3, 7)), "finite rows"), times=(np.array([0.125]), "times"), p=(P, "parameters")),
    keyed("simulate", lambda s, x0, t, **k: simulate(s.planar, x0, t, **k),
          (("u", "nothing"), ("t", "one number"), ("u", "function"), ("events", "nothing"), ("progress", "nothing"), ("tol", "nothing"), ("atol", "nothing"),
           ("events", "empty list"), ("events", "empty mapping"), ("events", "empty text")),
          x0=(np.concatenate([Q, V]), "finite"), t=(np.array([0.0, 0.125, 0.25]), "finite"), tol=(1e-8, "positive"),
          atol=(1e-10, "positive"), u=(U, "finite"), max_steps=(1000, "budget from 1"), method=("DOP853", "word"),
          events=((), "record"), progress=(None, "record"), p=(P, "parameters")),
    keyed("simulate by steps", lambda s, h: simulate(s.planar, (Q, V), [0.0, 0.25], "step", h=h, p=P), h=(0.0625, "positive")),
    keyed("simulate in space", lambda s, x0: simulate(s.spatial, x0, [0.0, 0.125, 0.25], tol=1e-8),
          x0=(np.concatenate([DIRECTIONS, np.zeros(8)]), "finite wide")),
    keyed("simulate with a law", lambda s, answer: simulate(s.planar, (Q, V), [0.0, 0.125], "DOP853", u=lambda t, x: answer, p=P),
          answer=(U, "finite")),
    keyed("simulate with a law that samples",
          lambda s, sample, delay: simulate(s.planar, (Q, V), [0.0, 0.125], u=lambda t, x: U, sample=sample, delay=delay, p=P),
          (("sample", "nothing"), ("delay", "zero")), sample=(0.03125, "positive"), delay=(0.03125, "positive")),
    keyed("Table", lambda s, times, values: Table(times, values), times=(np.array([0.0, 1.0]), "finite"), values=(ROWS[:2].copy(), "finite rows")),
    keyed("simulate with an event", lambda s, answer: simulate(s.planar, (Q, V), [0.0, 0.125], events=lambda t, x: answer, p=P),
          (("answer", "infinite"), ("answer", "minus infinity"), ("answer", "list of one")), answer=(1.0, "number")),
    keyed("Event", lambda s, function, direction: Event("name", function, direction),
          function=(abs, "record"), direction=(1, "direction")),
    keyed("Stop", lambda s, scalar, index, value, direction: Stop(scalar, index, value, direction),
          scalar=("q", "word"), index=(0, "budget"), value=(0.5, "number"), direction=(1, "direction")),
    keyed("resample", lambda s, times: trajectory(s).resample(times), (("times", "longer"),), times=(np.array([0.0, 0.0625]), "finite")),
    keyed("pack", lambda s, q, v: pack(q, v), q=(Q, "loose"), v=(V, "loose")),
    keyed("unpack", lambda s, x: unpack(s.planar, x), (("x", "more dimensions"),), x=(np.concatenate([Q, V]), "vector")),
    keyed("lqr", lambda s, sign, Q, R, p: lqr(s.planar, sign, Q, R, p=p), (("sign", "nothing"), ("Q", "nothing"), ("R", "nothing")),
          sign=((-1, -1), "signs"), Q=(np.ones(6), "weight"), R=(1.0, "positive"), p=(P, "parameters")),
    keyed("lqr in space", lambda s, Q: lqr(s.spatial, (-1, -1), Q), (("Q", "nothing"),), Q=(np.ones(12), "weight")),
    keyed("equilibrium", lambda s, sign: equilibrium(s.planar, sign, P), sign=((1, -1), "signs")),
    keyed("controllability", lambda s, sign: controllability(s.planar, sign, P), sign=((1, -1), "signs")),
    keyed("linearize", lambda s, sign, p: linearize(s.planar, sign, p), sign=((1, -1), "signs"), p=(P, "parameters")),
    keyed("feedback", lambda s, target: feedback(s.planar, lqr(s.planar, p=P), target)(0.0, np.concatenate([Q, V])),
          (("target", "nothing"),), target=(np.array([0.5]), "finite loose")),
    keyed("trace", lambda s, mode, amplitude_max, amplitude_start: trace(
          s.planar, mode, amplitude_max, amplitude_start=amplitude_start, p=P),
          (("amplitude_max", "nothing"), ("amplitude_start", "nothing")), mode=(1, "mode"), amplitude_max=(0.125, "positive"), amplitude_start=(0.0625, "positive")),
    keyed("trace with options", lambda s, options, engine: trace(s.planar, 1, 0.125, options=options, engine=engine, p=P),
          (("options", "nothing"), ("engine", "nothing")), options=(None, "record"), engine=(None, "record")),
    keyed("Options", lambda s, **k: Options(**k), step=(0.02, "positive"), step_max=(0.2, "positive"),
          max_points=(100, "count"), max_iterations=(7, "count"), tol=(1e-11, "positive"), max_angle=(0.3, "positive")),
    keyed("Scene", lambda s, **k: Scene("any", **k), (("com", "nothing"), ("damping", "nothing"), ("actuated", "nothing")),
          links=(2, "links"), mass=(np.array([1.0, 0.5]), "scene numbers"), length=(np.array([1.0, 0.5]), "scene numbers"),
          com=(np.array([0.5, 0.25]), "scene numbers"), gravity=(9.75, "number"), damping=(np.array([1.0, 0.5]), "scene numbers"),
          space=("planar", "word"), base=("fixed", "word"), real=("double", "word"), actuated=("all", "word"), want=(("energy",), "record")),
    keyed("scene_from_dict", lambda s, tables: scene_from_dict(tables), tables=(PLANAR.to_dict(), "record")),
    keyed("load_scene", lambda s, path: load_scene(path), path=("scenes/paper_b.toml", "record")),
    keyed("Trajectory.from_npz", lambda s, path: Trajectory.from_npz(path), path=(None, "path")),
    keyed("differintegrate", lambda s, t, x, alpha: differintegrate(t, x, alpha),
          t=(np.linspace(0.0, 1.0, 9), "finite"), x=(np.linspace(0.0, 1.0, 9) ** 2, "finite"), alpha=(np.array([0.5]), "finite loose")),
    keyed("grunwald_letnikov", lambda s, t, x, alpha: grunwald_letnikov(t, x, alpha),
          t=(np.linspace(0.0, 1.0, 9), "finite"), x=(np.linspace(0.0, 1.0, 9) ** 2, "finite"), alpha=(np.array([0.5]), "finite loose")),
    keyed("matrix_power", lambda s, matrix, p: matrix_power(matrix, p), (("matrix", "complex"),),
          matrix=(np.array([[2.0, 0.5], [0.5, 1.0]]), "square"), p=(0.5, "exponent")),
    keyed("memory_length", lambda s, alpha, tolerance: memory_length(alpha, tolerance),
          alpha=(0.5, "positive"), tolerance=(1e-3, "positive")),
    keyed("in_phase", lambda s, amplitude, omega: in_phase(amplitude, omega)(0.5), amplitude=(Q, "finite loose"), omega=(2.0, "number")),
)  # fmt: skip


def bits(result: Any) -> Any:
    """A result to the last bit, comparable."""
    if isinstance(result, np.ndarray | np.generic):
        return (result.shape, np.ascontiguousarray(result).tobytes())
    if isinstance(result, tuple | list):
        return tuple(map(bits, result))
    if isinstance(result, System):
        return result.digest
    if isinstance(result, Scene):
        return result.digest
    if is_dataclass(result) and not isinstance(result, type):
        result = result.settle() if isinstance(result, Later) else result
        return tuple((name, bits(value)) for name, value in vars(result).items() if not callable(value) and name not in ("reason", "_rest"))
    return repr(result)
