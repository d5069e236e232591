"""Columns that the flow carries are those of differences, and a fit with them is the same one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.app.commands.fit import followed
from phichain.identification import fit
from phichain.identification.fit import _start
from phichain.identification.measurement import measured
from phichain.identification.model import model
from phichain.identification.unknowns import unknowns
from phichain.pipeline import build
from tests.fit.measured import DOUBLE, KNOWN, START, TOLD, TRUTH, motion, swung_briefly, system


@pytest.fixture(scope="module")
def carrying() -> Any:
    return build(followed(DOUBLE, START), prove=False)


@pytest.mark.long
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


def test_a_strongly_chaotic_motion_settles_over_pieces(carrying: Any) -> None:
    """Small changes grow 10^7 fold in 10 s: SciPy's steps end up to 8 standard errors away, in a valley too narrow for them."""
    x0 = [2.13, -0.24, 0.51, 1.47]
    made = motion(DOUBLE, TRUTH, x0, np.linspace(0, 10, 5001))
    found = fit(carrying, made.noisy(1e-3, 56), START, fixed=KNOWN)
    off = (found.values - [*TOLD.values(), *x0]) / found.standard_error
    assert np.abs(off).max() < 4
    assert (found.standard_error[:5] < 1e-3 * np.array(list(TOLD.values()))).all()
    residual = (found.residual / found.noise) ** 2
    assert np.sum(residual) < 2 * 5001 + 4 * np.sqrt(4 * 5001)
