"""A law along a trajectory that learns parameters on the way: record, Programs at 50 digits, C with its self-test and mutants of it."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import generate_swingup
from phichain.errors import ArrayError, OutputError
from phichain.ir import evaluate_exactly
from phichain.laws import TrajectoryLaw
from phichain.lowering.laws.holding import held_sizes, holding
from phichain.lowering.trajectory import tracking
from tests.trials.test_trajectory_law import law_of, learning, result_of


@pytest.mark.parametrize("nu", [1, 2])
def test_what_is_learned_is_the_record_and_the_formula(nu: int) -> None:
    """Along the motion an observer of (z, theta); at the target the chain of the parameters that were found, and two gains a reading."""
    law, draw = learning(law_of(nu)), np.random.default_rng(2)
    assert law.observer is not None and law.observer.learning is not None
    seen, known = law.observer, law.observer.learning
    assert law.remembered == 7 + 6 and law.numbers == 9 * (4 + nu + 4 * nu + 8 + 8 + 2 * nu + 6 + 6)
    programs, memory = (tracking(law), holding(law)), np.concatenate([law.reset(law.states[0, :2] + [0.02, -0.03])[:4], [0.1, -0.2, 0.4], np.zeros(6)])
    assert np.array_equal(law.reset(law.states[0, :2]), np.zeros(13))
    held = np.concatenate([part.ravel() for part in (law.states[-1, :2], law.inputs[-1], law.gains[-1], known.steps / 2, known.inside, known.outside, seen.flows[-1], seen.drives[-1], known.bends)])
    assert len(held) == sum(held_sizes(law).values())
    bounded = 0
    for t in (0.011, 0.2399, 0.24, 0.3):
        y = law.reference(t)[0][:2] + memory[:2] + np.array([0.003, 0.05]) * (draw.normal() if t < 0.24 else 1) + [0, 2 * np.pi]
        j, is_last = min(int(t / law.interval + 1e-9), 8), t >= 0.24
        f = 0.0 if is_last else float(Fraction(t / law.interval) - j)
        rows = [np.concatenate([part[k].ravel() for part in law.tables]) for k in (j, min(j + 1, 8))]
        given: dict[str, Any] = {"y_meas": y, "expected": memory} | ({"held": held} if is_last else {"here": rows[0], "next": rows[1], "f": [f]})
        found = evaluate_exactly(programs[is_last], given, digits=60)
        (x_r, u_r, K), mix = law.reference(t), lambda table: table[j] + f * (table[min(j + 1, 8)] - table[j])  # noqa: B023
        e = np.remainder(y - x_r[:2] - memory[:2] + np.pi, 2 * np.pi) - np.pi
        theta = memory[4:7].copy()
        if is_last:
            within = np.where(np.abs(e) > known.steps / 2, np.sign(e) * known.steps / 2, e)
            z = memory[:4] + known.inside @ within + known.outside @ (e - within)
            F, G = (seen.flows[-1] + np.tensordot(theta, known.bends[:, :, :4], 1), seen.drives[-1] + np.tensordot(theta, known.bends[:, :, 4:], 1))
            pushing = np.zeros(2)
        else:
            z, theta = memory[:4] + mix(seen.corrections) @ e, theta + mix(known.learned) @ e
            bounded += int(np.sum(np.abs(theta) > known.bounds))
            theta = np.array([min(max(one, -bound), bound) for one, bound in zip(theta, known.bounds, strict=True)])
            F, G, pushing = mix(seen.flows), mix(seen.drives), mix(known.pushes) @ theta
        u = np.clip(u_r - K @ z, -2, 2)
        v = z[2:] + F @ z + G @ (u - u_r) + pushing
        # Every reading is another one here.
        wanted = np.concatenate([z[:2] + law.catch.sample / 2 * (z[2:] + v), v, theta, y, np.zeros(4)])
        pushed, memory = law.step(memory, t, y)
        for by in ((pushed, memory), tuple(np.array([float(value) for value in found[name]]) for name in ("u", "following"))):
            assert np.allclose(by[0], u, atol=1e-9) and np.allclose(by[1], wanted, atol=1e-9)
    assert bounded


def test_a_sensor_that_is_stuck_loses_the_chain_and_one_that_moves_does_not() -> None:
    """Two readings, one of which stays: by hand p is the double sum of the corrections; the law gives up when it comes to 512 steps."""
    law = learning(law_of())
    assert law.observer is not None and law.observer.learning is not None
    known, T = law.observer.learning, law.catch.sample
    for moves in (True, False):
        memory, rate, place, lost = np.zeros(13), 0.0, 0.0, False
        for k in range(400):
            y = law.states[-1, :2] + [0.5 if not moves or k % 2 else 0.501, 0.003 * (k % 2)]
            away = y - law.states[-1, :2] - memory[:2]
            away[1] = np.remainder(away[1] + np.pi, 2 * np.pi) - np.pi
            z = known.corrected(memory[:4], away)
            left, stays = 1 - T / 0.25, k > 0 and not moves
            rate = stays * (left * rate + (z[2] - memory[2]))
            place = stays * (left * place + (z[0] - memory[0]) + T * rate)
            u, memory = law.step(memory, 1.0, y)
            assert np.allclose(memory[7:9], y) and np.allclose(memory[[9, 11]], [rate, place], atol=1e-9 + 1e-9 * abs(place))
            assert np.all(memory[[10, 12]] == 0)
            lost = abs(place) > 512 * known.steps[0]
            if lost:
                break
        assert lost is not moves and (u[0] == 0) is lost


def test_names_of_what_is_learned_are_kept_and_counted(tmp_path: Path) -> None:
    law = learning(law_of())
    assert law.observer is not None and law.observer.learning is not None
    with pytest.raises(ArrayError, match="learning.names: must be 3 of them"):
        replace(law.observer.learning, names=("mass_1",))
    named = replace(law, observer=replace(law.observer, learning=replace(law.observer.learning, names=("mass_1", "mass_2", "length"))))
    for one, wanted in ((named, ("mass_1", "mass_2", "length")), (law, ())):
        read = TrajectoryLaw.from_npz(one.to_npz(tmp_path / "law.npz"))
        assert read.observer is not None and read.observer.learning is not None and read.observer.learning.names == wanted
    kept = dict(np.load(tmp_path / "law.npz"))
    with pytest.raises(ArrayError, match="learning.bounds: must be positive"):
        replace(law.observer.learning, bounds=np.array([0.1, 0.0, 0.1]))
    for name in ("corrections", "flows", "drives"):
        del kept[name]
    np.savez(tmp_path / "half.npz", **kept)
    with pytest.raises(OutputError, match="no TrajectoryLaw can be read there"):
        TrajectoryLaw.from_npz(tmp_path / "half.npz")


@pytest.mark.long
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("", ""),
        ("at >= last", "at > 2 * last"),
        ("= expected[5] + (here", "= expected[4] + (here"),
        ("expected[5] * t13", "expected[4] * t13"),
        ("x_apart - x_within", "x_apart"),
        ("-held[8]", "held[8]"),
        ("following[6] = expected[6]", "following[6] = 0"),
        ("< -0.3F ? -0.3F", "< -0.4F ? -0.4F"),
        ("(0.25F < t", "(0.5F < t"),
        ("expected[7] < y_meas[0]", "expected[7] > y_meas[0]"),
        ("y_meas[1] < expected[8]", "y_meas[1] > expected[8]"),
        ("0.001F * x_dot_pull", "0.002F * x_dot_pull"),
        ("following[8] = y_meas[1]", "following[8] = y_meas[0]"),
        ("_held[65] = {0x1p-2F", "_held[65] = {0x1p-1F"),
    ],
)
def test_the_folder_of_what_learns_and_its_mutants(right: str, wrong: str, tmp_path: Path) -> None:
    law = learning(law_of())
    assert law.observer is not None and law.observer.learning is not None
    named = replace(law, observer=replace(law.observer, learning=replace(law.observer.learning, names=("mass_1", "mass_2", "length"))))
    folder = generate_swingup(named, tmp_path)
    assert "entries of theta are those of mass_1, mass_2, length." in " ".join((folder / "pole_swingup.h").read_text().replace("\n *", " ").split())
    source = folder / "pole_swingup.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1) if right else text)
    assert (result_of(folder) > 0) is bool(right)
    record = json.loads((folder / "manifest.json").read_text())
    assert record["state_bytes"] == 4 + 4 * 13 and record["learned"] == 3
