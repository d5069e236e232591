"""Scenes: defaults, broadcasting, normalisation, sizes and names."""

import copy
import dataclasses
import pickle
from fractions import Fraction

import numpy as np
import pytest

from phichain.errors import UnsupportedError
from phichain.scene import FUNCTIONS, PLANAR_FUNCTIONS, Scene, standard_scene
from tests.offered import offered


def planar(links=3, **changes):
    return Scene("chain", links, **({"mass": 1.0, "length": 2.0} | changes))


def spatial(links=3, **changes):
    return planar(links, **({"space": "spatial"} | changes))


def test_defaults_on_a_fixed_base():
    scene = planar()
    assert (scene.space, scene.base, scene.angles) == ("planar", "fixed", "relative")
    assert (scene.mass, scene.length, scene.gravity) == ((1.0,) * 3, (2.0,) * 3, 9.81)
    assert scene.com is scene.cart_mass is scene.damping is scene.stiffness is None
    assert (scene.actuated, scene.want, scene.real, scene.code) == (
        "none",
        ("forward_dynamics",),
        "double",
        "auto",
    )


def test_defaults_on_a_spatial_cart():
    scene = spatial(base="cart", cart_mass=5)
    assert (scene.angles, scene.actuated, scene.cart_mass) == (None, "cart", 5.0)


@pytest.mark.parametrize(
    "mass",
    [1, 1.0, Fraction(1), np.float32(1.0), [1, 1, 1], (1.0, 1, 1), np.ones(3), np.ones(3, dtype=np.int32)],
    ids=repr,
)
def test_numbers_and_lists_of_any_kind_become_floats(mass):
    scene = planar(mass=mass)
    assert scene == planar()
    assert {type(entry) for entry in scene.mass} == {float}


@pytest.mark.parametrize(
    ("com", "kept"),
    [(None, None), (2.0, None), ([2, 2, 2], None), ([2, 2, 1], (2.0, 2.0, 1.0)), ("runtime", "runtime")],
)
def test_masses_at_the_tips_are_known_structurally(com, kept):
    scene = planar(com=com)
    assert scene.com == kept
    assert scene.tip_masses == (kept is None)


def test_a_com_cannot_be_compared_with_a_runtime_length():
    assert planar(length="runtime", com=2.0).com == (2.0, 2.0, 2.0)


@pytest.mark.parametrize("key", ["damping", "stiffness"])
def test_all_zero_joint_laws_are_absent(key):
    assert getattr(planar(**{key: 0}), key) is None
    assert getattr(planar(**{key: [0.0, -0.0, 0]}), key) is None
    assert getattr(planar(**{key: [0, 0.5, 0]}), key) == (0.0, 0.5, 0.0)


def test_wanted_functions_come_in_the_order_of_the_contract_each_once():
    scene = planar(want=["step", "energy", "forward_dynamics", "energy"])
    assert scene.want == ("forward_dynamics", "energy", "step")


def test_the_list_of_every_joint_means_all():
    assert planar(actuated=[1, 2, 3]) == planar(actuated="all")
    assert planar(actuated=np.array([1, 3])).actuated == (1, 3)


@pytest.mark.parametrize(
    ("scene", "sizes"),
    [
        (planar(), (3, 3, 0)),
        (planar(actuated="all"), (3, 3, 3)),
        (planar(actuated=[2]), (3, 3, 1)),
        (planar(base="cart", cart_mass=1), (4, 4, 1)),
        (planar(base="cart", cart_mass=1, actuated="none"), (4, 4, 0)),
        (planar(base="cart", cart_mass=1, actuated="all"), (4, 4, 4)),
        (planar(base="cart", cart_mass=1, actuated=[1, 3]), (4, 4, 3)),
        (spatial(), (9, 9, 0)),
        (spatial(base="cart", cart_mass=1), (11, 11, 2)),
        (spatial(base="cart", cart_mass=1, actuated="none"), (11, 11, 0)),
    ],
)
def test_sizes(scene, sizes):
    assert (scene.nq, scene.nv, scene.nu) == sizes


def test_names_of_a_planar_cart():
    scene = planar(2, base="cart", cart_mass=1, actuated=[2])
    assert scene.q_names == ("x", "theta_1", "theta_2")
    assert scene.v_names == ("x_dot", "theta_dot_1", "theta_dot_2")
    assert scene.u_names == ("force", "torque_2")
    assert scene.actuated_joints == (2,)
    assert (scene.is_planar, scene.has_cart, scene.has_force) == (True, True, True)


