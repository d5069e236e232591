"""Linear modes where springs and masses spread over decades, against 34 digits of the generalised eigenproblem."""

from __future__ import annotations

import pytest

from phichain.orbits import linear_modes
from phichain.pipeline import build
from phichain.scene import Scene

WANT = ("phi", "phi_jacobian")


@pytest.mark.parametrize("code", ["auto", "loops"])
@pytest.mark.parametrize(
    ("stiffness", "expected"),
    [(1e8, (191492.1272506973, 2088858.723506835)), (1e12, (19149212.70486444, 208885872.3149687))],
)
def test_stiff_springs_leave_the_masses_their_digits(stiffness: float, expected: tuple[float, float], code: str) -> None:
    chain = Scene(
        "sprung", 2, mass=0.1, length=0.1, com=0.05, stiffness=stiffness, gravity=9.81, actuated="none", code=code, want=WANT
    )
    assert linear_modes(build(chain)).omega == pytest.approx(expected, rel=4e-15)


def test_stiffer_springs_are_no_error() -> None:
    """At 1e14 the frequencies are those of 1e12 times ten: gravity is far below."""
    chain = Scene("sprung", 2, mass=0.1, length=0.1, com=0.05, stiffness=1e14, gravity=9.81, actuated="none", want=WANT)
    assert linear_modes(build(chain)).omega == pytest.approx((191492127.0486444, 2088858723.149687), rel=5e-13)
