"""The curated names of `phichain`: all there, all lazy, and verbs that share a name with a subpackage stay verbs."""

from __future__ import annotations

import subprocess
import sys

import pytest

import phichain


def answers(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_phichain_imports_nothing_heavy() -> None:
    heavy = "{'numpy', 'scipy', 'sympy', 'mpmath', 'jinja2', 'casadi', 'matplotlib', 'typer', 'rich'}"
    assert answers(f"import sys, phichain; print(sorted({heavy} & set(sys.modules)))") == "[]"


def test_the_command_line_imports_no_numerics_before_it_needs_them() -> None:
    heavy = "{'numpy', 'scipy', 'sympy', 'mpmath', 'jinja2', 'casadi', 'matplotlib'}"
    assert answers(f"import sys, phichain.app.cli; print(sorted({heavy} & set(sys.modules)))") == "[]"


@pytest.mark.parametrize("name", phichain.__all__)
def test_every_public_name_is_there_and_documented(name: str) -> None:
    value = getattr(phichain, name)
    assert name in dir(phichain)
    assert value.__doc__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        phichain.simulat  # noqa: B018


def test_no_public_name_is_a_subpackage() -> None:
    """`phichain.simulate` is the function, whatever was imported before: no package shares its name."""
    code = """
import phichain.app.cli, phichain.papers.figures
import phichain, types
print([name for name in phichain.__all__ if isinstance(getattr(phichain, name), types.ModuleType)])
"""
    assert answers(code) == "[]"
