"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.contract.flows import columns_at_most, has_forcing
from phichain.errors import ArrayError, UnsupportedError
from phichain.native.flows.beside import Beside, Watched
from phichain.native.flows.bound import Bound, bound_struct
from phichain.native.flows.brake import Brake, Braking
from phichain.native.flows.call import FlowCall, calls, event_argument, flow_call
from phichain.native.flows.checks import checked_tolerance, demand_alone, finite, forcing_of
from phichain.native.flows.checks import own as own_copy
from phichain.native.flows.desk import Table
from phichain.native.flows.motion import Frame, Frames
from phichain.native.flows.structs import struct_type
from phichain.native.memory.arrays import SCALAR, place
from phichain.native.memory.room import demand_room
from phichain.native.memory.wide import kept_wide, wide
from phichain.native.signature import Argument
from phichain.system.arrays import whole
from phichain.system.propagation import OUTCOMES, Propagation, Stop

Propagate = Callable[..., Propagation]


@calls("propagate")
def make_propagate(
    chain: Chain, parameters: Sequence[Argument], function: Any, go: Any, watched: Watched | None = None, braking: Braking | None = None
) -> Propagate:
    """Wrap NAME_propagate.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
        go: The same by the one pointer of a bound call; likewise.
        watched: The same that leaves its steps, and what flies beside these, where there is one.
        braking: Brake orbits on it, where they are compiled.

    Returns:
        ``propagate(q, v, t, t_end, tol, *, u, forcing, times, own, stop, max_steps, lost, transition, along, p) -> Propagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held, `forcing` = (amplitude, omega) of a forced scene is A cos(omega t); `times` in the order of travel, between t and
        t_end, or `own` for the ends of its own steps; `transition` (nq + nv, m) holds derivatives of (q, v) at t that are carried to where it ends, the
        identity for the whole state transition matrix; `along` says by name how parameters move along its columns, each (n, m)
        where the scene varies them.
        `beside` is what its ``beside()``, where it has that, made for one run: it takes the steps of every call, and its `errors` are those of the run's rows.
        Its ``bind(tol, *, u, forcing, stop, columns, max_steps, p) -> Bound`` checks all that stays once, for short flows in loops.
        Its ``brake(scale, tol, rough, max_steps, p) -> Brake``, where it has that, finds brake orbits.
    """
    call = flow_call("propagate", chain, parameters, function)
    most = columns_at_most(chain)
    is_variational, is_forced, frames = bool(chain.variational), has_forcing(chain), Frames(call)
    tables: list[Table] = []  # of brake orbits that nobody has any more, where no parameters make them different
    bounded, go.restype = struct_type(bound_struct(chain), chain), SCALAR[call.kind.name]

    def propagate(
        q: ArrayLike,
        v: ArrayLike,
        t: float,
        t_end: float,
        tol: float,
        *,
        u: ArrayLike | None = None,
        forcing: Sequence[float] | None = None,
        times: ArrayLike = (),
        own: bool = False,
        stop: Stop | None = None,
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        transition: ArrayLike | None = None,
        along: Mapping[str, ArrayLike] | None = None,
        p: Mapping[str, Any] | None = None,
        beside: Beside | None = None,
    ) -> Propagation:
        frame = frames.take()
        frame.beside = beside
        t, t_end, budget = frame.begin(q, v, u, (t, t_end), max_steps, lost, p)
        flow, carried = frame.flow, None
        flow.tolerance = checked_tolerance("propagate.tol", tol)
        if transition is not None:
            carried = _columns(transition, is_variational, call, most)
            flow.transition, flow.columns = place(carried), carried.shape[1]
        directions = None if along is None else _directions(along, carried, chain.varied, call)
        if directions is not None:
            flow.along = place(directions)
        passed = None
        if carried is not None and chain.varied and np.size(times):
            demand_room("propagate.times", np.size(times), carried.size, call.kind)
            passed = np.empty((np.size(times), *carried.shape), call.kind)
            flow.passed = place(passed)
        driven = forcing_of(call.name, forcing, is_forced, call.kind)
        if driven is not None:
            frame.force(*driven)
        event = event_argument(call, stop)
        frame.given["event"].value = event and ctypes.addressof(event)
        if own:
            demand_alone(call.name, times)
        result, (t_at, q_at, v_at) = frame.own(budget) if own else frame.at(times, t, t_end, budget)
        frame.beside = None
        del directions
        columns_at = None if passed is None else wide(passed[: flow.written])
        matrix = None if carried is None else kept_wide(carried)
        found = Propagation.made(
            outcome=OUTCOMES[result], **frame.reached(), q_at=q_at, v_at=v_at, t_at=t_at, order=flow.order, transition=matrix, columns_at=columns_at,
        )  # fmt: skip
        frames.give(frame)
        return found

    def bind(
        tol: float,
        *,
        u: ArrayLike | None = None,
        forcing: Sequence[float] | None = None,
        stop: Stop | None = None,
        columns: int = 0,
        max_steps: int = 1_000_000,
        p: Mapping[str, Any] | None = None,
    ) -> Bound:
        if whole("propagate.columns", columns, 0, 2**31, "give a number of derivatives, nq + nv for all", ArrayError):
            _columns(np.eye(sum(call.sizes[:2]), columns), is_variational, call, most)
        frame = Frame(call, columns)
        q, v = (np.zeros(size) for size in call.sizes[:2])
        for is_ready in (False, True):
            *_, budget = frame.begin(q, v, u, (0.0, 0.0), max_steps, None, p)
            if not is_ready:
                frame.make_room()
        frame.flow.tolerance = checked_tolerance("propagate.tol", tol)
        if frame.columns is not None:
            frame.columns[...] = np.eye(*frame.columns.shape)
            frame.flow.transition, frame.flow.columns = place(frame.columns), columns
        driven = forcing_of(call.name, forcing, is_forced, call.kind)
        if driven is not None:
            frame.force(*driven)
        event = event_argument(call, stop)
        frame.given["event"].value = event and ctypes.addressof(event)
        return Bound(frame, event, bounded(), go, budget)

    def brake(scale: ArrayLike, tol: float, rough: float, max_steps: int, p: Mapping[str, Any] | None = None) -> Brake:
        assert braking is not None
        problem = np.asarray(scale, float), tol, rough, max_steps
        return Brake(braking, idle, *problem, tables.append) if p is None else Brake(braking, partial(table, deepcopy(p)), *problem)

    def table(p: Mapping[str, Any] | None) -> Table:
        return Table(bind(1.0, columns=2 * chain.links, p=p), chain.nq, chain.links)

    def idle() -> Table:
        try:
            return tables.pop()
        except IndexError:
            return table(None)

    vars(propagate)["bind"] = bind
    if braking is not None:
        vars(propagate)["brake"] = brake
    if watched is not None:
        watched.function.restype = function.restype
        vars(propagate)["beside"] = partial(Beside, watched)
    return propagate


