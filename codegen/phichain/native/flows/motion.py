"""One call of a flow of a single trajectory: memory and arguments that C already knows, filled and read.

What does not change from call to call is made once: the state's memory, the struct, and every argument as ctypes hands it over.
A frame serves one call at a time and goes back to its pool afterwards, so threads never share one.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.flows import NO_WORKSPACE
from phichain.errors import ArrayError
from phichain.native.flows.beside import Beside, Desk
from phichain.native.flows.call import FlowCall
from phichain.native.flows.checks import demand_rounding, output_times, step_budget, time_of, vector
from phichain.native.memory.arrays import SCALAR, place
from phichain.native.memory.parameters import ParameterBlock
from phichain.native.memory.slots import slot
from phichain.native.memory.wide import wide
from phichain.system.propagation import OUTCOMES

#: On which boundary a workspace is fastest.
_CACHE_LINE: Final = 64
#: Bytes that the ends of a flow's own steps may take in one call: what is not written costs none, but above 4 MiB NumPy asks for
#: huge pages, and the first number written clears 2 MiB.
ROOM: Final = 2**20


class Frame:
    """Memory of one call.

    Attributes:
        flow: The struct that C carries.
        given: The arguments of C by name, as ctypes.
        steps: Steps taken so far.
        refused: Steps tried and not taken so far, of flows that count them.
        beside: What takes the steps of the next call, None for nothing.
        moving: All that moves, in one piece of memory: q, v and, row by row, the columns.
        columns: Memory of derivatives of (q, v), or None where none are wanted.
    """

    def __init__(self, call: FlowCall, columns: int = 0) -> None:
        """Allocate for a flow, and for so many columns of derivatives that are to lie beside the state."""
        nq, nv, nu, _ = call.sizes
        kind, nx = call.kind, nq + nv
        self.moving = np.zeros(nx * (1 + columns), kind)
        self.columns = self.moving[nx:].reshape(nx, columns) if columns else None
        self._call, self.flow, self.steps, self.refused, self._desk = call, call.carried(), 0, 0, 0
        self._refuses = hasattr(self.flow, "refused")
        self._parameters = ParameterBlock(call.signature, kind)
        self._state = {"q": self.moving[:nq], "v": self.moving[nq:nx], "u": np.zeros(nu, kind)}
        self._take = {name: slot(values.shape, values).take for name, values in self._state.items()}
        self._nothing = {name: np.zeros(len(values), kind) for name, values in self._state.items()}
        number = SCALAR[kind.name]
        self._lost = np.frombuffer((number * (1 + nq + nv)).from_buffer(self.flow, type(self.flow).t_lost.offset), kind)
        self._size, self._at = ctypes.sizeof(self.flow), ctypes.addressof(self.flow)
        known = {**self._state, "p": self._parameters.values}
        self.given = {
            name: convert(0) if isinstance(convert, type) else ctypes.c_void_p(place(known[name]) if name in known else None)
            for name, convert in call.takes
        }
        self.given["flow"].value = self._at
        self._arguments = tuple(self.given.values())
        self._t_end, self._max_steps = self.given["t_end"], self.given["max_steps"]
        self._outputs = tuple(self.given[name] for name in ("count", "times", "q_out", "v_out"))
        self._briefly = getattr(call.function, "briefly", call.function)
        self._has_u, self._has_p = "u" in self.given, "p" in self.given
        self.beside: Beside | None = None
        self._noted: Desk | None = None
        self._ends: tuple[NDArray[Any], ...] = ()
        self._ends_at: tuple[int, ...] = ()
        self._none = (wide(np.empty(0)), wide(np.empty((0, nq))), wide(np.empty((0, nv))))

    def begin(
        self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None, span: tuple[float, float], max_steps: int, lost: ArrayLike | None,
        p: Mapping[str, Any] | None,
    ) -> tuple[float, float, int]:  # fmt: skip
        """Take a state, the span and what is held.

        Returns:
            Start, end and budget, as C can hold them.

        Raises:
            ArrayError: A vector, a time or a parameter is not what C could take.
            ToleranceError: The budget is none.
        """
        name, kind, flow = self._call.name, self._call.kind, self.flow
        ctypes.memset(self._at, 0, self._size)
        t, t_end = time_of(f"{name}.t", span[0], kind), time_of(f"{name}.t_end", span[1], kind)
        self._fill("q", q)
        self._fill("v", v)
        self._t_end.value = t_end
        budget = step_budget(name, max_steps)
        flow.t = t
        if self._desk:
            flow.work = self._desk
        if self._has_u:
            self._fill("u", self._nothing["u"] if u is None else u)
        elif u is not None and np.size(u):
            raise ArrayError(f"{name}.u", u, "is given to a chain that has no input", "leave u out, or actuate the scene")
        if lost is not None:
            self._lost[...] = vector(f"{name}.lost", lost, self._lost.size, np.dtype(float))
            demand_rounding(f"{name}.lost", self._lost[0], t_end - t)
        if self._has_p or p is not None:
            self._parameters.fill(p)
        self.steps = self.refused = 0
        return t, t_end, budget

    def _fill(self, name: str, value: ArrayLike) -> None:
        memory, is_taken = self._state[name], False
        if type(value) is np.ndarray and value.dtype is memory.dtype and value.shape == memory.shape:
            memory[...], is_taken = value, True
        # Nothing times a number that is not finite is none.
        if not (is_taken or self._take[name](value)) or self._nothing[name].dot(memory) != 0:
            memory[...] = vector(f"{self._call.name}.{name}", value, memory.size, memory.dtype)

    def force(self, amplitude: NDArray[Any], omega: NDArray[Any]) -> None:
        """Take a forcing: one amplitude and one frequency.

        Raises:
            ArrayError: They are more.
        """
        for name, value in (("amplitude", amplitude), ("omega", omega)):
            if value.shape:
                raise ArrayError(f"{self._call.name}.forcing", value.shape, f"holds no single {name}", "give forcing=(amplitude, omega)")
            self.given[name].value = float(value)

    def at(self, times: ArrayLike, t: float, t_end: float, budget: int) -> tuple[int, Passed]:
        """Run, and the states at given times.

        Args:
            times: Where states are wanted, in the order of travel.
            t: Start.
            t_end: End.
            budget: Step budget.

        Raises:
            ArrayError: The times do not lie in the order of travel.
        """
        if isinstance(times, tuple) and not times:
            self._point_to(0, None, None, None)
            return self._to_the_end(budget), self._none
        grid = output_times(self._call.name, times, t, t_end, sum(self._call.sizes[:2]), self._call.kind)
        q_at, v_at = self._rows(len(grid), grid)
        result, written = self._in_pieces(budget, (grid, q_at, v_at))
        return result, (wide(grid[:written]), wide(q_at[:written]), wide(v_at[:written]))

    def _in_pieces(self, budget: int, rows: tuple[NDArray[Any], ...]) -> tuple[int, int]:
        """Run, in one call of C unless steps are kept and fill their room: then it goes on as if it had not stopped."""
        most = budget if self.beside is None else min(budget, self._most)
        self._max_steps.value = most
        result, written = self._called()
        while OUTCOMES[result] == "step budget" and self.steps + self.refused < budget:
            self._max_steps.value = min(budget - self.steps - self.refused, most)
            self._point_to(len(rows[0]) - written, *(place(array[written:]) if len(array) > written else None for array in rows))
            result, more = self._called(goes_on=True)
            written += more
        return result, written

    def _to_the_end(self, budget: int) -> int:
        """Run, the first steps without a way out for Ctrl-C: a short run costs half as much without one."""
        if self.beside is not None:
            return self._in_pieces(budget, (np.empty(0),) * 3)[0]
        brief = min(self._call.brief, budget)
        if brief:
            self._max_steps.value = brief
            result, _ = self._called(self._briefly)
            if OUTCOMES[result] != "step budget" or brief == budget:
                return result
        self._max_steps.value = budget - brief
        return self._called()[0]

    def own(self, budget: int) -> tuple[int, Passed]:
        """Run, and the states at the ends of the flow's own steps: one call of C unless they are very many."""
        found = []
        while True:
            count = min(budget - self.steps - self.refused, self._most)
            self._max_steps.value = count
            times, q_at, v_at = self._room_for_ends(count)
            self.flow.own, *rows = self._ends_at
            self._point_to(count, None, *rows)
            result, written = self._called()
            if written:  # the last of them is where it ended: the state itself, to the last bit
                q_at[written - 1], v_at[written - 1] = self._state["q"], self._state["v"]
            found.append((wide(times[:written]), wide(q_at[:written]), wide(v_at[:written])))
            if OUTCOMES[result] != "step budget" or self.steps + self.refused >= budget:
                break
        return result, found[0] if len(found) == 1 else tuple(map(np.concatenate, zip(*found, strict=True)))

    @property
    def _most(self) -> int:
        """Steps of one call whose ends are kept."""
        nq, nv, _, _ = self._call.sizes
        return max(1, ROOM // (self._call.kind.itemsize * (1 + nq + nv)))

    def _room_for_ends(self, count: int) -> tuple[NDArray[Any], ...]:
        """Memory of so many ends of steps, kept for the next call: fresh pages cost as much as a short flow."""
        if not self._ends or len(self._ends[0]) < count:
            nq, nv, _, _ = self._call.sizes
            self._ends = tuple(np.empty(shape, self._call.kind) for shape in (count, (count, nq), (count, nv)))
            self._ends_at = tuple(map(place, self._ends))
        return self._ends

    def _called(self, function: Callable[..., int] | None = None, goes_on: bool = False) -> tuple[int, int]:
        """Call C, and how many rows it wrote."""
        function, arguments = function or self._call.function, self._arguments
        beside = self.beside
        if beside is not None:
            self._noted = desk = self._noted or Desk(beside.watched, self._most)
            desk.go_on(goes_on)
            function, arguments = beside.watched.function, (*arguments, *desk.arguments)
        result = int(function(*arguments))
        if result == NO_WORKSPACE.number:
            self._room = np.empty(self.flow.steps + _CACHE_LINE, np.uint8)
            self.flow.work = self._desk = -(-place(self._room) // _CACHE_LINE) * _CACHE_LINE
            result = int(function(*arguments))
        self.steps += self.flow.steps
        if self._refuses:
            self.refused += self.flow.refused
        if beside is not None:
            beside.keep(desk.taken(self.flow.steps), self._held(), self.flow.tolerance)
        return result, self.flow.written

    def _held(self) -> tuple[NDArray[Any], ...]:
        """Copies of what stays the same over a run: parameters and input, as far as C takes any."""
        known = (("p", self._parameters.values), ("u", self._state["u"]))
        return tuple(values.copy() for name, values in known if name in self.given)

    def memory(self, name: str) -> NDArray[Any]:
        """The memory of q, v or u that C reads."""
        return self._state[name]

    @property
    def lost(self) -> NDArray[np.float64]:
        """What rounding took from t and from the state (1 + nq + nv,)."""
        return wide(self._lost)

    @property
    def brief(self) -> int:
        """Steps after which C comes back for Ctrl-C, 0 where it never has to."""
        return self._call.brief

    @property
    def function(self) -> Any:
        """The foreign function, which Ctrl-C leaves at any time."""
        return self._call.function

    def make_room(self) -> None:
        """Have the workspace ready, if C wants one: a run of no length."""
        self._point_to(0, None, None, None)
        self._called()

    def reached(self) -> dict[str, Any]:
        """Where it ended, as the fields of `Propagation` that all flows fill."""
        return {
            "t": self.flow.t, "q": wide(self._state["q"]), "v": wide(self._state["v"]), "tol": self.flow.tolerance, "steps": self.steps,
            "lost": wide(self._lost),
        }  # fmt: skip

    def _rows(self, count: int, times: NDArray[Any] | None) -> tuple[NDArray[Any], NDArray[Any]]:
        nq, nv, _, _ = self._call.sizes
        q_at, v_at = np.empty((count, nq), self._call.kind), np.empty((count, nv), self._call.kind)
        self._point_to(count, None if times is None else place(times), place(q_at), place(v_at))
        return q_at, v_at

    def _point_to(self, count: int, times: int | None, q_at: int | None, v_at: int | None) -> None:
        """Say where C finds times and leaves states."""
        number, *pointers = self._outputs
        number.value, pointers[0].value, pointers[1].value, pointers[2].value = count, times, q_at, v_at


Passed = tuple[NDArray[np.float64], ...]
"""Times, configurations and rates that were passed on the way."""


class Frames:
    """The frames of a flow that nobody uses."""

    def __init__(self, call: FlowCall) -> None:
        """Keep frames of a flow."""
        self._call = call
        self._idle: list[Frame] = []

    def take(self) -> Frame:
        """A frame for one call; `give` it back when it is done; one whose call broke off is let go."""
        try:
            return self._idle.pop()
        except IndexError:
            return Frame(self._call)

    def give(self, frame: Frame) -> None:
        """Keep a frame for the next call."""
        self._idle.append(frame)
