"""Parameters come back from motions made by known ones, with standard errors that say how far off they are."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.identification import fit
from phichain.identification.fit import errors
from phichain.identification.identifiable import directions, reduced
from phichain.identification.measurement import measured
from phichain.identification.model import model
from phichain.identification.unknowns import unknowns
from tests import tables
from tests.fit.measured import (
    DOUBLE,
    KNOWN,
    PUSHED,
    START,
    STICKING,
    TOLD,
    TRUTH,
    motion,
    swung,
    swung_briefly,
    system,
)

TRUE_X0 = [1.5, 0.5, 0.0, 0.0]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_parameters_come_back_within_their_errors(seed: int) -> None:
    found = fit(system(DOUBLE), swung().noisy(1e-3, seed), START, fixed=KNOWN)
    assert found.parameters.keys() == TOLD.keys()
    off = (found.values - [*TOLD.values(), *TRUE_X0]) / found.standard_error
    assert np.abs(off).max() < 4
    # 0.1 % noise on 5000 rows tells every parameter to better than 0.1 %: the bound above is no empty one.
    assert (found.standard_error[:5] < 1e-3 * np.array(list(TOLD.values()))).all()
    assert np.allclose(found.noise, [1e-3 * np.std(column) for column in swung().columns.values()], rtol=0.05)


def test_without_noise_they_are_exact() -> None:
    found = fit(system(DOUBLE), swung_briefly().noisy(0.0, 0), START, fixed=KNOWN)
    assert np.allclose(list(found.parameters.values()), list(TOLD.values()), rtol=1e-9)
    assert np.allclose(found.x0, [1.2, -0.4, 0.3, 0.0], atol=1e-9)
    assert np.abs(found.residual).max() < 1e-9


def test_standard_errors_are_those_of_repeated_measurements() -> None:
    """Linearised at the truth, 400 noises: the spread of (J^T J)^-1 J^T n is what `errors` says, the limits hold 95 %."""
    made = swung_briefly()
    found = fit(system(DOUBLE), made.noisy(1e-3, 3), START, fixed=KNOWN)
    data = measured(system(DOUBLE), made.noisy(0.0, 0))
    truth = {name: np.array(value) for name, value in TRUTH.items()}
    sought = unknowns(system(DOUBLE), truth, None, KNOWN, np.array([1.2, -0.4, 0.3, 0.0]), np.ones(4), True)
    chain = model(system(DOUBLE), data, sought, "held")
    noise = 1e-3 * np.std(data.values, axis=0)
    columns = (chain.columns(np.asarray(sought.z), len(data.t)) / noise[:, None]).reshape(-1, len(sought.z))
    draws = np.random.default_rng(5).standard_normal((len(columns), 400))
    spread = np.std(np.linalg.lstsq(columns, draws, rcond=None)[0] * np.asarray(sought.scale)[:, None], axis=1)
    assert np.allclose(spread, errors(columns)[0] * sought.scale, rtol=0.12)
    assert np.allclose(found.standard_error, spread, rtol=0.2)
    widths = (found.confidence[:, 1] - found.confidence[:, 0]) / found.standard_error
    assert np.allclose(widths, 2 * 1.9639, rtol=1e-3)  # Student's t of 593 degrees of freedom
    assert np.allclose(np.diag(found.correlation), 1.0) and np.abs(found.correlation).max() <= 1 + 1e-12


def test_columns_are_derivatives() -> None:
    """Differences of other steps, extrapolated, agree with the columns to 1e-6 of each, with fine ones to 1e-8."""
    data = measured(system(DOUBLE), swung_briefly().noisy(0.0, 0))
    sought = unknowns(system(DOUBLE), START, None, KNOWN, np.array([1.2, -0.4, 0.3, 0.0]), np.ones(4), True)
    chain, z = model(system(DOUBLE), data, sought, "held"), np.asarray(sought.z)
    rows, found, fine = len(data.t), chain.columns(z, len(data.t)), chain.columns(z, len(data.t), fine=True)
    for j in range(len(z)):
        step = np.zeros(len(z))
        step[j] = 3e-4
        coarse, close = ((chain.predicted(z + k * step, rows) - chain.predicted(z - k * step, rows)) / (6e-4 * k) for k in (2.0, 1.0))
        better = (4 * close - coarse) / 3
        assert np.abs(found[..., j] - better).max() < 1e-6 * np.abs(better).max()
        assert np.abs(fine[..., j] - better).max() < 1e-8 * np.abs(better).max()


def test_one_angle_alone_tells_less_and_says_so() -> None:
    both = swung_briefly().noisy(1e-3, 0)
    one = {name: both[name] for name in ("t", "theta_1")}
    x0 = [1.2, -0.4, 0.3, 0.0]
    less, more = (fit(system(DOUBLE), data, START, fixed=KNOWN, x0=x0) for data in (one, both))
    assert less.columns == ("theta_1",) and (less.standard_error > more.standard_error).all()
    assert (np.abs(less.values - [*TOLD.values(), *x0]) < 4 * less.standard_error).all()


def test_a_known_start_is_kept() -> None:
    x0 = [1.2, -0.4, 0.3, 0.0]
    found = fit(system(DOUBLE), swung_briefly().noisy(1e-3, 1), START, fixed=KNOWN, x0=x0, fit_start=False)
    assert found.names == tuple(TOLD) and found.x0.tolist() == x0
    assert (np.abs(found.values - list(TOLD.values())) < 4 * found.standard_error).all()


@pytest.mark.long
@pytest.mark.parametrize("between", ["held", "linear"])
def test_inputs_are_put_in(between: str) -> None:
    """A cart that is pushed: with a known force even the masses' scale is told."""
    t = np.linspace(0, 1.5, 31)
    force = np.sign(np.sin(5 * t)) if between == "held" else np.sin(5 * t)
    truth = {"mass": [0.2], "cart_mass": 0.5, "cart_damping": 0.3}
    made = motion(PUSHED, truth, [0.0, 0.4, 0.0, 0.0], t, u=(t, force, between))
    start = {"mass": 0.3, "cart_mass": 0.4, "cart_damping": 0.2}
    found = fit(system(PUSHED), {**made.noisy(1e-4, 2), "force": force}, start, between=between)
    true = {"mass_1": 0.2, "cart_mass": 0.5, "cart_damping": 0.3}
    assert found.parameters.keys() == true.keys()
    for name, value in found.parameters.items():
        error = found.standard_error[found.names.index(name)]
        assert abs(value - true[name]) < 4 * error and error < 0.01 * true[name]


