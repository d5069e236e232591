"""Notebooks and gallery: what the site runs, and that one failure fails it."""

from __future__ import annotations

import ast
import re
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest

from docs.site import gallery, stage

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.md"))
SCRIPTS = sorted((ROOT / "examples").glob("*.py"))
_CELL = re.compile(r"^```\{code-cell\}\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_a_notebook_is_one_that_is_run_and_taken_along(page: Path) -> None:
    text = page.read_text()
    assert text.startswith("---\nfile_format: mystnb\nkernelspec:\n  name: python3\n---\n")
    assert f"{{nb-download}}`{page.stem}.ipynb`" in text
    cells = _CELL.findall(text)
    assert len(cells) >= 4 and all(ast.parse(cell).body for cell in cells)
    assert "```python" not in text and text.count("```{") == len(cells)


def test_the_ladder_has_every_notebook_and_each_leads_to_the_next() -> None:
    names = [Path(name).name for name in dict(stage.LADDER)["Tutorial"]]
    assert sorted(names) == [page.stem for page in NOTEBOOKS]
    for k, (name, following) in enumerate(zip(names, [*names[1:], None], strict=True), 1):
        text = (ROOT / "docs" / "notebooks" / f"{name}.md").read_text()
        assert f"# {k}. " in text and (following is None or f"]({following}.md)." in text)


def test_a_cell_that_fails_fails_the_site() -> None:
    conf = runpy.run_path(str(ROOT / "docs" / "site" / "conf.py"))
    assert conf["nb_execution_mode"] == "force" and conf["nb_execution_raise_on_error"] and conf["nb_execution_timeout"] <= 120
    assert not any(conf["sphinx_gallery_conf"].get(word) for word in ("only_warn_on_example_error", "expected_failing_examples"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_says_what_the_gallery_needs(script: Path) -> None:
    text = script.read_text()
    title, line, empty, *_ = (ast.get_docstring(ast.parse(text)) or "").splitlines()
    assert set(line) == {"="} and len(line) == len(title) and not empty
    assert (script.stem in gallery.LONG) == ("sphinx_gallery_thumbnail_path" in text)
    assert all((ROOT / address).is_file() for address in re.findall(r"thumbnail_path = '([^']+)'", text))


def test_what_a_script_writes_is_shown_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    figures = tmp_path / "generated" / "figures"
    figures.mkdir(parents=True)
    for name in ("one", "two"):
        (figures / f"{name}.png").write_bytes(b"png")
    block = {"image_path_iterator": (str(tmp_path / f"shown_{k}.png") for k in range(9))}
    rst = gallery.saved(SimpleNamespace(), block, {"src_dir": str(tmp_path)})
    assert "shown_0.png" in rst and "shown_1.png" in rst and not list(figures.iterdir())
    assert gallery.saved(SimpleNamespace(), block, {"src_dir": str(tmp_path)}) == ""


def test_pages_of_scripts_say_no_folder_of_the_machine_that_built_them() -> None:
    app, text = SimpleNamespace(srcdir="/there/build/site"), "wrote /there/build/site/examples/generated/figures/a.png"
    for name, said in ((f"{gallery.FOLDER}/a", "wrote generated/figures/a.png"), ("docs/start", text)):
        source = [text]
        gallery.without_folders(app, name, source)
        assert source == [said]


def test_the_gallery_begins_with_the_figures_of_both_papers() -> None:
    text = gallery.head(ROOT)
    shown = re.findall(r"^\.\. image:: /(docs/img/\S+)$", text, re.MULTILINE)
    assert len(shown) >= 5 and all((ROOT / address).is_file() for address in shown)
    assert "   :target: ../docs/gallery.html#b2-the-chain-left-alone\n" in text


def test_a_link_that_leads_nowhere_is_told(tmp_path: Path) -> None:
    assert stage.dead(ROOT) == []
    (tmp_path / "docs" / "notebooks").mkdir(parents=True)
    (tmp_path / "docs" / "notebooks" / "a.md").write_text("[b](b.md) and [a](a.md)\n")
    (told,) = stage.dead(tmp_path)
    assert told.startswith("docs/notebooks/a.md: there is no ") and told.endswith("b.md")
