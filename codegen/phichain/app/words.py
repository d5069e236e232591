"""Words on the command line that are no commands and no options: what is meant by them, in one line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from typer.core import TyperGroup

from phichain.errors import UnsupportedError

_COMMANDS: Final = {
    "rigs": "call phichain.rigs from Python (docs/rigs.md)",
    "regulator": 'say "phichain lqr SCENE", or "phichain controller SCENE" for the law in C',
    "plot": "give --out FILE.png to simulate, trace or lqr",
    "run": 'say "phichain simulate SCENE", or "phichain tour" for the whole path',
    "test": 'compile selftest.c of what "phichain generate SCENE" writes',
    "compile": 'say "phichain build SCENE"',
    "scenes": 'see "phichain info"',
    "list": 'see "phichain functions" and "phichain info"',
    "help": 'say "phichain -h", or "phichain COMMAND -h"',
    "version": 'say "phichain --version"',
}


class Commands(TyperGroup):
    """The commands of phichain, with an answer to what is none."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first word names.

        Raises:
            UnsupportedError: It names none.
        """
        word = args[0]
        if self.get_command(ctx, word) is None and not word.startswith("-"):
            raise UnsupportedError("command", word, *_command(word, self.list_commands(ctx)))
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run a command.

        Raises:
            UnsupportedError: One of its options is none.
        """
        try:
            return super().invoke(ctx)
        except Exception as refusal:
            # Some versions of typer bring a click of their own, so the class has no one place to import it from.
            if type(refusal).__name__ != "NoSuchOption":
                raise
            word, command = str(getattr(refusal, "option_name", "")), getattr(refusal, "ctx", ctx).command
            options = [name for parameter in command.params for name in parameter.opts if name.startswith("--")]
            raise UnsupportedError("option", word, *_option(word, str(command.name), options)) from None


def _command(word: str, commands: Sequence[str]) -> tuple[str, str]:
    """Problem and remedy."""
    from phichain.contract.functions import ROWS

    if word in _COMMANDS:
        return "is not a command", _COMMANDS[word]
    if word in ROWS:
        return "is a function of scenes and no command", f'add "{word}" to [functions] want of a scene, and build it'
    return _meant(word, "is not a command", "commands", commands)


def _option(word: str, command: str, options: Sequence[str]) -> tuple[str, str]:
    if not options:
        return f"is not an option of {command}", "leave it out: that command has none"
    return _meant(word, f"is not an option of {command}", "options", options)


def _meant(word: str, problem: str, kind: str, valid: Sequence[str]) -> tuple[str, str]:
    from phichain.contract.words import nearest
    from phichain.scene.words import answer_of

    known = f"{kind} are {', '.join(valid)}"
    if near := nearest(word, valid):
        return problem, f'did you mean "{near}"? The {known}'
    if answer := answer_of(word.lstrip("-")):
        return f"{problem} and {answer.problem}", answer.remedy
    return problem, f"the {known}"
