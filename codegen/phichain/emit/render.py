"""The only Jinja environment: templates hold loops and names, every right-hand side arrives finished."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from phichain.identity import beside


def render(template: str, **names: object) -> str:
    """The text of a template with these names filled in; an undefined name is an error."""
    return _environment().get_template(template).render(**names)


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(beside("templates")), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip
