"""Bad scenes: one clear typed error each, word for word."""

import math

import numpy as np
import pytest

from phichain.errors import SceneError, shown
from phichain.scene import FUNCTIONS, Scene, standard_scene


def make(**changes):
    """Make a two-link chain with some keys changed."""
    return Scene(**({"name": "chain", "links": 2, "mass": 1.0, "length": 1.0} | changes))


CART = {"base": "cart", "cart_mass": 1.0}
SPATIAL = {"space": "spatial"}

WHOLE = "use a whole number from 1 to 4096"
POSITIVE = "use a number above zero"
ACTUATED = 'use "none", "all", "cart" or a list of joints such as [1, 2]'
NUMBER = 'use a number or "runtime"'

BAD_VALUES = [
    ({"links": 0}, f"chain.links: is below 1 (got 0); {WHOLE}"),
    ({"links": -1}, f"chain.links: is below 1 (got -1); {WHOLE}"),
    ({"links": 2.5}, f"chain.links: is not a whole number (got 2.5); {WHOLE}"),
    ({"links": True}, f"chain.links: is not a whole number (got True); {WHOLE}"),
    ({"links": "2"}, f"chain.links: is not a whole number (got '2'); {WHOLE}"),
    ({"links": 10**9}, f"chain.links: is above 4096 (got 1000000000); {WHOLE}"),
    ({"links": 4097}, f"chain.links: is above 4096 (got 4097); {WHOLE}"),
    ({"links": 10**5000}, f"chain.links: is above 4096 (got a number too long to print); {WHOLE}"),
    (
        {"space": "plannar"},
        (
            "chain.space: is not one of the choices (got 'plannar'); "
            'use "planar" or "spatial" (did you mean "planar"?)'
        ),
    ),
    ({"space": 2}, 'chain.space: is not one of the choices (got 2); use "planar" or "spatial"'),
    ({"base": ["cart"]}, 'chain.base: is not one of the choices (got [\'cart\']); use "fixed" or "cart" or "moving"'),
    ({"mass": -1.0}, f"chain.mass: is not positive (got -1.0); {POSITIVE}"),
    ({"mass": [1.0, -1]}, f"chain.mass: entry 2 is not positive (got -1); {POSITIVE}"),
    ({"mass": 0}, f"chain.mass: is not positive (got 0); {POSITIVE}"),
    ({"mass": math.nan}, "chain.mass: is not finite (got nan); use a finite number"),
    ({"mass": [math.inf, 1]}, "chain.mass: entry 1 is not finite (got inf); use a finite number"),
    ({"mass": 10**400}, None),
    ({"mass": True}, f"chain.mass: is not a number (got True); {NUMBER}"),
    ({"mass": np.bool_(True)}, None),
    ({"mass": "heavy"}, f"chain.mass: is not a number (got 'heavy'); {NUMBER}"),
    ({"mass": 1j}, f"chain.mass: is not a number (got 1j); {NUMBER}"),
    ({"mass": None}, f"chain.mass: is not a number (got nothing); {NUMBER}"),
    ({"mass": {1.0, 2.0}}, f"chain.mass: is not a number (got {{1.0, 2.0}}); {NUMBER}"),
    (
        {"mass": ["runtime", 1]},
        "chain.mass: entry 1 is not a number (got 'runtime'); use numbers, or mass = \"runtime\"",
    ),
    (
        {"mass": np.ones((2, 2))},
        'chain.mass: entry 1 is not a number (got [1.0, 1.0]); use numbers, or mass = "runtime"',
    ),
    (
        {"mass": [1, 2, 3]},
        (
            "chain.mass: is a list of length 3, and links = 2 (got [1, 2, 3]); "
            "give one number for all links, or one per link"
        ),
    ),
    ({"length": []}, None),
    ({"length": 5e-324}, None),
    (
        {"mass": 1e300, "length": 1e200},
        (
            "chain.mass: gives link 2 the inertia inf, outside the range of double (got 1e+300); "
            "choose units that keep it from 2.2e-308 to 1.8e+308"
        ),
    ),
    ({"mass": 1e-200, "length": 1e-100}, None),
    (
        {"com": 1.5},
        "chain.com: puts the mass of link 1 beyond the link's length 1.0 (got 1.5); use 0 < com <= length, or give the link an inertia",
    ),
    ({"com": [1.0, math.nextafter(1.0, 2.0)]}, None),
    ({"com": 0}, f"chain.com: is not positive (got 0); {POSITIVE}; a link with inertia may have zero"),
    ({"com": [0.5, -0.5]}, f"chain.com: entry 2 is not positive (got -0.5); {POSITIVE}; a link with inertia may have zero"),
    (
        {"cart_mass": 1.0},
        'chain.cart_mass: needs a cart, and the base is fixed (got 1.0); remove it, or set base = "cart"',
    ),
    (
        {"base": "cart"},
        'chain.cart_mass: is missing on a cart (got nothing); give it, or set base = "fixed"',
    ),
    ({"base": "cart", "cart_mass": 0.0}, f"chain.cart_mass: is not positive (got 0.0); {POSITIVE}"),
    ({"base": "cart", "cart_mass": [1.0]}, f"chain.cart_mass: is not a number (got [1.0]); {NUMBER}"),
    ({"gravity": math.inf}, "chain.gravity: is not finite (got inf); use a finite number"),
    ({"gravity": None}, f"chain.gravity: is not a number (got nothing); {NUMBER}"),
    (
        {"angles": "relativ"},
        (
            "joints.angles: is not one of the choices (got 'relativ'); "
            'use "relative" or "absolute" or "adjacent" (did you mean "relative"?)'
        ),
    ),
    (
        SPATIAL | {"angles": "relative"},
        (
            "joints.angles: is a choice of planar scenes, the links of a spatial one being unit vectors "
            "(got 'relative'); remove it, or set space = \"planar\""
        ),
    ),
    ({"damping": -0.1}, "joints.damping: is negative (got -0.1); use zero or a number above it"),
    ({"stiffness": [0, -1]}, "joints.stiffness: entry 2 is negative (got -1); use zero or a number above it"),
    ({"stiffness": [1, 2, 3]}, None),
    (
        {"actuated": "cart"},
        (
            "joints.actuated: needs a cart, and the base is fixed (got 'cart'); "
            'use "none" or "all", or set base = "cart"'
        ),
    ),
    ({"actuated": 1}, f"joints.actuated: is no kind of actuation (got 1); {ACTUATED}"),
    ({"actuated": True}, f"joints.actuated: is no kind of actuation (got True); {ACTUATED}"),
    ({"actuated": [True]}, f"joints.actuated: lists what is no joint's number (got True); {ACTUATED}"),
    ({"actuated": [1.0]}, f"joints.actuated: lists what is no joint's number (got 1.0); {ACTUATED}"),
    ({"actuated": [0]}, "joints.actuated: is no joint of the chain (got 0); use joints from 1 to 2"),
    ({"actuated": [3]}, "joints.actuated: is no joint of the chain (got 3); use joints from 1 to 2"),
    ({"actuated": []}, 'joints.actuated: lists no joint (got []); use "none"'),
    (CART | {"actuated": []}, 'joints.actuated: lists no joint (got []); use "cart"'),
    (
        {"actuated": [2, 1]},
        "joints.actuated: is not in rising order, each once (got [2, 1]); use [1, 2], the order of u",
    ),
    ({"actuated": [1, 1]}, None),
    (
        {"actuated": [1], "angles": "absolute"},
        (
            "joints.actuated: lists joints, whose torques belong to relative angles, and the angles are absolute "
            '(got [1]); use "all", or set angles = "relative"'
        ),
    ),
    ({"actuated": [1, 2], "angles": "adjacent"}, None),
    (
        SPATIAL | {"actuated": "all"},
        "joints.actuated: asks for joint torques, and spatial joints are not actuated (got 'all'); use \"none\"",
    ),
    (
        SPATIAL | CART | {"actuated": [1]},
        'joints.actuated: asks for joint torques, and spatial joints are not actuated (got [1]); use "cart"',
    ),
    (
        {"want": ["forward_dynamic"]},
        (
            "functions.want: is not a function (got 'forward_dynamic'); did you mean \"forward_dynamics\"? "
            f"The functions are {', '.join(FUNCTIONS)}"
        ),
    ),
    (
        {"want": "forward_dynamics"},
        (
            "functions.want: is not a list of function names (got 'forward_dynamics'); "
            'write want = ["forward_dynamics"]'
        ),
    ),
    ({"want": []}, 'functions.want: asks for no function (got []); write want = ["forward_dynamics"]'),
    (
        {"want": [1]},
        'functions.want: holds what is no function name (got 1); write want = ["forward_dynamics"]',
    ),
    ({"real": "half"}, None),
    (
        {"code": "loop"},
        (
            "target.code: is not one of the choices (got 'loop'); "
            'use "auto" or "unrolled" or "loops" (did you mean "loops"?)'
        ),
    ),
]


