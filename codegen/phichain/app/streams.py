"""The streams that the command prints on."""

from __future__ import annotations

import io
import sys


def print_anything() -> None:
    """Let names that the terminal's encoding has no letters for, as files may have, come out as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
