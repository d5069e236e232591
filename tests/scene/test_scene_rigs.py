"""Scenes of rigs: inertia, friction, motors, driven and moving bases, each value as it is kept or refused in one sentence."""

import pytest

from phichain.errors import SceneError
from phichain.scene import Scene, scene_from_dict

CART = {"base": "cart", "cart_mass": 1.0}
SPATIAL = {"space": "spatial"}
SPEED = "joints.friction_speed, rad/s at joints and m/s on a cart"


def make(**changes):
    """Make a two-link chain with some keys changed."""
    return Scene(**({"name": "chain", "links": 2, "mass": 1.0, "length": 1.0} | changes))


BAD_VALUES = [
    ({"inertia": -1}, "chain.inertia: is negative (got -1); use zero or a number above it"),
    ({"com": 0}, "chain.com: is not positive (got 0); use a number above zero; a link with inertia may have zero"),
    (
        {"com": 0, "inertia": [1, 0]},
        ("chain.com: puts the mass of link 2 on its joint, and the link has no inertia (got 0.0); "
        "use 0 < com <= length, or give the link an inertia"),
    ),
    (
        {"com": 2, "inertia": [0, 1]},
        ("chain.com: puts the mass of link 1 beyond the link's length 1.0 (got 2.0); "
        "use 0 < com <= length, or give the link an inertia"),
    ),
    (
        SPATIAL | {"armature": 1},
        ("joints.armature: is the inertia of a motor at a joint, and spatial joints are not actuated (got 1); "
        'remove it, or set space = "planar"'),
    ),
    (
        {"friction": 1},
        ("joints.friction: needs the speed v_0 below which it fades, in F tanh(v / v_0) (got (1.0, 1.0)); " f"give {SPEED}"),
    ),
    (
        CART | {"cart_friction": 2},
        ("chain.cart_friction: needs the speed v_0 below which it fades, in F tanh(v / v_0) (got 2.0); " f"give {SPEED}"),
    ),
    ({"friction_speed": 0.1}, "joints.friction_speed: is the speed of a friction that nothing has (got 0.1); give joints.friction, or remove it"),
    ({"friction": 1, "friction_speed": 0}, "joints.friction_speed: is not positive (got 0); use a number above zero"),
    (
        {"friction": 1, "friction_speed": "runtime"},
        "joints.friction_speed: is no number (got 'runtime'); give a number: it regularises a law and is known beforehand",
    ),
    ({"drive": "force"}, "chain.drive: needs a cart, and the base is fixed (got 'force'); remove it, or set base = \"cart\""),
    (
        CART | {"drive": "acceleration", "actuated": "none"},
        ("chain.drive: makes the cart's acceleration an input, and nothing is actuated (got 'acceleration'); "
        'use actuated = "cart", or drive = "force"'),
    ),
    (
        {"base": "moving", "cart_mass": 1.0},
        "chain.cart_mass: needs a cart, and the base is moving (got 1.0); remove it, or set base = \"cart\"",
    ),
    (
        {"base": "moving", "actuated": "cart"},
        ("joints.actuated: needs a cart, and the base is moving (got 'cart'); "
        'use "none" or "all", or set base = "cart"'),
    ),
    ({"cart_damping": 1}, "chain.cart_damping: needs a cart, and the base is fixed (got 1); remove it, or set base = \"cart\""),
    (
        CART | {"damping": [1, 1, 1]},
        ("joints.damping: has 3 entries, one too many for the joints of 2 links (got [1, 1, 1]); "
        "give one per joint; the cart's is chain.cart_damping"),
    ),
    ({"rest_angle": 1}, "joints.rest_angle: needs springs, and the joints have none (got 1); give joints.stiffness, or remove it"),
    (
        SPATIAL | {"stiffness": 1, "rest_angle": 1},
        ("joints.rest_angle: is an angle of a planar joint, and the springs of spatial ones rest along the link before (got 1); "
        'remove it, or set space = "planar"'),
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD_VALUES)
def test_bad_values_are_refused(changes, message):
    with pytest.raises(SceneError) as caught:
        make(**changes)
    assert str(caught.value) == message


NOTHING = {
    "inertia": 0,
    "armature": [0, 0],
    "friction": 0.0,
    "stiffness": 0,
    "cart_damping": 0,
    "cart_friction": 0,
    "drive": "force",
}


@pytest.mark.parametrize("key", NOTHING)
def test_what_is_asked_as_nothing_is_the_scene_that_does_not_ask(key):
    assert make(**CART, **{key: NOTHING[key]}) == make(**CART)
    assert make(**CART, **{key: NOTHING[key]}).digest == make(**CART).digest


def test_a_link_with_inertia_may_have_its_centre_anywhere():
    assert make(com=[0, 3], inertia=[1, 0.5]).com == (0.0, 3.0)
    assert make(com=0, inertia="runtime").com == (0.0, 0.0)
    assert not make(inertia=1).tip_masses


def test_a_cart_takes_the_joints_speed_of_friction_unless_it_has_its_own():
    shared = make(**CART, cart_friction=1, friction_speed=0.1)
    assert (shared.friction_speed, shared.cart_friction_speed) == (None, 0.1)
    own = make(**CART, cart_friction=1, friction=2, friction_speed=0.1, cart_friction_speed=0.2)
    assert (own.friction_speed, own.cart_friction_speed) == (0.1, 0.2)


def test_inputs_of_driven_and_moving_bases_have_names():
    assert make(**CART, drive="acceleration").u_names == ("acceleration",)
    assert make(base="cart", drive="acceleration", **SPATIAL).u_names == ("acceleration_1", "acceleration_2")
    moving = make(base="moving", actuated=[2])
    assert moving.u_names == ("base_acceleration_1", "base_acceleration_2", "torque_2")
    assert (moving.nq, moving.nu) == (2, 3)
    assert make(base="moving", **SPATIAL).nu == 3


def test_a_rig_is_read_back_as_itself():
    rig = make(
        **CART, com=0.0, inertia="runtime", cart_damping=0.5, cart_friction="runtime", friction_speed=0.1, friction=[0.1, 0],
        damping=1, stiffness=2, rest_angle=[0.1, -0.2], armature=[0, 0.25], drive="acceleration",
    )  # fmt: skip
    again = scene_from_dict(rig.to_dict())
    assert again == rig and again.digest == rig.digest
    assert rig.runtime == ("inertia", "cart_friction")
    for word in ("inertia runtime", "friction 0.1 (v_0 0.1)", "armature 0.25", "(rest -0.2)", "<-> acceleration"):
        assert word in str(rig)
