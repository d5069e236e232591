"""Columns that the flow carries are those of differences, and a fit with them is the same one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.app.cli_fit import followed
from phichain.identification import fit
from phichain.identification.fit import _start
from phichain.identification.measurement import measured
from phichain.identification.model import model
from phichain.identification.unknowns import unknowns
from phichain.pipeline import build
from tests.fit.measured import DOUBLE, KNOWN, START, swung_briefly, system


@pytest.fixture(scope="module")
def carrying() -> Any:
    return build(followed(DOUBLE, START), prove=False)


def test_carried_columns_are_differences(carrying: Any) -> None:
    """At rows and, where inputs change between them, over their breaks."""
    made = swung_briefly().noisy(0.0, 0)
    found = []
    for chain in (carrying, system(DOUBLE)):
        data = measured(chain, made)
        first, sizes = _start(chain, data)
        sought = unknowns(chain, START, None, KNOWN, first, sizes, True)
        mine = model(chain, data, sought, "held")
        assert mine.is_exact is (chain is carrying)
        found.append(mine.columns(np.asarray(sought.z), 300, fine=True))
    exact, differenced = found
    scale = np.abs(differenced).max(axis=(0, 1))
    assert (np.abs(exact - differenced).max(axis=(0, 1)) < 1e-8 * scale).all()


def test_the_fit_is_the_same(carrying: Any) -> None:
    made = swung_briefly().noisy(1e-3, 1)
    one, other = (fit(chain, made, START, fixed=KNOWN) for chain in (carrying, system(DOUBLE)))
    np.testing.assert_allclose(one.values, other.values, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(one.standard_error, other.standard_error, rtol=1e-5)
    assert one.iterations <= 2 * other.iterations