def _directions(
    along: Mapping[str, ArrayLike], carried: NDArray[Any] | None, varied: Mapping[str, int], call: FlowCall
) -> NDArray[Any]:
    """How what is varied moves along every column, in the order of the C; what is not named stands still.

    Raises:
        ArrayError: There are no columns, a name is none of the scene's, or its numbers do not fit the columns.
    """
    if carried is None:
        raise ArrayError("propagate.along", along, "is given without columns", "pass transition, too, such as variations(...) makes")
    count, rows = carried.shape[1], []
    for name in along:
        if name not in varied:
            remedy = f"use {', '.join(varied)}" if varied else 'name it in the scene, as [flow] variational = ["state", "mass"]'
            raise ArrayError(f"propagate.along.{name}", along[name], "is nothing that the flow carries derivatives by", remedy)
    for name, size in varied.items():
        given = own_copy(f"propagate.along.{name}", along.get(name, np.zeros((size, count))), call.kind)
        if given.shape not in ((size, count), *([(count,)] if size == 1 else [])):
            raise ArrayError(f"propagate.along.{name}", given.shape, f"must have shape ({size}, {count})", "give a row for each of its numbers")
        rows.append(finite(f"propagate.along.{name}", given).reshape(size, count))
    return np.ascontiguousarray(np.concatenate(rows))


def _columns(value: ArrayLike, is_variational: bool, call: FlowCall, most: int) -> NDArray[Any]:
    """A copy of columns of derivatives that C may change."""
    size = sum(call.sizes[:2])
    if not is_variational:
        raise UnsupportedError(
            "propagate.transition", np.shape(value), "asks for derivatives that the scene does not carry along",
            "set variational = true in its table [flow]",
        )  # fmt: skip
    array = own_copy("propagate.transition", value, call.kind)
    if array.ndim != 2 or array.shape[0] != size or not 1 <= array.shape[1] <= most:
        raise ArrayError(
            "propagate.transition", array.shape, f"must have shape ({size}, m), m from 1 to {most}",
            f"start with the identity, np.eye({size})",
        )  # fmt: skip
    return finite("propagate.transition", array)
