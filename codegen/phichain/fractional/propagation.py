"""Signal propagation through a chain: section 4 of paper A, Figs 3 to 6.

The direct model (15) turns the generalised forces into a motion in two steps, and each is made continuous:

    u = T - N - G   -->   theta_p = (I^-1)^p u,  0 <= p <= 1          -->   theta'' = theta_1
    theta''         -->   psi_alpha = D^alpha theta'',  -2 <= alpha <= 0   -->   theta = psi_-2 (with initial terms)

The loop closes through the feedback torques N(theta, theta') and G(theta). Both steps are linear in u, so the path of
each part of u can be followed by itself: through N (``"coriolis"``), through G (``"gravity"``), through both
(``"feedback"``), through the input T (``"input"``) and through springs and dampers (``"joints"``); all together are
``"total"``. The parts of theta_p add up to the total, and so do those of D^alpha theta''.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import COUNT, TEXT, TRUTH, VALUES, Schema, names, read_archive, real, refuse
from phichain.errors import ArrayError, SignalError
from phichain.fractional.differintegral import differintegrate
from phichain.fractional.factor import joint_map, refuse_spatial, states_of
from phichain.fractional.inertia import inertia_powers, inertia_spectrum
from phichain.fractional.signals import real_array, supported_orders, uniform_step
from phichain.records import Held, frozen, write_csv, write_npz
from phichain.system import Parameters, System, acceleration

Vector = NDArray[np.float64]

PATHS = ("total", "coriolis", "gravity", "feedback", "input", "joints")
DEFAULT_PATHS = PATHS[:4]
_TABLES = {"forces": ("m", "nv"), "theta_p": ("m", "powers", "nv"), "psi": ("m", "orders", "nv")}
_SCHEMA = Schema(
    "Propagation",
    {
        "time": real("m"),
        "p": real("powers"),
        "alpha": real("orders"),
        **{f"{kind}_{path}": real(*shape, optional=True) for kind, shape in _TABLES.items() for path in PATHS},
    },
    {
        "name": TEXT, "coordinates": names("nv", counted=True), "initial": TRUTH, "order": COUNT, "digest": replace(TEXT, default=""), "params": VALUES,
    },
    filled=("m", "powers", "orders", "nv"),
)  # fmt: skip


class Motion(Protocol):
    """What is read of a trajectory: times (m,), configurations (m, nq), rates (m, nv), inputs (m, nu) or None."""

    @property
    def t(self) -> Vector: ...
    @property
    def q(self) -> Vector: ...
    @property
    def v(self) -> Vector: ...
    @property
    def u(self) -> Vector | None: ...


@dataclass(frozen=True, eq=False)
class Propagation(Held):
    """Surfaces over (t, p) and (t, alpha) for every coordinate and every path.

    Attributes:
        name: Name of the system.
        time: Times, s, shape (m,).
        p: Powers of the inverse inertia matrix, shape (P,).
        alpha: Orders of differintegration, shape (A,).
        forces: Path -> its part of u, N m (N for a cart), shape (m, nv).
        theta_p: Path -> (I^-1)^p times that part, shape (m, P, nv).
        psi: Path -> D^alpha of theta_1, shape (m, A, nv); of the total with the initial terms when `initial` says so,
            and then NaN at the first time for -2 < alpha < 0, where it is unbounded.
        coordinates: Names of the nv coordinates.
        initial: Whether psi of the total holds the initial terms.
        order: Order of convergence of psi in the time step.
        digest: Canonical digest of the system's scene; empty for a system that was made by hand.
        params: Runtime parameters by name.
    """

    name: str
    time: Vector
    p: Vector
    alpha: Vector
    forces: Mapping[str, Vector]
    theta_p: Mapping[str, Vector]
    psi: Mapping[str, Vector]
    coordinates: tuple[str, ...]
    initial: bool
    order: int
    digest: str = ""
    params: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        terms = "with" if self.initial else "without"
        return (
            f"{self.name}: theta_p for {self.p.size} p and psi for {self.alpha.size} alpha ({terms} initial terms) at "
            f"{self.time.size} times, order {self.order}; paths: {', '.join(self.forces)}; "
            f"coordinates: {', '.join(self.coordinates)}"
        )

    def surface(self, kind: str, coordinate: int, path: str = "total") -> Vector:
        """One surface: kind "theta_p" over (t, p), shape (m, P), or "psi" over (t, alpha), shape (m, A).

        Raises:
            SignalError: No such kind or path.
        """
        kinds = {"theta_p": self.theta_p, "psi": self.psi}
        if kind not in kinds or path not in kinds[kind]:
            raise SignalError(
                "surface",
                (kind, path),
                "was not computed",
                f"kinds: {tuple(kinds)}; paths: {tuple(self.forces)}",
            )
        surface: Vector = kinds[kind][path][:, :, coordinate]
        return surface

    def to_csv(self, file: str | Path, kind: str, coordinate: int, path: str = "total") -> None:
        """Write one surface: one row per time, one column per p or alpha."""
        name, values = ("p", self.p) if kind == "theta_p" else ("alpha", self.alpha)
        surface = self.surface(kind, coordinate, path)
        columns = {f"{name}={float(value)!r}": surface[:, k] for k, value in enumerate(values)}
        write_csv(file, {"t": self.time, **columns}, self)

    def to_npz(self, path: str | Path) -> Path:
        """Write everything, exactly; the arrays of a path are named forces_PATH, theta_p_PATH and psi_PATH."""
        tables = {"forces": self.forces, "theta_p": self.theta_p, "psi": self.psi}
        arrays = {f"{kind}_{key}": value for kind, table in tables.items() for key, value in table.items()}
        meta = {name: getattr(self, name) for name in _SCHEMA.fields} | {"kind": _SCHEMA.kind}
        return write_npz(path, {"time": self.time, "p": self.p, "alpha": self.alpha, **arrays}, meta)

    @classmethod
    def from_npz(cls, path: str | Path) -> Propagation:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Propagation, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        tables = {kind: {key: arrays[f"{kind}_{key}"] for key in PATHS if f"{kind}_{key}" in arrays} for kind in _TABLES}
        for kind, table in tables.items():
            if table.keys() != tables["forces"].keys():
                refuse(path, _SCHEMA, kind, sorted(table), "does not hold the paths of the forces")
        forces, theta_p, psi = (MappingProxyType(table) for table in tables.values())
        return cls(
            meta["name"], arrays["time"], arrays["p"], arrays["alpha"], forces, theta_p, psi,
            tuple(meta["coordinates"]), meta["initial"], meta["order"], meta["digest"], frozen(meta["params"]),
        )  # fmt: skip


def propagation(
    system: System,
    motion: Motion,
    p: ArrayLike,
    alpha: ArrayLike,
    *,
    paths: Sequence[str] = DEFAULT_PATHS,
    initial: bool = True,
    order: int = 4,
    params: Parameters | None = None,
    workers: int | None = None,
) -> Propagation:
    """Follow the signals of a motion from the forces to the angles, continuously in p and alpha.

    Args:
        system: A planar chain with the functions `coriolis` and `gravity_torque`; with `forward_dynamics` too, the
            accelerations are taken from it, which matters where masses or lengths spread over decades.
        motion: A Trajectory on a uniform grid (``trajectory.resample(n)`` makes one of any), or anything with t, q,
            v and u.
        p: Powers, 0 (the forces) to 1 (the accelerations).
        alpha: Orders in [-2, 0]: 0 are the accelerations, -2 the coordinates when the initial terms are added.
        paths: Which of `PATHS` to follow.
        initial: Add theta'(0) t^(-1-alpha)/Gamma(-alpha) + theta(0) t^(-2-alpha)/Gamma(-1-alpha) to psi of the total.
        order: Order of the quadrature, 1 to 6.
        params: Runtime parameters by name; None means the system's defaults.
        workers: Threads; None takes one per core.

    Raises:
        UnsupportedError: A spatial scene, with the reason, or a system without the two functions.
        SignalError: A grid that is not uniform, a motion too short or not finite, alpha out of range, unknown paths.
        ArrayError: Shapes that do not fit, or inputs that are missing.
    """
    refuse_spatial(system)
    unknown = [path for path in paths if path not in PATHS]
    if unknown:
        raise SignalError("paths", unknown[0], "there is no such path", f"choose of {PATHS}")
    orders = supported_orders(alpha, -2.0, 0.0)
    _check(system, motion)
    forces = _forces(system, motion, paths, params)
    spectrum = inertia_spectrum(system, motion.q, params, workers=workers)
    powers = np.atleast_1d(real_array("p", p))
    accelerations = _accelerations(system, motion, params)
    theta_p, psi = {}, {}
    for path, force in forces.items():
        known = accelerations.get(path)
        theta_p[path] = inertia_powers(spectrum, force, powers, acceleration=known, workers=workers)
        if known is None:
            known = inertia_powers(spectrum, force, 1.0, workers=workers)[:, 0]
        start = (motion.q[0], motion.v[0]) if initial and path == "total" else None
        surface = differintegrate(motion.t, known, orders, order=order, initial=start, workers=workers)
        psi[path] = surface.values.swapaxes(0, 1)
    return Propagation(
        system.name,
        np.asarray(motion.t, dtype=float),
        powers,
        orders,
        MappingProxyType(forces),
        MappingProxyType(theta_p),
        MappingProxyType(psi),
        system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq)),
        initial,
        order,
        system.digest,
        frozen(system.values(params)),
    )


def _check(system: System, motion: Motion) -> None:
    times, _ = uniform_step(motion.t)
    wanted = {"q": system.nq, "v": system.nv} | ({} if motion.u is None else {"u": system.nu})
    for name, size in wanted.items():
        rows = states_of(system, f"motion.{name}", getattr(motion, name), size)
        if len(rows) != times.size:
            raise ArrayError(
                f"motion.{name}", rows.shape, f"must hold {times.size} rows, one per time", "cut them alike"
            )


def _forces(
    system: System, motion: Motion, paths: Sequence[str], params: Parameters | None
) -> dict[str, Vector]:
    """The parts of u = T - N - G (and springs and dampers) along a motion, each (m, nv)."""
    keywords = system.parameters(params)
    parts = {
        "coriolis": -np.asarray(system.function("coriolis")(motion.q, motion.v, **keywords), dtype=float),
        "gravity": -np.asarray(system.function("gravity_torque")(motion.q, **keywords), dtype=float),
        "input": _input_forces(system, motion),
        "joints": _joint_forces(system, motion, params),
    }
    parts["feedback"] = parts["coriolis"] + parts["gravity"]
    parts["total"] = parts["input"] + parts["feedback"] + parts["joints"]
    return {path: parts[path] for path in paths}


def _accelerations(system: System, motion: Motion, params: Parameters | None) -> dict[str, Vector]:
    """theta'' of the paths whose share the forward dynamics tells, by switching rates and inputs off in turn.

    Empty without `forward_dynamics`. Springs and dampers ride along with gravity and the rates: then the total and
    the input are told alone.
    """
    if not system.has("forward_dynamics"):
        return {}
    q, at_rest = motion.q, np.zeros_like(motion.v)
    total = acceleration(system, q, motion.v, motion.u, params)
    unforced = acceleration(system, q, motion.v, None, params) if system.nu else total
    known = {"total": total, "input": total - unforced}
    if system.joints.is_free and not system.numbers.brakes_cart:
        gravity = acceleration(system, q, at_rest, None, params)
        known |= {"feedback": unforced, "gravity": gravity, "coriolis": unforced - gravity}
    return known


def _input_forces(system: System, motion: Motion) -> Vector:
    """T: the generalised forces of the inputs, (m, nv)."""
    if system.nu == 0:
        return np.zeros((len(motion.t), system.nv))
    if motion.u is None:
        raise ArrayError(
            "motion.u",
            None,
            f"'{system.name}' is actuated but its motion holds no inputs",
            "simulate it on a uniform grid",
        )
    return system.drive.forces(motion.u, system.nv)


def _joint_forces(system: System, motion: Motion, params: Parameters | None) -> Vector:
    """-k (theta - alpha) - d theta' - F tanh(theta' / v_0) of every joint as forces of the scene's angles, and the cart's; (m, nv)."""
    forces = np.zeros((len(motion.t), system.nv))
    relative = (np.eye(system.links) - np.eye(system.links, k=-1)) @ joint_map(system.angles, system.links)
    joints, cart, carts = system.joints, system.numbers, system.cart_size
    bend, rate = (signal[:, carts:] @ relative.T for signal in (motion.q, motion.v))
    bend = bend if joints.rest_angle is None else bend - system.number("rest_angle", params)
    laws = {"stiffness": bend, "damping": rate, "friction": np.tanh(rate / (joints.friction_speed or 1.0))}
    for name, signal in laws.items():
        if getattr(joints, name) is not None:
            forces[:, carts:] += (-system.number(name, params) * signal) @ relative
    speed = motion.v[:, :carts]
    for name, signal in {"cart_damping": speed, "cart_friction": np.tanh(speed / (cart.cart_friction_speed or 1.0))}.items():
        if getattr(cart, name) is not None:
            forces[:, :carts] -= system.number(name, params) * signal
    return forces
