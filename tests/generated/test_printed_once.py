"""Each Program of a scene is turned into C once for its folder, whatever reads the text."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from phichain.emit import folder_files, library_files
from phichain.emit.c.function import Writer
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.offered import offered

SCENES = {
    "planar": Scene(
        "planar_all", 1, base="cart", mass=1.0, length=0.5, com=0.25, cart_mass=1.0, actuated="all",
        want=offered("planar", on_request=True, flows=True), code="loops",
    ),
    "spatial": Scene(
        "spatial_all", 1, space="spatial", mass="runtime", length=0.5, want=offered("spatial", on_request=True, flows=True),
        code="loops",
    ),
}  # fmt: skip

#: What the two Taylor flows have a copy of each, under a name of its own.
COPIED = "flow_scales"


@pytest.fixture
def printed(monkeypatch: pytest.MonkeyPatch) -> Counter[tuple[str, str]]:
    """How often each Program was printed, by the printer and the Program's text."""
    counts: Counter[tuple[str, str]] = Counter()
    original = Writer.__init__

    def counting(self: Writer, program: Any, *rest: Any, **more: Any) -> None:
        counts[type(self).__name__, str(program)] += 1
        original(self, program, *rest, **more)

    monkeypatch.setattr(Writer, "__init__", counting)
    return counts


@pytest.mark.long
@pytest.mark.parametrize("kind", SCENES)
def test_a_folder_prints_each_program_once(kind: str, printed: Counter[tuple[str, str]]) -> None:
    scene = SCENES[kind]
    lowered = lower(derive(scene))
    folder_files(scene, lowered, with_casadi_c=True)
    assert len(printed) > len(lowered.wanted) + len(lowered.helpers)
    again = {text.split("(")[0] for (_, text), count in printed.items() if count > 1}
    # A trajectory of a batch goes in and out one by one, as the scalar flow's does.
    assert again <= {COPIED, "flow_enter", "flow_leave"}
    assert max(printed.values()) <= 2


def test_a_library_prints_each_program_once(printed: Counter[tuple[str, str]]) -> None:
    scene = Scene("duo", 2, mass=1.0, length=0.5, want=["forward_dynamics", "step_variational", "propagate", "propagate_stiff"])
    lowered = lower(derive(scene))
    library_files(scene, lowered)
    assert {text for printer, text in printed if printer == "Writer"} >= {str(p) for p in lowered.wanted.values()}
    assert set(printed.values()) == {1}
