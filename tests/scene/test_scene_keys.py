"""Keys and tables that are unknown, misplaced or missing."""

import pytest

from phichain.errors import SceneError
from phichain.scene import scene_from_dict

TABLES = {"name": "chain", "chain": {"links": 2, "mass": 1, "length": 1}}


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            {"chian": {}},
            (
                'chian: is not a key of a scene (got {}); did you mean "chain"? '
                "The keys of a scene are name, chain, joints, functions, flow, forcing, target"
            ),
        ),
        (
            {"chain": TABLES["chain"] | {"masss": 1}},
            (
                'chain.masss: is not a key of a scene (got 1); did you mean "mass"? The keys of [chain] are '
                "links, space, base, mass, length, com, inertia, cart_mass, cart_damping, cart_friction, cart_friction_speed, "
                "drive, gravity"
            ),
        ),
        (
            {"joints": {"Stifness": 1}},
            (
                'joints.Stifness: is not a key of a scene (got 1); did you mean "stiffness"? '
                "The keys of [joints] are angles, damping, stiffness, rest_angle, friction, friction_speed, armature, actuated"
            ),
        ),
        ({"links": 2}, "links: stands in the wrong place (got 2); write links in [chain]"),
        (
            {"chain": TABLES["chain"] | {"damping": 1}},
            "chain.damping: stands in the wrong place (got 1); write damping in [joints]",
        ),
        (
            {"chain": TABLES["chain"] | {"name": "x"}},
            "chain.name: stands in the wrong place (got 'x'); write name before the first table",
        ),
        (
            {"flow": {"variational": True}},
            (
                "flow.variational: asks for derivatives of a flow that is not wanted (got True); "
                'add "propagate" to want'
            ),
        ),
        ({"control": {}}, None),
        ({"forcing": {}}, None),
        ({"fractional": {}}, None),
        ({"target": "float"}, "target: is not a table (got 'float'); write [target] and its keys below it"),
        ({1: 2}, None),
        (
            {"chain": {"links": 2, "mass": 1}},
            "chain.length: is missing (got nothing); add the key chain.length",
        ),
        ({"chain": {}}, "chain.links: is missing (got nothing); add the key chain.links"),
    ],
)
def test_unknown_misplaced_and_missing_keys(tables, message):
    with pytest.raises(SceneError) as caught:
        scene_from_dict(TABLES | tables)
    if message is not None:
        assert str(caught.value) == message


def test_a_scene_without_a_name_and_no_scene_at_all():
    with pytest.raises(SceneError, match=r"^name: is missing \(got nothing\); add the key name$"):
        scene_from_dict({"chain": TABLES["chain"]})
    with pytest.raises(SceneError, match=r"^scene: is not a table \(got \[\]\)"):
        scene_from_dict([])
