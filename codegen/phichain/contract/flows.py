"""The flows: structs, arguments and results of the C functions that run over many steps or states, once for C and Python.

The header prints them (`emit.flow.declared`), `native.flows` makes ctypes of them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from phichain.contract.chain import Chain
from phichain.contract.flow import Field, Flow, Outcome, Passed, Struct

SCALARS: Final = ("q", "v", "depth")
"""The scalars whose sign change ends a flow, in the order of their numbers in C."""


def has_params(chain: Chain) -> bool:
    """Some parameters come at run time."""
    return bool(chain.runtime)


def has_input(chain: Chain) -> bool:
    """Something is actuated."""
    return chain.nu > 0


def _nq(chain: Chain) -> int:
    return chain.nq


def _nv(chain: Chain) -> int:
    return chain.nv


def _nu(chain: Chain) -> int:
    return chain.nu


def _state_size(chain: Chain) -> int:
    return chain.nq + chain.nv


def has_forcing(chain: Chain) -> bool:
    """A harmonic drives it."""
    return chain.forced is not None


def _unit_of_forcing(chain: Chain) -> str:
    return "N m" if isinstance(chain.forced, int) else chain.base_law.unit


def _is_forced_there(chain: Chain) -> str:
    if isinstance(chain.forced, int):
        return f"the torque at joint {chain.forced}"
    return chain.base_law.driven + ("" if chain.is_planar and chain.has_cart else f" along axis {chain.axis}")


def _is_variational(chain: Chain) -> bool:
    return bool(chain.variational)


def _has_varied(chain: Chain) -> bool:
    return bool(chain.varied)


def columns_at_most(chain: Chain) -> int:
    """How many columns a flow carries at most: one by every entry of the state, and by every number that is varied."""
    return _state_size(chain) + sum(chain.varied.values())


def _directions(chain: Chain) -> str:
    names = ", ".join(name if size == 1 else f"{name} ({size})" for name, size in chain.varied.items())
    return f"in: how {names} move along each column, {sum(chain.varied.values())} x columns, or NULL"


# --- structs ---------------------------------------------------------------------------------------------------------

_EVENT_FIELDS: Final = (
    Field("scalar", "int", "one of the three above"),
    Field("index", "int", "an entry of q or v, or a link, from 0; it is not checked"),
    Field("value", "real"),
    Field("direction", "int", "+1 only where it rises along the way, -1 only where it falls, 0 both"),
)
EVENT: Final = Struct("event", _EVENT_FIELDS, remarks_at=21)
BATCH_EVENT: Final = replace(EVENT, name="batch_event")

_TOLERANCE: Final = Field("tolerance", "real", "in, out")
_START: Final = Field("t", "real", "in: start, s; out: time reached")
_LOST: Final = (
    Field("t_lost", "real", "what rounding took from t and from the state: the next step adds it"),
    Field("lost", "real", extent=_state_size),
)
_WRITTEN: Final = Field("written", "unsigned long", "out: how many of the times were reached")
_OWN: Final = Field("own", "real", "out, without times: when its own steps ended, as many as count; or NULL", is_pointer=True)
_ORDER: Final = Field("order", "int", "out: order of the Taylor series")

FLOW: Final = Struct(
    "flow",
    (
        _START,
        _TOLERANCE,
        *_LOST,
        Field("transition", "real", "in, out: the columns", is_pointer=True, present=_is_variational),
        Field("columns", "int", lambda chain: f"in: how many, at most {columns_at_most(chain)}; 0 for none", present=_is_variational),
        Field("along", "real", _directions, is_pointer=True, present=_has_varied),
        Field(
            "passed", "real", lambda chain: f"out: the columns at the times on the way, count x {_state_size(chain)} x columns, or NULL",
            is_pointer=True, present=_has_varied,
        ),
        _OWN,
        Field("work", "workspace", "in: where it works, the caller's; on cache lines it is fastest", is_pointer=True),
        Field("steps", "unsigned long", "out: steps taken"),
        _WRITTEN,
        _ORDER,
    ),
    remarks_at=24,
)  # fmt: skip
"""What one trajectory of the Taylor flow carries beside its state."""

STIFF: Final = Struct(
    "stiff",
    (
        _START,
        _TOLERANCE,
        Field("step", "real", "in: size of the first step, s, or 0; out: that of the next"),
        Field("before", "real", "error of the last step, relative to what was aimed at"),
        *_LOST,
        _OWN,
        Field("work", "stiff_workspace", "in: where it works, the caller's", is_pointer=True),
        Field("steps", "unsigned long", "out: steps taken"),
        Field("refused", "unsigned long", "out: steps tried and not taken"),
        _WRITTEN,
    ),
    remarks_at=26,
)
"""The same of the implicit flow."""

FLOW_BATCH: Final = Struct(
    "flow_batch",
    (
        _TOLERANCE,
        _ORDER,
        Field("t", "real", "in: n starts, s; out: times reached", is_pointer=True),
        Field(
            "lost", "real",
            lambda chain: f"in, out: {_state_size(chain) + 1} x n, lost of t and of the state by rounding; first 0",
            is_pointer=True,
        ),
        Field("steps", "unsigned long", "out: n numbers of steps taken", is_pointer=True),
        Field("written", "unsigned long", "out: n numbers of times reached", is_pointer=True),
        Field("result", "int", "out: n of the above", is_pointer=True),
    ),
    remarks_at=26,
)  # fmt: skip
"""What n trajectories of the Taylor flow carry."""

# --- results ---------------------------------------------------------------------------------------------------------

DONE: Final = Outcome("done", 0, "t_end was reached")
_MET: Final = Outcome("event", 1, "the event was met; t, q and v are there")
_BUDGET: Final = Outcome("step budget", 2, "max_steps steps were taken")
_NOT_FINITE: Final = Outcome(
    "not finite", 3, "the state, or a coefficient of its Taylor series, is not finite from t on"
)
NO_WORKSPACE: Final = Outcome("no workspace", 4, "flow->work is NULL; flow->steps says how many bytes it wants")

OUTCOMES: Final = (DONE, _MET, _BUDGET, _NOT_FINITE)
"""How a motion can end."""

# --- arguments -------------------------------------------------------------------------------------------------------

_P: Final = Passed("p", "params", "in", "parameters", "pointer", present=has_params)
_CARRIED: Final = Passed("flow", "flow", "in, out", "start time and tolerance; what was done", "pointer")
_T_END: Final = Passed("t_end", "real", "in", "final time, s")
_BUDGET_OF_STEPS: Final = Passed(
    "max_steps", "unsigned long", "in", "step budget; called again, it goes on from where it stopped"
)
_U: Final = Passed("u", "real", "in", "inputs, held constant", "array", _nu, present=has_input)
_FORCING: Final = (
    Passed(
        "amplitude", "real", "in", lambda chain: f"A of the forcing, {_unit_of_forcing(chain)}: A cos(omega t) beside u is {_is_forced_there(chain)}",
        present=has_forcing,
    ),
    Passed("omega", "real", "in", "its angular frequency, rad/s", present=has_forcing),
)  # fmt: skip
_STATE: Final = (
    Passed("q", "real", "in, out", "state", "array", _nq, is_restrict=True, heading="q, v"),
    Passed("v", "real", "in, out", "", "array", _nv, is_restrict=True),
)
_WHERE_TO_STOP: Final = Passed("event", "event", "in", "where to stop, or NULL", "pointer")
_TIMES: Final = (
    Passed("count", "unsigned long", "in", "number of times"),
    Passed("times", "real", "in", "times on the way, in its order, at which the state is wanted, or NULL", "pointer"),
)
_STATES_THERE: Final = (
    Passed("q_out", "real", "out", lambda chain: f"configurations there, count x {chain.nq}, or NULL", "pointer"),
    Passed("v_out", "real", "out", lambda chain: f"rates there, count x {chain.nv}, or NULL", "pointer"),
)

PROPAGATE: Final = Flow(
    (_P, _CARRIED, _T_END, _BUDGET_OF_STEPS, _U, *_FORCING, *_STATE, _WHERE_TO_STOP, *_TIMES, *_STATES_THERE),
    returns="int",
    carries=FLOW,
    event=EVENT,
    outcomes=(*OUTCOMES, NO_WORKSPACE),
)

PROPAGATE_STIFF: Final = Flow(
    (
        _P,
        replace(_CARRIED, type="stiff"),
        _T_END,
        replace(_BUDGET_OF_STEPS, doc="step budget, refused steps included; called again, it goes on from where it stopped"),
        _U,
        *_STATE,
        *_TIMES,
        *_STATES_THERE,
    ),
    returns="int",
    carries=STIFF,
    prefix="STIFF_",
    outcomes=(
        DONE,
        replace(_BUDGET, doc="max_steps steps were tried"),
        replace(_NOT_FINITE, doc="no step, however short, leads to finite numbers within the tolerance from t on"),
        NO_WORKSPACE,
    ),
)  # fmt: skip

PROPAGATE_BATCH: Final = Flow(
    (
        replace(_P, doc="parameters, the same for all"),
        Passed("n", "size_t", "in", "number of trajectories"),
        Passed("flow", "flow_batch", "in, out", "start times and tolerance; what was done", "pointer"),
        Passed("t_end", "real", "in", "n final times, s", "array"),
        replace(_BUDGET_OF_STEPS, doc="step budget of each; called again, it goes on from where it stopped"),
        Passed("u", "real", "in", lambda chain: f"{chain.nu} x n, inputs, held constant", "array", present=has_input),
        replace(_FORCING[0], form="array", doc=lambda chain: f"n numbers A, {_unit_of_forcing(chain)}: A cos(omega t) beside u is {_is_forced_there(chain)}"),
        replace(_FORCING[1], form="array", doc="n angular frequencies, rad/s"),
        Passed("q", "real", "in, out", lambda chain: f"{chain.nq} x n, configurations", "array"),
        Passed("v", "real", "in, out", lambda chain: f"{chain.nv} x n, rates", "array"),
        replace(_WHERE_TO_STOP, type="batch_event"),
        _TIMES[0],
        replace(_TIMES[1], doc="times on the way of all, in its order, at which the states are wanted, or NULL"),
        replace(_STATES_THERE[0], doc=lambda chain: f"configurations there, count x {chain.nq} x n, or NULL"),
        replace(_STATES_THERE[1], doc=lambda chain: f"rates there, count x {chain.nv} x n, or NULL"),
        Passed("work", "real", "-", lambda chain: f"{chain.name.upper()}_BATCH_WORK numbers", "array"),
    ),
    returns="size_t",
    carries=FLOW_BATCH,
    event=BATCH_EVENT,
    prefix="BATCH_",
    outcomes=(replace(DONE, doc="its t_end was reached"), *OUTCOMES[1:]),
)  # fmt: skip

FORWARD_DYNAMICS_BATCH: Final = Flow(
    (
        replace(_P, doc="runtime parameters, the same for all"),
        Passed("n", "size_t", "in", "number of states"),
        Passed("q", "real", "in", lambda chain: f"{chain.nq} x n, configuration", "array"),
        Passed("v", "real", "in", lambda chain: f"{chain.nv} x n, rates", "array"),
        Passed("u", "real", "in", lambda chain: f"{chain.nu} x n, inputs", "array", present=has_input),
        Passed("a", "real", "out", lambda chain: f"{chain.nv} x n, accelerations", "array", is_restrict=True),
    ),
    returns="void",
)  # fmt: skip

PREPARE: Final = Flow(
    (
        replace(_P, doc="runtime parameters"),
        Passed("prepared", "prepared", "out", "what they alone determine; it holds until they change", "pointer"),
    ),
    returns="void",
)

PREPARED_DYNAMICS: Final = Flow(
    (
        Passed("prepared", "prepared", "in", lambda chain: f"what {chain.name}_prepare left", "pointer"),
        Passed("q", "real", "in", "configuration", "array", _nq),
        Passed("v", "real", "in", "rates", "array", _nv),
        replace(_U, doc="inputs"),
        Passed("a", "real", "out", "accelerations", "array", _nv, is_restrict=True),
    ),
    returns="void",
)
"""NAME_forward_dynamics_prepared, which comes with `prepare`."""
