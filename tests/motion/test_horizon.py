"""Forty chaotic runs of 60 s: what they say of their errors, beside the errors that they have.

The references are in binary128, by another library on the dense closed form (`benchmarks/horizon/make_references.py`); the table
of `python -m benchmarks.horizon` has more methods.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.horizon.cases import CASES, Case
from benchmarks.horizon.judge import LOOSE, run

WAYS = (("taylor", None), ("taylor", LOOSE), ("DOP853", None), ("DOP853", LOOSE))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize(("method", "tol"), WAYS, ids=lambda word: str(word))
def test_an_estimate_is_no_less_than_a_tenth_of_the_error_and_no_more_than_a_hundredfold(case: Case, method: str, tol: float | None) -> None:
    found = run(case, method, tol)
    assert np.count_nonzero(found.counts) >= 3
    assert np.min(found.ratio) >= 0.1 and np.max(found.ratio) <= 100
    assert found.unmarked < 1e-2
    assert (found.status == "doubtful") == (found.holds_until < 60.0)