def test_names_of_a_spatial_cart():
    scene = spatial(1, base="cart", cart_mass=1)
    assert scene.q_names == ("x_1", "x_2", "q_1_1", "q_1_2", "q_1_3")
    assert scene.v_names == ("x_dot_1", "x_dot_2", "omega_1_1", "omega_1_2", "omega_1_3")
    assert scene.u_names == ("force_1", "force_2")
    assert scene.actuated_joints == ()


def test_runtime_parameters_come_in_the_order_of_the_emitted_struct():
    scene = spatial(
        base="cart",
        stiffness="runtime",
        damping="runtime",
        gravity="runtime",
        cart_mass="runtime",
        com="runtime",
        length="runtime",
        mass="runtime",
    )
    assert scene.runtime == ("mass", "length", "com", "cart_mass", "gravity", "damping", "stiffness")
    shapes = list(scene.runtime_shapes.items())
    assert shapes == [(key, () if key in ("cart_mass", "gravity") else (3,)) for key in scene.runtime]


def test_the_standard_scene_is_paper_a():
    scene = standard_scene(4)
    assert (scene.name, scene.links, scene.angles, scene.actuated) == ("planar4", 4, "relative", "all")
    assert (scene.mass, scene.length, scene.com) == ((0.25,) * 4, (0.25,) * 4, (0.125,) * 4)
    assert scene.want == PLANAR_FUNCTIONS
    assert scene.nu == 4


@pytest.mark.parametrize(("space", "make"), [("planar", planar), ("spatial", spatial)])
def test_each_space_has_its_functions(space, make):
    every = offered(space, on_request=True, flows=True, slow=True)
    assert make(want=every, base="cart", cart_mass=1, stiffness=1).want == every
    for name in set(FUNCTIONS) - set(every):
        with pytest.raises(UnsupportedError):
            make(want=[name])


def test_a_scene_cannot_be_changed():
    scene = standard_scene(2)
    for field in dataclasses.fields(scene):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(scene, field.name, None)
        with pytest.raises(dataclasses.FrozenInstanceError):
            delattr(scene, field.name)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.comment = "new"


def test_a_scene_keeps_no_reference_to_what_it_was_made_from():
    mass = [1.0, 2.0, 3.0]
    scene = planar(mass=mass)
    mass[0] = 9.0
    scene.to_dict()["chain"]["mass"][1] = 9.0
    assert scene.mass == (1.0, 2.0, 3.0)


def test_scenes_can_be_copied_pickled_hashed_and_varied():
    scene = planar(2, com=1.0, stiffness=[1, 2])
    assert pickle.loads(pickle.dumps(scene)) == copy.deepcopy(scene) == scene
    assert len({scene, planar(2, com=1.0, stiffness=[1, 2]), planar(2)}) == 2
    assert dataclasses.replace(scene, gravity=1.62) == planar(2, com=1.0, stiffness=[1, 2], gravity=1.62)


def test_a_scene_prints_as_a_sketch():
    scene = planar(2, base="cart", cart_mass=3, com=[2, 1], stiffness=[0, 0.5], actuated=[1], length=2)
    assert str(scene) == (
        "chain: planar chain, 2 links on a cart, relative angles\n"
        "\n"
        "  ._____.\n"
        "  |_____| <-> force  mass 3\n"
        "   O   O\n"
        "     o   joint 1: torque_1, stiffness 0\n"
        "     @   mass 1 at 2\n"
        "     |   length 2\n"
        "     o   joint 2: stiffness 0.5\n"
        "     @   mass 1 at 1\n"
        "     |   length 2\n"
        "\n"
        "gravity  9.81\n"
        "q        (3)  x, theta_1, theta_2\n"
        "v        (3)  x_dot, theta_dot_1, theta_dot_2\n"
        "u        (2)  force, torque_1\n"
        "runtime  none\n"
        "want     forward_dynamics\n"
        "target   double, auto"
    )


def test_the_sketch_of_a_long_chain_shows_its_ends():
    lines = str(spatial(4096)).splitlines()
    assert "     :   links 4 to 4093" in lines
    assert len(lines) < 40