def test_dry_friction_and_damping_are_told_apart() -> None:
    made = motion(STICKING, {"damping": [0.004], "friction": [0.01]}, [1.0, 0.0], np.linspace(0, 3, 601))
    found = fit(system(STICKING), made.noisy(1e-3, 0), {"damping": 0.006, "friction": 0.006})
    for name, value in (("damping_1", 0.004), ("friction_1", 0.01)):
        assert abs(found.parameters[name] - value) < 4 * found.standard_error[found.names.index(name)] < 0.3 * value


def test_what_does_not_act_ends_at_its_bound_and_is_remarked() -> None:
    truth = {**TRUTH, "damping": [0.002, 0.0]}
    made = motion(DOUBLE, truth, [1.2, -0.4, 0.3, 0.0], np.linspace(0, 3, 301))
    found = fit(system(DOUBLE), made.noisy(1e-3, 1), START, fixed=KNOWN)
    k = found.names.index("damping_2")
    assert 0 <= found.values[k] < 4 * found.standard_error[k]
    assert any("damping_2" in remark for remark in found.remarks)


def test_blind_directions_of_known_columns() -> None:
    a, b = np.random.default_rng(0).standard_normal((2, 50))
    told = directions(np.column_stack([a, b, 1e3 * a + 1e3 * b, 1e-12 * b]))
    assert told.blind.shape == (2, 4) and np.allclose(told.shares[-1], 1.0)
    ways, heads = reduced(told.blind)
    assert heads == (0, 3) and np.allclose(ways[0], [1, 1, -1e-3, 0], atol=1e-12)
    assert directions(np.column_stack([a, b])).blind.shape == (0, 2)


def test_the_record_is_written_and_pickled(tmp_path) -> None:
    found = fit(system(DOUBLE), swung_briefly().noisy(1e-3, 1), START, fixed=KNOWN)
    text = json.loads(found.to_json(tmp_path / "fit.json").read_text())
    assert text["values"] == found.values.tolist() and text["p"]["mass"] == [0.3, 0.2] and text["rows"] == 301
    table = tables.table(found.to_csv(tmp_path / "fit.csv"))
    assert np.array_equal(table["theta_1_residual"], found.measured[:, 0] - found.fitted[:, 0])
    again = pickle.loads(pickle.dumps(found))
    assert again.p["damping"].tolist() == found.p["damping"].tolist() and str(again) == str(found)
    with pytest.raises(ValueError, match="read-only"):
        found.values[0] = 0


def test_the_page_says_what_runs() -> None:
    page = (Path(__file__).parents[2] / "docs" / "fit.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {}
    exec(code, names)  # noqa: S102 - the page's own example
    found = names["found"]
    for name, true in names["truth"].items():
        error = found.standard_error[found.names.index(f"{name}_1")]
        assert abs(found.parameters[f"{name}_1"] - true[0]) < 4 * error < 0.1 * true[0]
