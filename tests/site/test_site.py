"""What the site is made of: links lead somewhere, blocks that need no building are right, references leave nothing out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import phichain
from docs.site import blocks, reference, stage
from phichain.contract.functions import FUNCTIONS
from phichain.scene.keys import TABLES

ROOT = Path(__file__).parents[2]
PAGES = sorted({*(ROOT / "docs").glob("*.md"), *(ROOT / name for name in stage.PAGES)})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    assert [str(link) for link in stage._linked(page.read_text(), page.parent) if not link.exists()] == []


def test_blocks_that_need_no_building_are_right(tmp_path: Path) -> None:
    checks = {"toml": blocks._toml, "sh": blocks._command, "c": blocks._c}
    found = [(str(block), checks[block.language](block.text)) for block in blocks.blocks(ROOT) if block.language in checks]
    assert len(found) > 20 and [fault for fault in found if fault[1]] == []
    (tmp_path / "docs").mkdir()
    wrong = "    phichain simulate SCENE --tea 3\n\n```toml\n[chain]\nmas = 1\n```\n\n```c\nint a = ;\n```\n\n```python\nraise SystemExit(1)\n```\n\n```ruby\n```\n"
    (tmp_path / "README.md").write_text(wrong)
    said = blocks.faults(tmp_path)
    assert len(said) == 5 and "no option --tea" in said[2] + said[3] + "".join(said) and any('did you mean "mass"' in line for line in said)


def test_references_leave_nothing_out() -> None:
    pages = reference.pages()
    assert set(pages) == set(reference.NAMES)
    assert all(f"| `{key}` |" in pages["scene.md"] for keys in TABLES.values() for key in keys)
    assert all(f"## `{name}`" in pages["functions.md"] for name in FUNCTIONS)
    named = set(re.findall(r"auto\w+:: ([\w.]+)", pages["api.md"]))
    assert {f"phichain.{name}" for name in phichain.__all__} <= named
    assert "## `phichain study`" in pages["command.md"] and "| `--scheduler` |" in pages["command.md"]


def test_a_staged_tree_holds_every_page_and_what_they_link_to(tmp_path: Path) -> None:
    stage.stage(ROOT, tmp_path)
    index = (tmp_path / "index.md").read_text()
    for page in tmp_path.rglob("*.md"):
        name = str(page.relative_to(tmp_path).with_suffix(""))
        assert name == "index" or re.search(rf"^{re.escape(name)}$", index, re.MULTILINE), name
    assert (tmp_path / "docs" / "img" / "tour.png").exists()
