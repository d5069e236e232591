"""Words of physics that are no keys: each is answered by what a scene holds, and a key is offered where a slip alone is between."""

from __future__ import annotations

import re

import pytest

from phichain.contract.functions import FUNCTIONS
from phichain.contract.words import nearest
from phichain.errors import SceneError
from phichain.scene import scene_from_dict
from phichain.scene.keys import TABLES
from phichain.scene.words import WORDS, answer_of

CHAIN = {"links": 2, "mass": 1, "length": 1}


def refusal(tables):
    with pytest.raises(SceneError) as caught:
        scene_from_dict({"name": "chain", "chain": CHAIN} | tables)
    return caught.value


@pytest.mark.parametrize(
    ("table", "word", "says"),
    [
        ("chain", "rotor", "joints.armature = n^2 J_rotor"),
        ("joints", "rotor_inertia", "joints.armature = n^2 J_rotor"),
        ("chain", "spin", "thin rods that have no such motion"),
        ("chain", "rope", '"tensions"'),
        ("joints", "limits", "event of simulate"),
        ("joints", "joint limits", "event of simulate"),
        ("joints", "Joint-Limits", "event of simulate"),
        ("joints", "motor_voltage", "phichain.rigs"),
        ("chain", "motor voltage", "phichain.rigs"),
        ("chain", "gear_ratio", "torque by n, its damping and rotor inertia by n^2"),
        ("joints", "backlash", "law with corners"),
        ("chain", "contact", "law with corners"),
        ("chain", "tension", 'want "tensions"'),
        ("joints", "torque", "pass u to the functions or to simulate"),
        ("joints", "torque_limit", "saturate u"),
        ("chain", "rotary_base", 'base = "fixed", "cart" or "moving"'),
        ("chain", "branch", "every link of a chain hangs on the one before"),
        ("chain", "pivot_motion", 'base = "moving"'),
        ("chain", "moment_of_inertia", "write chain.inertia, kg m^2 about the centre of mass"),
        ("chain", "initial_state", "x0 = (q, v)"),
        ("joints", "coulomb_friction", "joints.friction with joints.friction_speed"),
        ("chain", "g", "write chain.gravity, m/s^2"),
        ("chain", "diameter", "rod, tube, cylinder"),
        ("chain", "payload", "point(mass, place)"),
        ("joints", "bearing", "joints.damping or joints.friction"),
        ("chain", "ball_joint", "what slides is the cart"),
        ("chain", "incline", "gravity times cos(tilt)"),
        ("chain", "gravity_angle", "gravity times cos(tilt)"),
        ("chain", "magnet", "torques about the joints to u"),
        ("joints", "damping_ratio", "2 zeta"),
        ("chain", "natural_frequency", 'want "linearization"'),
        ("joints", "brake", "run one scene for each state"),
        ("joints", "stribeck", "regularises it as F tanh"),
        ("chain", "com_offset", "beside the line from joint to joint"),
        ("chain", "second_link_inertia", "write chain.inertia"),
        ("chain", "pole_mass", "write chain.mass, kg"),
        ("joints", "gearbox_ratio_1", "torque by n, its damping and rotor inertia by n^2"),
        ("joints", "max_motor_current", "phichain.rigs"),
        ("chain", "pulley_radius", "belt_cart for chain.cart_mass"),
        ("joints", "belt_ratio", "at_joint for a joint"),
        ("joints", "no_load_speed", "belongs to a motor"),
        ("joints", "stall_torque", "belongs to a motor"),
        ("chain", "hinge_mass", "point(mass, place)"),
        ("joints", "motor_mass", "point(mass, place)"),
    ],
)
def test_a_word_of_physics_is_answered_by_what_a_scene_holds(table, word, says):
    error = refusal({table: (CHAIN if table == "chain" else {}) | {word: 1}})
    assert error.field == f"{table}.{word}" and says in str(error)
    assert "did you mean" not in str(error) and len(str(error).splitlines()) == 1


@pytest.mark.parametrize("table", ["motor", "gear", "limits", "rope", "initial", "controller", "friction"])
def test_a_table_of_that_name_too(table):
    assert "did you mean" not in str(refusal({table: {}}))


@pytest.mark.parametrize("word", ["inertia", "armature", "friction"])
def test_keys_that_once_were_unknown_are_keys(word):
    """They were answered with cart_mass, actuated and stiffness."""
    assert any(word in keys for keys in TABLES.values()) and word not in WORDS


def test_every_answer_is_one_sentence_about_keys_that_there_are():
    keys = {"name"} | {key for table in TABLES.values() for key in table}
    for word, answer in WORDS.items():
        assert word == "_".join(word.lower().split()) and answer_of(word) is answer
        assert answer.problem[0].islower() and answer.remedy[0].islower() and not answer.remedy.endswith(".")
        named = re.findall(rf"\b({'|'.join(TABLES)})\.(\w+)", answer.problem + answer.remedy)
        assert all(key in TABLES[table] for table, key in named), word
        wanted = re.findall(r'want "(\w+)"', answer.remedy)
        assert set(wanted) <= set(FUNCTIONS), word
    assert not set(WORDS) & keys


@pytest.mark.parametrize(
    ("word", "key"),
    [
        ("masss", "mass"),
        ("mas", "mass"),
        ("lenght", "length"),
        ("gravtiy", "gravity"),
        ("Armature", "armature"),
        ("cartmass", "cart_mass"),
        ("cart_frictionspeed", "cart_friction_speed"),
    ],
)
def test_a_slip_finds_its_key(word, key):
    assert nearest(word, [key for table in TABLES.values() for key in table]) == key


def test_a_slip_goes_before_a_part_of_it():
    assert 'did you mean "cart_mass"' in str(refusal({"chain": CHAIN | {"cart_masss": 1}}))
    assert "the keys of [chain] are" in str(refusal({"chain": CHAIN | {"cart_velocity": 1}}))


@pytest.mark.parametrize("word", ["rotor", "spin", "rope", "q", "", "zzz", "voltage", "amplitude", "a" * 1_000_000], ids=lambda word: word[:20])
def test_nothing_far_is_offered(word):
    """Nor sought for long."""
    assert nearest(word, [key for table in TABLES.values() for key in table]) is None


def test_slips_are_counted_as_fingers_make_them():
    assert nearest("chian", ["chain"]) == "chain"
    assert nearest("abcd", ["abdc"]) == "abdc"
    assert nearest("abcd", ["badc"]) is None
    assert nearest("links", []) is None


@pytest.mark.parametrize(
    ("want", "says"),
    [
        ("torque", 'want "inverse_dynamics"'),
        ("tension", 'did you mean "tensions"?'),
        ("constraint forces", 'want "tensions"'),
        ("kinetic", 'want "energy"'),
        ("controller", 'say "phichain controller SCENE" (docs/controllers.md)'),
        ("lqr", 'say "phichain lqr SCENE"'),
        ("Swing-up", 'say "phichain swingup SCENE" (docs/swingup.md)'),
        ("propagat", 'did you mean "propagate"?'),
        ("teapot", "the functions are forward_dynamics, "),
    ],
)
def test_what_is_wanted_by_another_name(want, says):
    assert says in str(refusal({"functions": {"want": [want]}}))


def test_a_choice_far_from_all_is_refused_without_a_guess():
    assert str(refusal({"chain": CHAIN | {"base": "wheel"}})).endswith('use "fixed" or "cart" or "moving"')
