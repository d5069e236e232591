"""C text of the Taylor flow called by one pointer: a call of a microsecond is spent on handing over what stays the same."""

from __future__ import annotations

from collections.abc import Iterable

from phichain.contract.chain import Chain
from phichain.contract.flow import Field
from phichain.native.flows.bound import bound_struct


def bound_symbol(name: str) -> str:
    """Name of the function; its one argument is a NAME_bound, and it returns the time reached."""
    return f"{name}_propagate_bound"


def bound_source(chain: Chain) -> str:
    """The struct and the function, behind the declarations of NAME.h.

    What is over within the steps that need no way out for Ctrl-C ends here. All else returns no number, and the caller goes on.
    """
    name, struct = chain.name, bound_struct(chain)
    skipped = ("t", "brief", "begun", "steps", "outcome")
    passed = ["given->brief" if field.name == "max_steps" else f"given->{field.name}" for field in struct.fields_of(chain) if field.name not in skipped]
    return _SOURCE.replace("FIELDS", "\n".join(_fields(name, struct.fields_of(chain)))).replace("PASSED", ", ".join(passed)).replace(
        "SYMBOL", bound_symbol(name)
    ).replace("CAPITALS", name.upper()).replace("NAME", name)  # fmt: skip


def _fields(name: str, fields: Iterable[Field]) -> Iterable[str]:
    for field in fields:
        kind = "void *" if field.is_pointer else f"{name}_real " if field.type == "real" else f"{field.type} "
        yield f"    {kind}{field.name};"


_SOURCE = """\
typedef struct {
FIELDS
} NAME_bound;

NAME_real SYMBOL(NAME_bound *given);
NAME_real SYMBOL(NAME_bound *given)
{
    NAME_flow *flow = given->flow;
    memcpy(flow, given->begun, sizeof *flow);
    flow->t = given->t;
    given->outcome = CAPITALS_STEP_BUDGET;
    given->steps = 0;
    if (given->brief > 0) {
        given->outcome = NAME_propagate(PASSED);
        given->steps = flow->steps;
    }
    return given->outcome == CAPITALS_STEP_BUDGET ? (NAME_real)NAN : flow->t;
}
"""
