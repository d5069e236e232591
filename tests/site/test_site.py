"""What the site is made of: links lead somewhere, blocks that need no building are right, references leave nothing out."""

from __future__ import annotations

import re
import urllib.error
import urllib.request
from collections.abc import Callable
from email.message import Message
from pathlib import Path
from typing import NoReturn

import pytest

import phichain
from docs.site import blocks, links, reference, stage
from phichain.contract.functions import FUNCTIONS
from phichain.scene.keys import TABLES

ROOT = Path(__file__).parents[2]
PAGES = sorted({*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "notebooks").glob("*.md"), *(ROOT / name for name in stage.PAGES)})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT).with_suffix("")))
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    assert [str(link) for link in stage.linked(page.read_text(), page.parent) if not link.exists()] == []


def test_blocks_that_need_no_building_are_right(tmp_path: Path) -> None:
    checks = {"toml": blocks._toml, "sh": blocks._command, "c": blocks._c}
    found = [(str(block), checks[block.language](block.text)) for block in blocks.blocks(ROOT) if block.language in checks]
    assert len(found) > 20 and [fault for fault in found if fault[1]] == []
    (tmp_path / "docs").mkdir()
    wrong = "    phichain simulate SCENE --tea 3\n\n```toml\n[chain]\nmas = 1\n```\n\n```c\nint a = ;\n```\n\n```python\nraise SystemExit(1)\n```\n\n```ruby\n```\n"
    (tmp_path / "README.md").write_text(wrong)
    said = blocks.faults(tmp_path)
    assert len(said) == 5 and "no option --tea" in said[2] + said[3] + "".join(said) and any('did you mean "mass"' in line for line in said)


def test_python_that_nothing_runs_is_told(tmp_path: Path) -> None:
    assert list(blocks.indented(ROOT)) == []
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text("Words.\n\n    motor = rigs.Motor(resistance=0.4)\n\n    phase = c_call(&state, t);\n\n```text\n    import this\n```\n\n    phichain info\n")
    assert list(blocks.indented(tmp_path)) == ["README.md:3: is Python that nothing runs; fence it as ```python"]


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


def test_every_address_outside_is_one_that_is_known(tmp_path: Path) -> None:
    assert links.faults() == []
    (tmp_path / "README.md").write_text("[there](https://example.com/nowhere), and https://doi.org/10.1109/CDC.2012.6427059.\n")
    found = links.faults(tmp_path)
    assert found[0] == "README.md: https://example.com/nowhere is not in docs/site/links.py"
    assert len(found) == len(links.KNOWN) and all("is named nowhere" in fault for fault in found[1:])


@pytest.mark.parametrize("address", ("https://doi.org/6427059", "https://nohost", "ftp://example.org/a", "example.org", "https:///a"))
def test_what_is_no_address_is_told(address: str) -> None:
    assert not links._is_address(address)


def test_an_address_that_is_gone_is_told_from_one_that_turns_programs_away_and_from_no_network(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def refusing(code: int) -> Callable[..., NoReturn]:
        def refuse(request: urllib.request.Request, timeout: float) -> NoReturn:
            raise urllib.error.HTTPError(request.full_url, code, "said", Message(), None)

        return refuse

    for code, count in ((404, len(links.KNOWN) - len(links.NOT_FETCHED)), (403, 0)):
        monkeypatch.setattr(urllib.request, "urlopen", refusing(code))
        assert links.main() == count

    def lost(*_: object, **__: object) -> NoReturn:
        raise urllib.error.URLError("no route")

    monkeypatch.setattr(urllib.request, "urlopen", lost)
    capsys.readouterr()
    assert links.main() == 0 and "no network to ask in (no route)" in capsys.readouterr().out
