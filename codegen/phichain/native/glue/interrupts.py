"""Ctrl-C out of long C: each foreign function that may run long has a twin that a signal can leave at any time.

Python's own handler only takes note of SIGINT, and raises KeyboardInterrupt when the foreign call is over, which may be minutes
later. The twin marks where it was entered, lets SIGINT jump back there while the function runs, and puts the handler back that it
found. The functions compute in memory that their caller gave them and neither allocate nor lock, so nothing is left undone. They
run as they are: the standalone C is the same, and so is every bit of its results. The glue is compiled into the loaded shared
object and never written into a generated folder.
"""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Foreign:
    """A C function with a twin.

    Attributes:
        symbol: Its name in C.
        returns: The C type of its result.
        arguments: Type and name of each of its arguments, a star with the name.
    """

    symbol: str
    returns: str
    arguments: tuple[tuple[str, str], ...]

    @property
    def declaration(self) -> str:
        """How C declares it."""
        return f"{self.returns} {self.symbol}({', '.join(f'{kind} {name}' for kind, name in self.arguments)})"

    @property
    def twin(self) -> str:
        """Name of the twin."""
        return f"{self.symbol}_until_interrupted"


class Interruptible:
    """A foreign function, called through its twin wherever Ctrl-C means KeyboardInterrupt."""

    def __init__(self, library: ctypes.CDLL, symbol: Foreign) -> None:
        """Take function and twin from a library."""
        self._plain, self._twin = library[symbol.symbol], library[symbol.twin]

    @property
    def restype(self) -> Any:
        """The ctypes of the result."""
        return self._plain.restype

    @restype.setter
    def restype(self, kind: Any) -> None:
        self._plain.restype = self._twin.restype = kind

    @property
    def briefly(self) -> Callable[..., Any]:
        """The function itself, for calls that are over before anybody could press Ctrl-C: the way through the twin asks the system twice."""
        plain: Callable[..., Any] = self._plain
        return plain

    def __call__(self, *arguments: Any) -> Any:
        """Call C.

        Raises:
            KeyboardInterrupt: Ctrl-C came meanwhile; what C was to fill is half filled.
        """
        if not _is_ours():
            return self._plain(*arguments)
        stopped = ctypes.c_int(0)
        result = self._twin(ctypes.byref(stopped), *arguments)
        if stopped.value:
            raise KeyboardInterrupt
        return result


def _is_ours() -> bool:
    """Whether this thread is the one that signals interrupt, and nobody has other plans for SIGINT."""
    is_main = threading.get_ident() == threading.main_thread().ident
    return is_main and getsignal(_SIGINT) is signal.default_int_handler


_SIGINT = int(signal.SIGINT)
getsignal = sys.modules["_signal"].getsignal
"""signal.getsignal looks every handler up among its enumerations first, which takes longer than a call."""


def interrupts_source(name: str, functions: Sequence[Foreign]) -> str:
    """C text of what the twins share, and the twins."""
    return "\n".join([_SHARED.replace("NAME", name), *(_twin(name, function) for function in functions)])


def _twin(name: str, function: Foreign) -> str:
    given = ", ".join(argument.lstrip("*") for _, argument in function.arguments)
    has_result = function.returns != "void"
    declared = Foreign(function.twin, function.returns, (("int", "*stopped"), *function.arguments)).declaration
    lines = [
        f"{declared};",
        declared,
        "{",
        *([f"    {function.returns} result;"] if has_result else []),
        f"    if (sigsetjmp({name}_entry, 0)) {{",
        f"        sigaction(SIGINT, &{name}_before, NULL);",
        "        *stopped = 1;",
        f"        return{' 0' if has_result else ''};",
        "    }",
        f"    {name}_enter();",
        f"    {'result = ' if has_result else ''}{function.symbol}({given});",
        f"    {name}_leave();",
        *(["    return result;"] if has_result else []),
        "}",
        "",
    ]
    return "\n".join(lines)


_SHARED = """\
static sigjmp_buf NAME_entry;
static pthread_t NAME_thread;
static volatile sig_atomic_t NAME_is_inside;
static struct sigaction NAME_before;
static int NAME_is_ready;

/* A signal that comes to another thread is passed on. */
static void NAME_interrupted(int number)
{
    if (NAME_is_inside) {
        if (pthread_equal(pthread_self(), NAME_thread)) {
            NAME_is_inside = 0;
            siglongjmp(NAME_entry, 1);
        }
        pthread_kill(NAME_thread, number);
    } else if (!(NAME_before.sa_flags & SA_SIGINFO) && NAME_before.sa_handler != SIG_DFL
               && NAME_before.sa_handler != SIG_IGN) {
        NAME_before.sa_handler(number);
    }
}

/* A process that another thread forks meanwhile has no thread inside: it handles signals as before. */
static void NAME_forked(void)
{
    if (NAME_is_inside) {
        NAME_is_inside = 0;
        sigaction(SIGINT, &NAME_before, NULL);
    }
}

static void NAME_enter(void)
{
    struct sigaction ours, before;
    memset(&ours, 0, sizeof ours);
    ours.sa_handler = NAME_interrupted;
    /* Not held back while it is handled: then the jump has no mask to put back, and entering none to ask for. */
    ours.sa_flags = SA_NODEFER;
    sigemptyset(&ours.sa_mask);
    NAME_thread = pthread_self();
    if (!NAME_is_ready) {
        /* What stands there now is known before a signal can ask for it; later it is what stood there last time. */
        sigaction(SIGINT, NULL, &NAME_before);
        NAME_is_ready = pthread_atfork(NULL, NULL, NAME_forked) == 0;
    }
    NAME_is_inside = 1;
    sigaction(SIGINT, &ours, &before);
    NAME_before = before;
}

static void NAME_leave(void)
{
    NAME_is_inside = 0;
    sigaction(SIGINT, &NAME_before, NULL);
}
"""

HEADERS = (
    "#define _POSIX_C_SOURCE 200809L",
    "#include <math.h>",
    "#include <pthread.h>",
    "#include <setjmp.h>",
    "#include <signal.h>",
    "#include <stddef.h>",
    "#include <string.h>",
)
"""What the shared part needs, at the top of its file."""
