"""One HTML page from titles, sentences, tables and pictures: no script, no server, no template engine.

Jinja renders the generated code and nothing else, so this page is put together here; every text passes through
`html.escape`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

from phichain.report.origins import MADE_BY

_STYLE = """
:root { color-scheme: light dark; --ink: #1c2430; --soft: #5a6675; --line: #d9dee5; --paper: #ffffff; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ee; --soft: #a3adba; --line: #38414d; --paper: #14181e; }
}
body { margin: 0 auto; max-width: 60rem; padding: 2rem 1.5rem 4rem; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.9rem; margin: 0 0 .4rem; } h2 { font-size: 1.3rem; margin: 2.6rem 0 .4rem; }
p { max-width: 46rem; } .lead, figcaption { color: var(--soft); }
table { border-collapse: collapse; margin: .8rem 0; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .3rem 1.2rem .3rem 0; text-align: left; vertical-align: top; }
th { font-weight: 500; white-space: nowrap; color: var(--soft); }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; border: 1px solid var(--line); background: #fff; }
code { font-size: .92em; }
footer { margin-top: 3rem; color: var(--soft); font-size: .9rem; }
"""


@dataclass(frozen=True)
class Section:
    """One part of a report.

    Attributes:
        title: Heading.
        text: What was done and how to read the figure.
        rows: A table of two columns: what, and its value.
        figure: File name of a picture beside the page, or None.
        caption: What the picture shows; it is the picture's alternative text too.
    """

    title: str
    text: str = ""
    rows: tuple[tuple[str, str], ...] = ()
    figure: str | None = None
    caption: str = ""


def page(title: str, lead: str, sections: Iterable[Section], footer: str = "") -> str:
    """Return the whole page as HTML text."""
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en">',
            '<head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">',
            f'<meta name="generator" content="{escape(MADE_BY)}">',
            f"<title>{escape(title)}</title><style>{_STYLE}</style></head>",
            f'<body>\n<h1>{escape(title)}</h1>\n<p class="lead">{escape(lead)}</p>',
            *(_section(section) for section in sections),
            f"<footer>{escape(footer)}</footer>\n</body>\n</html>\n",
        ]
    )


def _section(section: Section) -> str:
    parts = [f"<section>\n<h2>{escape(section.title)}</h2>"]
    if section.text:
        parts.append(f"<p>{escape(section.text)}</p>")
    if section.rows:
        rows = "\n".join(
            f"<tr><th>{escape(what)}</th><td>{escape(value)}</td></tr>" for what, value in section.rows
        )
        parts.append(f"<table>\n{rows}\n</table>")
    if section.figure:
        source, words = escape(section.figure), escape(section.caption)
        parts.append(f'<figure><img src="{source}" alt="{words}"><figcaption>{words}</figcaption></figure>')
    return "\n".join([*parts, "</section>"])
