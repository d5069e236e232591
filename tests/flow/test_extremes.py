"""Large angles, large rates, long chains: where digits or memory run short."""

from __future__ import annotations

import ctypes
import math
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

from phichain.scene import Scene
from phichain.system.propagation import Stop
from tests.flow.flows import compiled, planar, scene, unit

PENDULUM = scene("turning", "planar", "fixed", links=1, mass=1, length=1)
G = mpmath.mpf(9.81)


def time_between(q0: float, v0: float, q: mpmath.mpf) -> mpmath.mpf:
    """When a pendulum that goes round is at q: t = 2 / sqrt(2 (E + g)) (F(q/2 | m) - F(q0/2 | m)), m = 2 g / (E + g)."""
    energy = mpmath.mpf(v0) ** 2 / 2 - G * mpmath.cos(mpmath.mpf(q0))
    m = 2 * G / (energy + G)
    phase = mpmath.ellipf(q / 2, m) - mpmath.ellipf(mpmath.mpf(q0) / 2, m)
    return 2 * phase / mpmath.sqrt(2 * (energy + G))


# --- whole turns ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turns", [1, -3, 159155, 10**9])
def test_whole_turns_change_nothing_but_the_angle(turns: int) -> None:
    """From an angle of many turns the motion is that of the angle less those turns, as close as doubles tell them."""
    with mpmath.workdps(40):
        q = float(0.4 + 2 * mpmath.pi * turns)
        within = float(mpmath.mpf(q) - 2 * mpmath.pi * turns)
    go = compiled(PENDULUM)
    far, near = (go([angle], [0.3], 0.0, 20.0, 1e-16, times=[7.0]) for angle in (q, within))
    assert abs(far.v[0] - near.v[0]) < 5e-14 and abs(far.v_at[0, 0] - near.v_at[0, 0]) < 5e-14
    spacing = float(np.spacing(abs(q)))
    with mpmath.workdps(40):
        for one, other in ((far.q[0], near.q[0]), (far.q_at[0, 0], near.q_at[0, 0])):
            assert abs(mpmath.mpf(one) - 2 * mpmath.pi * turns - mpmath.mpf(other)) < 0.51 * spacing + 5e-14


@pytest.mark.parametrize("rate", [30.0, 1e4])
def test_a_pendulum_that_goes_round(rate: float) -> None:
    """Against elliptic functions: after thousands of turns the time at which it is where it is."""
    found = compiled(PENDULUM)([0.4], [rate], 0.0, 3.0, 1e-16)
    with mpmath.workdps(40):
        q = mpmath.mpf(found.q[0]) + mpmath.mpf(found.lost[1])
        late = float(time_between(0.4, rate, q) - 3)
        exact = mpmath.sqrt(mpmath.mpf(rate) ** 2 + 2 * G * (mpmath.cos(q) - mpmath.cos(mpmath.mpf(0.4))))
        assert abs(found.v[0] / exact - 1) < 1e-15
    assert abs(late) < 2e-15


def test_stops_count_turns() -> None:
    go = compiled(PENDULUM)
    found = go([0.0], [30.0], 0.0, 10.0, 1e-16, stop=Stop("q", 0, value=200.0))
    assert found.outcome == "event" and abs(found.q[0] - 200) <= np.spacing(200.0)
    again = go(found.q, found.v, found.t, 10.0, 1e-16, stop=Stop("q", 0, value=200.0), lost=found.lost)
    assert again.outcome == "done"


def test_a_spring_does_not_forget_turns() -> None:
    """Without gravity a joint's spring from 50 rad: theta'' = -k theta / (m l^2)."""
    chain = scene_with_spring()
    found = compiled(chain)([50.0], [0.0], 0.0, 2.0, 1e-16)
    assert abs(found.q[0] - 50 * math.cos(2 * math.sqrt(3.0))) < 1e-12


def scene_with_spring() -> Scene:
    table = {"links": 1, "space": "planar", "base": "fixed", "mass": 1, "length": 1, "com": 1, "gravity": 0}
    return planar(1, "sprung", chain=table, joints={"stiffness": 3.0, "angles": "relative"})


# --- room ----------------------------------------------------------------------------------------------------------------

LONG = scene("long_chain", "planar", "fixed", links=64, mass=1 / 64, length=1 / 64, com=1 / 128)


def test_long_chains_do_not_work_on_the_stack(tmp_path: Path) -> None:
    """No frame of them is larger than a few pages, and without a workspace they say how much they need."""
    text, made = unit(LONG)
    (tmp_path / "flow.c").write_text(text)
    done = subprocess.run(
        ["cc", "-std=c99", "-O2", "-fPIC", "-shared", "-Wstack-usage=16384", "-Werror", "flow.c", "-o", "flow.so", "-lm"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if "unknown warning option" in done.stderr:
        pytest.skip("asks gcc for the size of frames")
    assert done.returncode == 0, done.stderr[:1000]
    state, run = (ctypes.c_char * 8192)(), ctypes.CDLL(str(tmp_path / "flow.so"))["long_chain_propagate"]
    number = ctypes.c_double * 128
    q, v = number(), number()
    result = run(
        state, ctypes.c_double(1.0), ctypes.c_ulong(1), q, v, None, ctypes.c_ulong(0), None, None, None
    )
    assert result == 4
    needed = int.from_bytes(bytes(state)[8 * (3 + 128 + 2) : 8 * (3 + 128 + 3)], "little")
    assert f" {needed} bytes of" in made.declarations


def test_the_callers_workspace_is_the_rule(tmp_path: Path) -> None:
    """A short chain wants one as well, unless whoever compiles it asks for the stack."""
    (tmp_path / "flow.c").write_text(unit(planar(2))[0])
    endings = {}
    for name, flags in (("rule", ()), ("asked", ("-DCHAIN2_WORK_ON_STACK",))):
        subprocess.run(["cc", "-std=c99", "-fPIC", "-shared", *flags, "flow.c", "-o", f"{name}.so", "-lm"], cwd=tmp_path, check=True)
        state, run = (ctypes.c_char * 8192)(), ctypes.CDLL(str(tmp_path / f"{name}.so"))["chain2_propagate"]
        q, v = (ctypes.c_double * 2)(), (ctypes.c_double * 2)()
        endings[name] = run(state, ctypes.c_double(0.0), ctypes.c_ulong(1), q, v, None, ctypes.c_ulong(0), None, None, None)
    assert endings == {"rule": 4, "asked": 0}


def test_a_long_chain_at_rest_in_its_folds_stays() -> None:
    """An equilibrium of 64 links, every other one folded back: f = 0 but for the rounding of pi."""
    q = np.array([0.0] + [math.pi] * 63)
    found = compiled(LONG)(q, np.zeros(64), 0.0, 0.01, 1e-9)
    assert found.outcome == "done" and np.max(np.abs(found.q - q)) < 1e-10
