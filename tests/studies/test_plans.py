"""What a study file may say, and what is said of one that will not do: one sentence, before anything is computed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.errors import PhichainError, StudyError
from phichain.scene.load import with_functions
from phichain.studies import load_plan, plan_of
from phichain.studies.point import Base, Resolver
from tests.studies.conftest import SCENE, tables

BAD: tuple[tuple[dict[str, Any], str], ...] = (
    ({"grid": {"chain.gravitation": [1.0]}}, "chain.gravitation"),
    ({"grid": {"gravty": [1.0]}}, 'did you mean "chain.gravity"'),
    ({"grid": {"joints.mass": [1.0]}}, 'did you mean "chain.mass"'),
    ({"grid": {"task.leen": [1.0]}}, 'did you mean "lean"'),
    ({"grid": {"task.lean": []}}, "holds no value"),
    ({"grid": {"task.lean": [0.1, 0.1]}}, "holds a value twice"),
    ({"grid": {"task.lean": {"from": 0.0, "to": 1.0}}}, "is no range"),
    ({"grid": {"task.lean": {"from": 0.0, "to": 1.0, "count": 3, "scale": "log"}}}, "no logarithm"),
    ({"grid": {"task.lean": {"from": 0.0, "to": 1.0, "count": 10**9}}}, "must be at most 20000000"),
    ({"grid": {"task.lean": {"from": 0.0, "to": 1.0, "count": 5000}, "gravity": {"from": 1.0, "to": 2.0, "count": 5000}}}, "more tasks than"),
    ({"grid": {"chain.mass": {"from": 1.0, "to": 2.0, "count": 2000}}}, 'write "runtime"'),
    ({"grid": {"chain.mass[2]": [1.0]}}, "no such entry"),
    ({"grid": {"task.q[1]": [1.0]}}, "give the whole list first"),
    ({"grid": {"gravity": [1.0], "chain.gravity": [2.0]}}, "varies a key twice"),
    ({"grid": {"gravity": ["moon"]}}, "does not hold numbers"),
    ({"grid": {"chain.mass": [-1.0]}}, "chain.mass: is not positive"),
    ({"samples": {"task.lean": {"low": 0.0, "high": 1.0}}}, "say how many samples"),
    ({"samples": {"count": 3}}, "vary nothing"),
    ({"samples": {"count": 3, "gravity": {"low": 2.0, "high": 1.0}}}, "exchange them"),
    ({"samples": {"count": 3, "gravity": [1.0]}}, "is no distribution"),
    ({"samples": {"count": 3, "method": "latin", "gravity": {"mean": 1.0}}}, '"random" or "sobol"'),
    ({"task": {"run": "simulat"}}, "use one of"),
    ({"task": {"t": 1.0}}, "task.run: is missing"),
    ({"task": {"run": "simulate", "t": -1.0}}, "task.t"),
    ({"task": {"run": "lqr"}, "grid": {}}, "the scene has none"),
    ({"parameters": {}, "grid": {}}, "parameters.gravity: has no value"),
    ({"parameters": {"mass": 1.0}}, "its runtime parameters are gravity"),
    ({"scene": "no_such_scene"}, "no scene has that name"),
    ({"gird": {}}, 'did you mean "grid"'),
)


@pytest.mark.parametrize(("changes", "words"), BAD, ids=lambda value: str(value)[:40])
def test_a_study_that_will_not_do_is_one_sentence(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(PhichainError) as refusal:
        plan = plan_of(tables(**changes))
        assert plan.scenes and plan.outputs
    assert words in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_file_is_read_and_its_scene_found_beside_it(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(SCENE.to_toml())
    (tmp_path / "study.toml").write_text('scene = "mine.toml"\n[task]\nrun = "simulate"\n[grid]\ngravity = [1.0, 2.0]\n[grid.task]\nlean = [0.5]\n')
    plan = load_plan(tmp_path / "study.toml")
    assert plan.base.scene == SCENE and plan.dims == ("chain.gravity", "task.lean") and plan.shape == (2, 1)
    with pytest.raises(StudyError, match="study file: cannot be read"):
        load_plan(tmp_path / "none.toml")


def test_more_samples_begin_with_the_fewer_and_axes_draw_alone() -> None:
    def drawn(count: int, **more: Any) -> dict[str, tuple[Any, ...]]:
        axes = {"task.lean": {"low": 0.0, "high": 1.0}, "gravity": {"mean": 9.0, "deviation": 0.1}} | more
        return {axis.key: axis.values for axis in plan_of(tables(grid={}, samples={"count": count, "seed": 4, **axes})).samples}

    few, many = drawn(5), drawn(50)
    assert all(many[key][:5] == few[key] for key in few)
    more = drawn(5, **{"task.tol": {"low": 1e-9, "high": 1e-6, "scale": "log"}})
    assert all(more[key] == few[key] for key in few)
    same = {"task.lean": {"low": 0.0, "high": 1.0}, "gravity": {"low": 0.0, "high": 1.0}}
    assert not set(drawn(5, **same)["task.lean"]) & set(drawn(5, **same)["chain.gravity"]), "every axis has a stream of its own"
    assert all(1e-9 <= value < 1e-6 for value in more["task.tol"])
    assert abs(np.mean(drawn(4000)["chain.gravity"]) - 9.0) < 0.01
    sobol = plan_of(tables(grid={}, samples={"count": 64, "method": "sobol", "gravity": {"low": 0.0, "high": 1.0}})).samples[0].values
    assert sorted(int(64 * value) for value in sobol) == list(range(64)), "a Sobol sequence has one point in every 64th"


def test_a_key_is_of_what_is_computed_and_of_nothing_else() -> None:
    def keys(**changes: Any) -> set[bytes]:
        return {key.tobytes() for key in plan_of(tables(**changes)).point_keys()}

    whole = keys()
    assert len(whole) == 6
    # The order of axes, the way they are written and what is held fast instead of varied make no difference.
    assert keys(grid={"task.lean": [0.3, 0.2, 0.1], "chain.gravity": [1.62, 9.81]}) == whole
    assert keys(grid={"task.lean": [0.1, 0.2, 0.3]}) < whole
    assert keys(grid={"gravity": [9.81, 1.62], "task.lean": {"from": 0.1, "to": 0.3, "count": 3}}) & whole
    assert not keys(task={"run": "simulate", "t": 0.6, "tol": 1e-8, "error_estimate": False}) & whole
    assert not keys(scene=Scene_of_mass_two()) & whole
    assert not keys(task={"run": "propagate", "t": 0.5, "tol": 1e-8}) & whole
    both = with_functions(SCENE, ("forward_dynamics", "propagate_batch"))
    alike = [Resolver(Base(both, task, {"t": 1.0}, {"gravity": 9.81}), ())(()) for task in ("simulate", "propagate")]
    assert alike[0].digest == alike[1].digest and alike[0].key != alike[1].key


def Scene_of_mass_two() -> Any:
    from dataclasses import replace

    return replace(SCENE, mass=2.0)


def test_links_and_words_can_be_varied() -> None:
    plan = plan_of({"scene": "planar2", "task": {"run": "simulate"}, "grid": {"links": [1, 3], "angles": ["relative", "absolute"]}})
    assert [scene.links for scene in plan.scenes] == [1, 1, 3, 3] and plan.chains == 4
    assert plan.outputs["q"].dims == {"q_name": 3} and "q_name" not in plan.labels


def test_its_size_is_said_before_it_starts() -> None:
    assert str(plan_of(tables())).startswith("six: 6 tasks of simulate (2 chain.gravity x 3 task.lean), 1 chain(s) to compile")
