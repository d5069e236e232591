"""How Sphinx builds the site from the staged tree: MyST pages, notebooks that are run, docstrings as they are written, formulas as MathML, nothing from a network."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "codegen"), str(ROOT)]

import phichain
from docs.site import gallery

project = "phichain"
author = copyright = "The phichain authors"
version = release = phichain.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_gallery.gen_gallery"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4
# Pages link to scripts and scenes, which are copied beside them, and to each other as they do in the repository.
exclude_patterns = [".doctrees", "examples/**", f"{gallery.FOLDER}/*.ipynb"]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext"}
default_role = "code"
# A picture's figure within a table, TOML with inline tables over several lines, and cells of notebooks that are left unrun are no faults.
suppress_warnings = ["myst.header", "misc.highlighting_failure", "myst-nb.lexer"]

# Notebooks are run anew with every build, each in a folder of its own, and one cell that fails fails the site.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 120
nb_merge_streams = True
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT / "codegen"), str(ROOT)])

sphinx_gallery_conf = gallery.settings(ROOT / "build" / "site")

html_theme = "furo"
html_title = f"phichain {release}"
html_show_sourcelink = False
html_copy_source = False
html_math_renderer = "mathml"
html_last_updated_fmt = None

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

_PLAIN = ((r"\\[Bb]ig", ""), (r"\\textstyle", ""), (r"\\dots", r"\\ldots "), (r"\\tfrac(\d)(\d)", r"\\frac{\1}{\2}"), (r"\\(?:tfrac|dfrac)", r"\\frac"))
"""What docutils does not know of LaTeX, in what it knows."""
_ACCENT = re.compile(r"\\(ddot|dot|hat|bar|tilde|vec)\s*(\{[^{}]*\}|\\[A-Za-z]+|[A-Za-z])")
"""An accented letter, which docutils would give its index as a limit below."""


def mathml(text: str, block: bool) -> str:
    """A formula as browsers draw it themselves."""
    for pattern, plain in _PLAIN:
        text = re.sub(pattern + r"(?![A-Za-z])" if pattern[-1].isalpha() else pattern, plain, text)
    text = _ACCENT.sub(r"{{}\\\1 \2}", text)
    try:
        found: str = tex2mathml(text, as_block=block)
    except MathError as fault:
        logging.getLogger(__name__).warning("formula %s: %s", text, fault)
        return ""
    return found


def _inline(self: Any, node: nodes.Element) -> None:
    self.body.append(mathml(node.astext(), False))
    raise nodes.SkipNode


def _display(self: Any, node: nodes.Element) -> None:
    self.body.append(f'<div class="math" style="overflow-y: hidden; padding-block: 0.3em">{mathml(node.astext(), True)}</div>')
    raise nodes.SkipNode


def as_written(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Let a docstring's |x|, * and trailing _ stand for themselves, which reStructuredText reads otherwise."""
    for k, line in enumerate(lines):
        parts = re.split(r"(``.*?``|`[^`]*`)", line)
        parts[::2] = [re.sub(r"([|*\\])|(?<=\w)(_)(?![\w])", lambda found: "\\" + found[0], part) for part in parts[::2]]
        lines[k] = "".join(parts)


def setup(app: Any) -> None:
    """Register what this site does its own way."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    app.connect("autodoc-process-docstring", as_written, priority=300)
    app.connect("source-read", gallery.without_folders)
