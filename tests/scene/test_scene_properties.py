"""Random scenes: what is written is read back, and derived sizes agree with each other."""

import json
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from phichain.errors import PhichainError
from phichain.scene import FUNCTIONS, Scene, scene_from_dict
from tests.offered import offered

quick = settings(max_examples=50, deadline=None)

positive = st.floats(1e-6, 1e6)


def per_link(links, numbers=positive):
    """Numbers, lists and the word runtime for a parameter of the links."""
    return st.one_of(st.just("runtime"), numbers, st.lists(numbers, min_size=links, max_size=links))


@st.composite
def lengths_and_coms(draw, links):
    """Lengths with centres of mass that lie on the links."""
    length = draw(per_link(links))
    if length == "runtime" or draw(st.booleans()):
        return length, draw(st.one_of(st.none(), st.just("runtime")))
    lengths = length if isinstance(length, list) else [length] * links
    shares = draw(st.lists(st.sampled_from([0.25, 0.5, 1.0]), min_size=links, max_size=links))
    return length, [l * share for l, share in zip(lengths, shares, strict=True)]


@st.composite
def scenes(draw):
    """Any valid scene of up to six links."""
    links = draw(st.integers(1, 6))
    space = draw(st.sampled_from(["planar", "spatial"]))
    base = draw(st.sampled_from(["fixed", "cart"]))
    planar, cart = space == "planar", base == "cart"
    angles = draw(st.sampled_from(["relative", "absolute", "adjacent"])) if planar else None
    actuated = ["none"] + ["cart"] * cart + ["all"] * planar
    joints = st.lists(st.integers(1, links), min_size=1, unique=True).map(sorted)
    length, com = draw(lengths_and_coms(links))
    joint_law = st.one_of(st.none(), per_link(links, st.one_of(st.just(0.0), positive)))
    damping = draw(joint_law)
    undamped = damping in (None, 0.0) or (isinstance(damping, list) and not any(damping))
    functions = offered(space, not undamped, flows=True)
    return Scene(
        draw(st.from_regex(r"[a-z][a-z0-9]{0,5}_[a-z0-9]{1,5}x", fullmatch=True)),
        links,
        space,
        base,
        mass=draw(per_link(links)),
        length=length,
        com=com,
        cart_mass=draw(st.one_of(st.just("runtime"), positive)) if cart else None,
        gravity=draw(st.one_of(st.just("runtime"), st.just(0.0), positive)),
        angles=angles,
        damping=damping,
        stiffness=draw(joint_law),
        actuated=draw(
            st.one_of(st.sampled_from(actuated), joints)
            if angles == "relative"
            else st.sampled_from(actuated)
        ),
        want=draw(st.lists(st.sampled_from(functions), min_size=1)),
        real=draw(st.sampled_from(["double", "float"])),
        code=draw(st.sampled_from(["auto", "unrolled", "loops"])),
    )


@quick
@given(scenes())
def test_a_scene_written_as_toml_is_read_back_as_itself(scene):
    again = scene_from_dict(tomllib.loads(scene.to_toml()))
    assert again == scene
    assert again.digest == scene.digest
    assert again.to_toml() == scene.to_toml()


@quick
@given(scenes())
def test_a_scene_survives_json(scene):
    assert scene_from_dict(json.loads(json.dumps(scene.to_dict()))) == scene


@quick
@given(scenes())
def test_sizes_and_names_agree(scene):
    cart = (1 if scene.is_planar else 2) if scene.has_cart else 0
    assert scene.nq == scene.nv == cart + scene.links * (1 if scene.is_planar else 3)
    assert scene.nu == len(scene.actuated_joints) + (cart if scene.has_force else 0)
    sizes = ((scene.nq, scene.q_names), (scene.nv, scene.v_names), (scene.nu, scene.u_names))
    for size, names in sizes:
        assert len(set(names)) == len(names) == size
    assert set(scene.runtime) == {
        key for key, value in scene.to_dict()["chain"].items() if value == "runtime"
    } | {key for key, value in scene.to_dict()["joints"].items() if value == "runtime"}
    assert scene.want == tuple(name for name in FUNCTIONS if name in scene.want)
    assert scene.name in str(scene)


anything = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 10**12),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["runtime", "planar", "spatial", "cart", "fixed", "all", "relative", "float", "phi"]),
    st.lists(st.one_of(st.integers(-1, 3), st.floats(), st.text(max_size=2)), max_size=3),
    st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(Scene.__annotations__)), anything)
def test_any_value_of_any_key_gives_a_scene_or_a_phichain_error(key, value):
    arguments = {"name": "chain", "links": 2, "mass": 1.0, "length": 1.0, key: value}
    try:
        scene = Scene(**arguments)
    except PhichainError as error:
        assert str(error).count("\n") == 0
    else:
        assert scene_from_dict(scene.to_dict()) == scene


@pytest.mark.parametrize("number", [0.1, 1 / 3, 1e-08, 1e16, 123456789.123456789, 5e300, 2.5e-200])
def test_floats_are_written_with_all_their_digits(number):
    scene = Scene("a", 1, mass=1.0, length=1.0, gravity=number)
    assert scene_from_dict(tomllib.loads(scene.to_toml())).gravity == number
