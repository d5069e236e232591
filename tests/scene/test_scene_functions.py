"""Functions that a scene does not have: the refusal names what to use instead."""

import re
from pathlib import Path

import pytest

from phichain.app.console import arguments, chains
from phichain.contract.functions import FUNCTIONS, ROWS
from phichain.errors import UnsupportedError
from phichain.scene import Scene


def make(**changes):
    """Make a two-link chain with some keys changed."""
    return Scene(**({"name": "chain", "links": 2, "mass": 1.0, "length": 1.0} | changes))


CART = {"base": "cart", "cart_mass": 1.0}
SPATIAL = {"space": "spatial"}


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        (
            "inverse_dynamics",
            SPATIAL,
            (
                "functions.want: is defined on planar scenes alone, since spatial joints are not actuated "
                '(got \'inverse_dynamics\'); use "mass_matrix", "coriolis" and "gravity_torque": '
                "the force is M a + coriolis + gravity_torque"
            ),
        ),
        (
            "phi",
            SPATIAL,
            (
                "functions.want: is defined on planar scenes alone, since a spatial link has no scalar amplitude "
                '(got \'phi\'); use "linearization" for small motions, "step" for large ones, or space = "planar"'
            ),
        ),
        (
            "phi_jacobian",
            {"damping": [0, 0.1]},
            (
                "functions.want: needs an undamped scene, since damped links have no in-phase periodic motion "
                '(got \'phi_jacobian\'); use "linearization" for the decaying modes, "step" for the motion, '
                "or remove joints.damping"
            ),
        ),
        ("phi", {"damping": "runtime"}, None),
        (
            "project",
            {},
            (
                "functions.want: has no meaning on a planar scene, whose angles need no projection (got 'project'); "
                "remove it; project belongs to the unit vectors of spatial scenes"
            ),
        ),
        (
            "direction_dynamics",
            {},
            (
                "functions.want: is defined on spatial scenes alone, since a planar link has an angle and no unit vector "
                "(got 'direction_dynamics'); use \"forward_dynamics\", whose accelerations are those of the angles"
            ),
        ),
    ],
)
def test_functions_that_a_scene_does_not_have_name_what_to_use_instead(name, changes, message):
    with pytest.raises(UnsupportedError) as caught:
        make(want=["forward_dynamics", name], **changes)
    if message is not None:
        assert str(caught.value) == message


@pytest.mark.parametrize("name", ["phi", "phi_jacobian"])
def test_phi_is_there_again_when_every_damper_is_zero(name):
    assert make(want=[name], damping=0.0, stiffness=1.0).want == (name,)


def test_the_documentation_lists_every_function_with_its_arguments_and_where_it_is():
    """docs/functions.md, one row each in the contract's order."""
    page = (Path(__file__).parents[2] / "docs" / "functions.md").read_text()
    table = page[page.index("| function |") :]
    rows = [re.split(r" \| ", row.strip("| ")) for row in table.splitlines() if row.startswith("| `")]
    assert [name.strip("`") for name, *_ in rows] == list(FUNCTIONS)
    for name, given, _, where in rows:
        row = ROWS[name.strip("`")]
        assert given in (arguments(row), "see the header" if row.flow else None), name
        assert where == chains(row), name
