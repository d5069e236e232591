"""The table of functions: whoever serves a row is there, its arguments are those of the Program, and what lacks is one error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from phichain.contract.functions import (
    FUNCTIONS,
    ON_REQUEST,
    PLANAR_FUNCTIONS,
    SPATIAL_FUNCTIONS,
    TABLE,
    Sample,
)
from phichain.contract.registry import ANY, Registry
from phichain.emit.flow.flows import PRINTERS, FlowText
from phichain.errors import ContractError
from phichain.lowering import lower, lower_function
from phichain.lowering.writers import WRITERS, writes
from phichain.mechanics import derive
from phichain.native.flows.call import CALLERS
from phichain.pipeline import build, generate
from phichain.reference import reference
from phichain.reference.case import JUDGES, judges
from phichain.scene import Scene
from tests.lowering.chains import kinds, label
from tests.offered import offered

SPACES = ("planar", "spatial")
DUO = Scene("duo", 2, mass=1.0, length=1.0, want=["forward_dynamics", "energy", "propagate"])


def test_the_order_of_the_contract_is_public() -> None:
    """The generated files follow it: a new function finds its place, none of these changes hers."""
    assert [name for name in FUNCTIONS if name in PUBLIC] == list(PUBLIC)


PUBLIC = (
    "forward_dynamics", "forward_dynamics_batch", "direction_dynamics", "inverse_dynamics", "mass_matrix", "coriolis",
    "gravity_torque", "energy", "positions", "linearization", "state_jacobian", "phi", "phi_jacobian", "step", "step_lie4",
    "step_variational", "step_rosenbrock", "propagate", "propagate_stiff", "propagate_batch", "project",
)  # fmt: skip


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.name)
def test_every_row_is_served(row: Any) -> None:
    if row.flow:
        assert PRINTERS.has(row.name) and CALLERS.has(row.name)
        return
    assert JUDGES.has(row.name)
    written = row.derivative.function if row.derivative else row.name
    for space in SPACES:
        if row.absence(Sample(space == "planar")) is None:
            assert WRITERS.has(written, space), space


def test_what_is_on_request_says_why_and_stands_in_no_list_of_all() -> None:
    for row in TABLE:
        assert (row.name in ON_REQUEST) == bool(row.on_request)
    assert not set(ON_REQUEST) & {*PLANAR_FUNCTIONS, *SPATIAL_FUNCTIONS}


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds(2)][::3], ids=label)
def test_a_program_has_the_arguments_of_its_row(chain: Scene) -> None:
    """Jacobians too, which a transform makes: names, extents and words, inputs before outputs."""
    rows = {row.name: row for row in TABLE}
    for name in offered(chain.space, chain.damping is not None):
        program = lower_function(derive(chain), name, "loops")
        made = [(array.name, array.shape, array.doc) for array in (*program.inputs, *program.outputs)]
        assert made == [(a.name, a.shape(chain), a.doc) for a in rows[name].arguments_of(chain)], name
        assert program.doc == rows[name].doc


@pytest.mark.parametrize("chain", [*kinds(2)][::5], ids=label)
def test_the_reference_has_the_results_of_its_row(chain: Scene) -> None:
    zeros = {argument.name: argument.shape(chain) for row in TABLE for argument in row.arguments if argument.direction == "in"}
    inputs: dict[str, Any] = {name: [0.25] * shape[0] if shape else 0.25 for name, shape in zeros.items()}
    inputs["s"] = [1.0] * chain.links
    params = {name: [0.5] * chain.links if chain.runtime_shapes[name] else 0.5 for name in chain.runtime}
    for row in TABLE:
        if row.name not in offered(chain.space, chain.damping is not None) or row.derivative:
            continue
        found = reference(chain, row.name, inputs, digits=15, params=params)
        assert set(row.outputs_in_reference(chain).values()) <= set(found), row.name


# --- what lacks is one error -------------------------------------------------------------------------------------------


def without(monkeypatch: pytest.MonkeyPatch, registry: Registry[Any], name: str) -> None:
    """Take away whatever serves a function."""
    for key in [key for key in registry.entries if key[0] == name]:
        monkeypatch.delitem(registry.entries, key)


@pytest.mark.parametrize(
    ("registry", "name", "missing", "message"),
    [
        (
            WRITERS, "energy", "writer",
            "function: has no writer for planar scenes (got 'energy'); register one in phichain.lowering",
        ),
        (JUDGES, "energy", "reference", "function: has no reference (got 'energy'); register one in phichain.reference"),
        (PRINTERS, "propagate", "printer", "function: has no printer (got 'propagate'); register one in phichain.emit.flow"),
    ],
)  # fmt: skip
def test_a_row_that_nobody_serves_says_what_is_missing(
    registry: Registry[Any], name: str, missing: str, message: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """And nothing is written."""
    without(monkeypatch, registry, name)
    with pytest.raises(ContractError) as caught:
        generate(DUO, tmp_path)
    assert str(caught.value) == message
    assert caught.value.missing == missing and caught.value.value == name
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("answer", [{}, {"kinetic": 0}, {"potentials": 1}, None])
def test_a_reference_that_gives_no_such_result_says_so(
    answer: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(JUDGES.entries, ("energy", ""), lambda case: answer)
    with pytest.raises(ContractError, match=r"has a reference that gives no (kinetic and no )?potential \(got 'energy'\)") as caught:
        generate(DUO, tmp_path)
    assert caught.value.missing == "reference" and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("names", [("one",), ("one", "two", "three")])
def test_a_row_that_names_other_results_of_its_reference_says_so(names: tuple[str, ...]) -> None:
    row = replace(next(row for row in TABLE if row.name == "energy"), reference=names)
    with pytest.raises(ContractError, match=rf"names {len(names)} results of its reference and has 2") as caught:
        row.outputs_in_reference(DUO)
    assert caught.value.missing == "row"


def test_a_writer_of_the_other_kind_of_chain_serves_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delitem(WRITERS.entries, ("energy", "spatial"))
    with pytest.raises(ContractError, match=r"has no writer for spatial scenes \(got 'energy'\)"):
        generate(Scene("duo", 2, "spatial", mass=1.0, length=1.0, want=["energy"]), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_flow_without_a_callable_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, CALLERS, "propagate")
    with pytest.raises(ContractError, match=r"has no callable \(got 'propagate'\)"):
        build(DUO)


def test_a_derivative_leans_on_the_writer_of_its_function(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, WRITERS, "forward_dynamics")
    with pytest.raises(ContractError, match="has no writer for planar scenes"):
        lower(derive(Scene("duo", 2, mass=1.0, length=1.0, want=["state_jacobian"])))


def test_what_has_no_row_is_not_registered() -> None:
    with pytest.raises(ContractError, match="has a writer and no row in the table of functions") as caught:
        writes("enegry", space="planar")(lambda: None)
    assert caught.value.missing == "row"
    with pytest.raises(ContractError, match="has a reference and no row"):
        judges("enegry")(lambda case: {})


def test_nothing_is_registered_twice() -> None:
    with pytest.raises(ContractError, match="has more than one writer"):
        writes("energy", space="planar")(lambda: None)
    registry: Registry[FlowText] = Registry("phichain.emit.flow", "printer")
    registry.add("propagate", FlowText("", "", (), frozenset()))
    with pytest.raises(ContractError, match="has more than one printer"):
        registry.add("propagate", FlowText("", "", (), frozenset()))


def test_every_writer_is_a_row_or_is_called_by_one() -> None:
    called = {callee for writer in WRITERS.entries.values() for callee in writer.calls}
    own_programs_of_flows = {"rosenbrock_increment", "bent_increment", "dynamics_of_many", "dynamics_of_prepared"}
    for name, variant in WRITERS.entries:
        assert name in FUNCTIONS or name in called | own_programs_of_flows, name
        assert variant in (ANY, *SPACES)
