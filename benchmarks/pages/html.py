"""Self-contained HTML pages of tables and pictures: the pictures lie within the file."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from benchmarks.table import Table, circumstances
from phichain.report.origins import MADE_BY

_STYLE = """
:root { color-scheme: light dark; --ink: #1c2430; --soft: #5a6675; --line: #d9dee5; --paper: #ffffff; --wrong: #b42318; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ee; --soft: #a3adba; --line: #38414d; --paper: #14181e; --wrong: #ff8a7a; }
}
body { margin: 0 auto; max-width: 76rem; padding: 2rem 1.5rem 4rem; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.8rem; margin: 0 0 .4rem; } h2 { font-size: 1.2rem; margin: 2.4rem 0 .4rem; }
p { max-width: 56rem; } .soft, figcaption { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .6rem 0; font-variant-numeric: tabular-nums; font-size: .92em; }
th, td { border-bottom: 1px solid var(--line); padding: .2rem 1rem .2rem 0; text-align: right; vertical-align: top; }
th:first-child, td:first-child, td.words { text-align: left; } th { font-weight: 500; color: var(--soft); }
td.words { min-width: 16rem; } td.wrong { color: var(--wrong); font-weight: 600; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; border: 1px solid var(--line); background: #fff; }
"""


@dataclass(frozen=True)
class Figure:
    """A PNG file and what it shows."""

    path: Path
    caption: str


def write_page(path: Path, title: str, lead: str, figures: Sequence[Figure], tables: Sequence[Table]) -> Path:
    """Write one page: figures first, then tables; returns its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta name="generator" content="{escape(MADE_BY)}">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head>",
        f'<body><h1>{escape(title)}</h1><p class="soft">{escape(lead)}</p><p class="soft">{escape(circumstances())}</p>',
        *(_figure(figure) for figure in figures),
        *(_table(table) for table in tables),
        "</body></html>",
    ]
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")
    return path


def _figure(figure: Figure) -> str:
    data = base64.b64encode(figure.path.read_bytes()).decode()
    words = escape(figure.caption)
    return f'<figure><img alt="{words}" src="data:image/png;base64,{data}"><figcaption>{words}</figcaption></figure>'


def _table(table: Table) -> str:
    heads = "".join(f"<th>{_inline(column)}</th>" for column in table.columns)
    rows = "\n".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in table.rows)
    notes = "".join(f"<p>{_inline(note)}</p>" for note in table.notes)
    return f'<h2>{_inline(table.title)}</h2><div class="wide"><table><tr>{heads}</tr>\n{rows}</table></div>{notes}'


def _cell(cell: str) -> str:
    if cell.startswith("SILENTLY"):
        return f'<td class="words wrong">{_inline(cell)}</td>'
    return f'<td class="words">{_inline(cell)}</td>' if len(cell) > 24 else f"<td>{_inline(cell)}</td>"


def _inline(text: str) -> str:
    """Markdown's bold, italic and code, escaped."""
    found = escape(text)
    for mark, tag in ((r"\*\*", "strong"), (r"\*", "em"), ("`", "code")):
        found = re.sub(rf"{mark}(\S(?:.*?\S)?){mark}", rf"<{tag}>\1</{tag}>", found)
    return found
