"""A command run to its end: what it printed, and nothing of it left behind.

What a command starts may outlive it and keep its output open, so reading to the end of the output could wait for ever. Here
the command's own end counts: what it has printed by then is taken, and its whole process group is ended.
"""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Final

_LONGEST: Final = 2**20
"""Bytes that are kept of each output."""
_LAST_LOOKS: Final = 16
"""More than a full pipe takes to read."""
_LOOK: Final = 0.05
"""Seconds between looks at a command whose output somebody keeps open, or that closed it and goes on."""


class OutlastedError(Exception):
    """A command ran longer than it may; it was ended."""


def finished(
    command: Sequence[str], folder: Path, environment: Mapping[str, str], timeout: float
) -> tuple[int, str, str]:
    """Run a command in a process group of its own.

    Args:
        command: Its words.
        folder: Where it runs.
        environment: Its variables.
        timeout: Seconds that it may take.

    Returns:
        Its exit code, or minus the signal that ended it, and what it printed, the first mebibyte of either output.

    Raises:
        OutlastedError: It took longer.
        OSError, ValueError: It cannot be started.
    """
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None and process.stderr is not None
    pipes = (process.stdout, process.stderr)
    try:
        output, complaint = _printed(process, pipes, time.monotonic() + timeout)
    finally:
        # The leader may be gone: its number still names the group while a member lives.
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for pipe in pipes:
            pipe.close()
    return process.returncode, output, complaint


def _printed(process: subprocess.Popen[bytes], pipes: Sequence[IO[bytes]], deadline: float) -> tuple[str, ...]:
    """What a command prints until it ends."""
    kept: dict[IO[bytes], bytes] = dict.fromkeys(pipes, b"")
    with selectors.DefaultSelector() as open_pipes:
        for pipe in pipes:
            os.set_blocking(pipe.fileno(), False)
            open_pipes.register(pipe, selectors.EVENT_READ)
        while True:
            # Asked before the last looks at the pipes: what it printed before its end is in them, and fits into few.
            has_ended = process.poll() is not None
            _take(open_pipes, kept, 0.0 if has_ended else _LOOK)
            if has_ended:
                for _ in range(_LAST_LOOKS):
                    _take(open_pipes, kept, 0.0)
                break
            if time.monotonic() > deadline:
                raise OutlastedError
            if not open_pipes.get_map():
                with suppress(subprocess.TimeoutExpired):
                    process.wait(_LOOK)
    return tuple(text.decode(errors="replace") for text in kept.values())


def _take(pipes: selectors.BaseSelector, kept: dict[IO[bytes], bytes], wait: float) -> None:
    """Read once what is there; an output that was closed is looked at no more."""
    for key, _ in pipes.select(wait) if pipes.get_map() else ():
        pipe: IO[bytes] = key.fileobj  # type: ignore[assignment]
        text = os.read(pipe.fileno(), _LONGEST)
        kept[pipe] += text[: _LONGEST - len(kept[pipe])]
        if not text:
            pipes.unregister(pipe)
