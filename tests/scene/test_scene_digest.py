"""The digest depends on what a scene says, on nothing else."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import phichain.scene
from phichain.scene import Scene, scene_from_dict, standard_scene

PACKAGE_ROOT = Path(phichain.scene.__file__).parents[2]

BASE = Scene("chain", 2, base="cart", mass=[1, 2], length=0.5, com=0.25, cart_mass=3, damping=0.1)

CHANGES = {
    "name": "other",
    "base": "cart",
    "mass": (1.0, 2.0 + 2**-51),
    "length": 0.75,
    "com": 0.125,
    "cart_mass": "runtime",
    "gravity": 9.8,
    "angles": "absolute",
    "damping": None,
    "stiffness": 1.0,
    "actuated": "all",
    "want": ("energy",),
    "real": "float",
    "code": "loops",
}


def test_the_digest_is_that_of_canonical_json():
    text = (
        '{"chain":{"base":"fixed","gravity":"0x1.0000000000000p+3","length":["0x1.0000000000000p-1"],'
        '"links":1,"mass":"runtime","space":"planar"},"functions":{"want":["energy"]},'
        '"joints":{"actuated":"none","angles":"relative"},"name":"one",'
        '"target":{"code":"auto","real":"double"}}'
    )
    scene = Scene("one", 1, mass="runtime", length=0.5, gravity=8, want=["energy"])
    assert scene.digest == hashlib.sha256(text.encode()).hexdigest()


def test_the_digest_does_not_depend_on_the_order_of_keys():
    tables = BASE.to_dict()
    backwards = {
        table: dict(reversed(entries.items())) if isinstance(entries, dict) else entries
        for table, entries in reversed(tables.items())
    }
    assert list(backwards) != list(tables)
    assert scene_from_dict(backwards).digest == BASE.digest


def test_the_digest_does_not_depend_on_how_a_value_is_written():
    other = Scene(
        "chain",
        2,
        base="cart",
        mass=[1.0, 2.0],
        length=[0.5, 0.5],
        com=(0.25, 0.25),
        cart_mass=3.0,
        gravity=9.81,
        angles="relative",
        damping=0.1,
        stiffness=-0.0,
        actuated="cart",
        want=["forward_dynamics", "forward_dynamics"],
    )
    assert other == BASE
    assert other.digest == BASE.digest
    assert (
        Scene("a", 1, mass=1, length=1, gravity=-0.0).digest
        == Scene("a", 1, mass=1, length=1, gravity=0).digest
    )


@pytest.mark.parametrize("key", [key for key in CHANGES if key != "base"])
def test_the_digest_depends_on_every_key(key):
    assert replace(BASE, **{key: CHANGES[key]}).digest != BASE.digest


def test_the_digest_depends_on_space_base_and_links():
    kinds = [Scene("chain", n, s, mass=1, length=1) for n in (1, 2) for s in ("planar", "spatial")]
    kinds += [Scene("chain", 1, mass=1, length=1, base="cart", cart_mass=1, actuated="none")]
    assert len({scene.digest for scene in kinds}) == len(kinds)


def test_the_digest_is_the_same_under_five_hash_seeds():
    code = "from phichain.scene import standard_scene as s; print(s(3).digest, s(3).to_toml())"
    outputs = {
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONPATH": str(PACKAGE_ROOT), "PYTHONHASHSEED": str(seed)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in range(5)
    }
    assert outputs == {f"{standard_scene(3).digest} {standard_scene(3).to_toml()}\n"}
