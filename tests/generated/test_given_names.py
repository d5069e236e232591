"""Names that people give to what C sees, a scene and a hook: refused, or C and C++ take them."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from phichain.errors import SceneError
from phichain.scene import Scene
from phichain.scene.checks.name import LONGEST_NAME, function_name, scene_name
from phichain.scratch import folder_texts
from tests.generated.compiling import run
from tests.scene.test_scene_name import C11_AND_C23, C99, CPP20

_OF_MATHEMATICS = "sin cos tan exp log pow sqrt fabs floor tgamma hypot j0 fmin cexp atan2 nan trunc"
_OF_THE_LIBRARY = "printf memcpy strlen malloc exit main abs rand qsort puts clock time system signal raise"
_PLAIN = "sine restricted my_int short_one register1 sincos_of turned Double my_sincos_fast k9 shorter IntegerTurns"
CANDIDATES = (
    *C99.split(), *C11_AND_C23.split(), *CPP20.split(), *_OF_THE_LIBRARY.split(), "_X", "_x", "a__b", "NULL", "EOF", "NAN", "INFINITY",
    *(name + precision for name in _OF_MATHEMATICS.split() for precision in ("", "f", "l")), *_PLAIN.split(),
)  # fmt: skip
DIALECTS = (("cc", "-std=c99"), ("cc", "-std=gnu17"), ("c++", "-std=c++11"), ("c++", "-std=gnu++20"))
HOOK = "board_sincos"


def accepted(name: str, hook: bool) -> bool:
    try:
        function_name("trig_hook", name) if hook else scene_name(name)
    except SceneError:
        return False
    return True


@pytest.mark.parametrize("hook", [True, False], ids=["function", "prefix"])
def test_accepted_names_are_taken_by_every_dialect(hook: bool, tmp_path: Path) -> None:
    """All in one file, a function, or a type and a namespace's worth of names each, behind the library's headers."""
    names = [name for name in dict.fromkeys(CANDIDATES) if accepted(name, hook)]
    assert set(_PLAIN.split()) <= set(names) and len(names) < len(CANDIDATES) - 120
    headers = ("assert", "complex", "ctype", "errno", "float", "limits", "math", "signal", "stdint", "stdio", "stdlib", "string", "time")
    for compiler, dialect in DIALECTS:
        kept = [header for header in headers if compiler == "cc" or header != "complex"]
        lines = [f"#include <{header}.h>" for header in kept]
        for name in names:
            if hook:
                lines.append(f"extern void {name}(float angle, float *sine, float *cosine);")
            elif compiler == "cc":
                lines.append(f"typedef float {name}_real;\nextern void {name}_step({name}_real *x);\nstruct {name} {{ int x; }};")
            else:
                lines.append(f"namespace {name} {{ typedef float real; }}")
        (tmp_path / "names.c").write_text("\n".join(lines) + "\n")
        run(compiler, dialect, *(("-x", "c++") if compiler == "c++" else ()), "-Werror", "-fsyntax-only", tmp_path / "names.c")


@pytest.mark.parametrize("name", ["short", "int", "restrict", "register", "class", "_X", "sinf", "cosl", "sqrt", "printf"])
def test_reserved_words_are_refused_as_prefix_and_as_hook(name: str) -> None:
    for refused in ({"name": name}, {"name": "own", "trig": "hook", "trig_hook": name}):
        with pytest.raises(SceneError, match=r"keyword|reserves|C library"):
            Scene(links=1, mass=1.0, length=0.5, **refused)  # type: ignore[arg-type]


def test_a_hook_called_as_generated_code_calls_its_own_is_refused_because_it_would_not_compile(tmp_path: Path) -> None:
    def texts(hook: str) -> dict[str, str]:
        scene = Scene("own", 1, mass=1.0, length=0.5, want=("forward_dynamics",), real="float", trig="hook", trig_hook=hook)
        return folder_texts(scene, False, False)

    good = texts(HOOK)
    for word, file in (("k", "own.c"), ("sine", "own.c"), ("compare", "selftest.c")):
        with pytest.raises(SceneError, match=r"target\.trig_hook: is a name that the generated code uses itself"):
            texts(word)
        for name in ("own.h", "own.c", "selftest.c"):
            (tmp_path / name).write_text(good[name].replace(HOOK, word))
        words = ["cc", "-std=c99", "-fsyntax-only", file]
        assert subprocess.run(words, cwd=tmp_path, capture_output=True, check=False).returncode != 0, word
        for name in ("own.h", "own.c", "selftest.c"):
            (tmp_path / name).write_text(good[name])
        run(*words, cwd=tmp_path)


def test_names_may_be_as_long_as_said() -> None:
    assert accepted("a" * LONGEST_NAME, hook=False) and accepted("a" * 63, hook=True) and not accepted("a" * 64, hook=True)