@pytest.mark.parametrize(
    ("changes", "message"), BAD_VALUES, ids=[shown(changes) for changes, _ in BAD_VALUES]
)
def test_bad_values_are_refused(changes, message):
    with pytest.raises(SceneError) as caught:
        make(**changes)
    if message is not None:
        assert str(caught.value) == message
    assert caught.value.__cause__ is None
    assert len(str(caught.value).splitlines()) == 1


FLOAT_RANGE = 'choose units that keep it from 1.2e-38 to 3.4e+38, or real = "double"'


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": 1e39}, f"chain.mass: is outside the range of float (got 1e+39); {FLOAT_RANGE}"),
        (
            {"mass": [1, 1e-39]},
            f"chain.mass: entry 2 is outside the range of float (got 1e-39); {FLOAT_RANGE}",
        ),
        ({"gravity": -1e39}, f"chain.gravity: is outside the range of float (got -1e+39); {FLOAT_RANGE}"),
        ({"damping": 1e-50}, f"joints.damping: is outside the range of float (got 1e-50); {FLOAT_RANGE}"),
        (
            {"length": 1e-25},
            "chain.mass: gives link 2 the inertia 1e-50, outside the range of float (got 1.0); "
            + FLOAT_RANGE,
        ),
    ],
)
def test_a_float_scene_refuses_what_float_cannot_hold(changes, message):
    make(**changes)
    with pytest.raises(SceneError) as caught:
        make(real="float", **changes)
    assert str(caught.value) == message


def test_the_range_of_float_is_that_of_numpy():
    info = np.finfo(np.float32)
    for edge in (float(info.max), float(info.tiny)):
        assert make(real="float", gravity=edge).gravity == edge
    with pytest.raises(SceneError):
        make(real="float", gravity=float(info.max) * (1 + 1e-7))
    with pytest.raises(SceneError):
        make(real="float", gravity=float(info.smallest_subnormal))


@pytest.mark.parametrize("links", [0, -1, 2.5, True, 10**9, "4", None])
def test_the_standard_scene_checks_its_number_of_links(links):
    with pytest.raises(SceneError, match=r"^chain\.links: "):
        standard_scene(links)
