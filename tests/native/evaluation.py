"""Every function of the small generated folder at once, and what it is held against."""

from __future__ import annotations

from typing import Any

import numpy as np

from phichain.system import System
from tests.native.generated_folder import PARAMETERS

Q, V, U = np.array([0.1, -0.2]), np.array([0.3, -0.4]), np.array([0.5, -0.6])
RTOL = 4e-15


def evaluated(system: System, q: Any, v: Any, u: Any, h: Any) -> dict[str, Any]:
    """Every function that `expected` knows."""
    return {
        "forward_dynamics": system.forward_dynamics(q, v, u, p=PARAMETERS),
        "mass_matrix": system.mass_matrix(q, p=PARAMETERS),
        "energy": system.energy(q, v, p=PARAMETERS),
        "step": system.step(h, q, v, u, p=PARAMETERS),
    }


def assert_close(got: dict[str, Any], wanted: dict[str, Any], rtol: float = RTOL) -> None:
    assert got.keys() == wanted.keys()
    for name, values in wanted.items():
        outputs = values if isinstance(values, tuple) else (values,)
        for actual, value in zip(
            got[name] if isinstance(values, tuple) else (got[name],), outputs, strict=True
        ):
            assert np.shape(actual) == np.shape(value), name
            np.testing.assert_allclose(actual, value, rtol=rtol, atol=rtol, err_msg=name)
