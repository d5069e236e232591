"""Studies of controllers: regions of attraction, trials with wrong parameters, swing-ups, each against its function called alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import Scene, build, lqr
from phichain.errors import StudyError
from phichain.studies import study

POLE = Scene("pole", 1, base="cart", actuated="cart", mass=0.1, length=0.4, cart_mass=0.5, want=["forward_dynamics"])


def of(task: dict[str, Any], grid: dict[str, Any] | None = None, scene: Scene = POLE) -> Any:
    return study({"scene": scene, "name": "pole", "task": task, "grid": grid or {}}, workers=0).dataset()


def test_regions_of_attraction_are_those_of_the_function() -> None:
    from phichain.control import gain_table
    from phichain.control.reach import attraction
    from phichain.pipeline import build_closed_loop
    from phichain.scene.load import with_functions

    found = of({"run": "attraction", "directions": 6, "seconds": 3.0, "sample": 0.01}, {"task.input_weight": [1.0, 0.1]})
    scene = with_functions(POLE, ("linearization", "forward_dynamics", "step"))
    laws = gain_table([lqr(build(scene), [-1], 1.0, 0.1, sample=0.01)])
    alone = attraction(build(scene), laws, build_closed_loop(scene, laws), count=6, seconds=3.0)
    assert float(found.radius.sel({"task.input_weight": 0.1})) == alone.radius[0] != float(found.radius.sel({"task.input_weight": 1.0}))


def test_trials_fail_where_parameters_are_too_wrong_and_are_those_of_the_function(tmp_path: Path) -> None:
    from phichain.pipeline import generate_controller
    from phichain.scene.load import with_functions
    from phichain.trials import Disturbed, law_on_file, law_trials

    found = of({"run": "montecarlo", "runs": 20, "sample": 0.01, "spread": 0.2, "limit": 20.0}, {"task.late": [0.0, 0.3]})
    assert float(found.share.sel({"task.late": 0.0})) == 1.0 and float(found.share.sel({"task.late": 0.3})) < 1.0
    scene = with_functions(POLE, ("linearization", "forward_dynamics"))
    law = law_on_file(generate_controller(lqr(build(scene), [-1], 1.0, 1.0, sample=0.01).law(limit=20.0), tmp_path, "float"))
    alone = law_trials(scene, law, Disturbed({}, {}, 0.2, 0.3, {}), runs=20, seed=1)
    assert float(found.share.sel({"task.late": 0.3})) == alone.share
    assert np.all(found.share_low <= found.share) and np.all(found.share <= found.share_high)


def test_a_swing_up_says_how_often_it_holds() -> None:
    pytest.importorskip("casadi")
    found = of({"run": "swingup", "limit": 20.0, "rail": 1.0, "runs": 20, "sample": 0.01, "error_mass": 0.1})
    assert float(found.share) == 1.0 and float(found.farthest) <= 1.0 and float(found.largest_u) <= 20.0 and float(found.duration) > 0.5


@pytest.mark.parametrize(
    ("task", "said"),
    [
        ({"run": "swingup"}, "says how large inputs may be"),
        ({"run": "montecarlo", "error_mass": 1.5}, "is no share from 0 and below 1"),
        ({"run": "attraction", "directions": 0}, "use a whole number from 2"),
        ({"run": "montecarlo", "late": -1.0}, "is below zero"),
    ],
)
def test_what_cannot_be_is_one_sentence(task: dict[str, Any], said: str) -> None:
    if task == {"run": "swingup"}:
        found = study({"scene": POLE, "name": "pole", "task": task, "grid": {}}, workers=0).dataset()
        assert said in str(found.failure.values)
        return
    with pytest.raises(StudyError, match=said):
        of(task)


def test_a_chain_without_inputs_or_with_open_numbers_is_refused_before_the_work() -> None:
    for task, scene, said in (
        ("attraction", Scene("bare", 1, mass=1.0, length=1.0, want=["forward_dynamics"]), "the scene has none"),
        ("montecarlo", Scene("open", 1, base="cart", actuated="cart", mass="runtime", length=1.0, cart_mass=1.0, want=["forward_dynamics"]), "varies the numbers of chains that say them"),
        ("swingup", Scene("space", 1, space="spatial", base="cart", actuated="cart", mass=1.0, length=1.0, cart_mass=1.0, want=["forward_dynamics"]), "moves planar chains"),
    ):
        with pytest.raises(StudyError, match=said):
            study({"scene": scene, "name": "x", "task": {"run": task}, "parameters": {"mass": 1.0} if scene.runtime else {}}, workers=0)
