"""The system compiler: found, identified, and its failures told in one sentence."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from phichain.errors import CompilerError, OutputError
from phichain.native import Cache, CompilerOptions, build_folder, find_compiler
from phichain.native.compiler import Compiler, compile_shared, run
from tests.native import generated_folder

REAL_COMPILER = shutil.which("cc") or shutil.which("gcc") or "cc"
ANSWERS = f'case "$*" in *-dM*|*--version*|*-dumpmachine*) exec {REAL_COMPILER} "$@";; esac\n'

FakeCompiler = Callable[[str], Path]


@pytest.fixture
def fake_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeCompiler:
    """Make a shell script the system compiler."""

    def install(script: str) -> Path:
        path = tmp_path / "fakecc"
        path.write_text(f"#!/bin/sh\n{script}")
        path.chmod(0o755)
        monkeypatch.setenv("CC", str(path))
        return path

    return install


def test_default_flags_keep_nan_and_order_of_operations() -> None:
    flags = CompilerOptions().flags
    assert {"-std=c99", "-O3", "-march=native", "-ffp-contract=fast", "-fPIC", "-shared"} <= set(flags)
    assert not {"-ffast-math", "-Ofast", "-ffinite-math-only", "-fassociative-math"} & set(flags)


def test_options_digest_tells_flags_apart_and_ignores_the_time_limit() -> None:
    options = CompilerOptions()
    assert options.digest == CompilerOptions(timeout=1.0).digest
    assert len({options.digest, options.portable().digest, CompilerOptions(libraries=()).digest}) == 3


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan")])
def test_time_limit_must_be_positive(timeout: float) -> None:
    with pytest.raises(CompilerError, match="must be positive"):
        CompilerOptions(timeout=timeout)


def test_compiler_is_found_and_says_who_it_is() -> None:
    compiler = find_compiler()
    assert os.path.isabs(compiler.command[0])
    assert compiler.version and compiler.target and len(compiler.macros) == 64


def test_first_candidate_on_the_path_is_taken(tmp_path: Path) -> None:
    for name in ("clang", "gcc"):
        (tmp_path / name).symlink_to(REAL_COMPILER)
    assert find_compiler(environment={"PATH": str(tmp_path)}).command == (str(tmp_path / "gcc"),)


def test_words_of_cc_are_passed_on() -> None:
    compiler = find_compiler(environment={"PATH": os.environ["PATH"], "CC": "cc -DFIRST='a b'"})
    assert compiler.command[1:] == ("-DFIRST=a b",)


@pytest.mark.parametrize("environment", [{"PATH": "/nowhere"}, {"PATH": "/nowhere", "CC": " "}])
def test_missing_compiler(environment: dict[str, str]) -> None:
    with pytest.raises(CompilerError, match="no C compiler was found") as caught:
        find_compiler(environment=environment)
    assert "install gcc or clang" in caught.value.remedy


@pytest.mark.parametrize("chosen", ["no-such-compiler", "/nowhere/cc", "'unfinished"])
def test_cc_that_is_not_there_is_not_replaced_silently(chosen: str) -> None:
    with pytest.raises(CompilerError) as caught:
        find_compiler(environment={**os.environ, "CC": chosen})
    assert caught.value.field == "CC"
    assert caught.value.value == chosen


def test_failing_compiler_is_quoted(folder: Path, cache: Cache) -> None:
    folder = generated_folder.write(
        folder / "broken", source='#include "duo.h"\nint broken(void) { return }\n'
    )
    with pytest.raises(CompilerError) as caught:
        build_folder(folder, cache=cache)
    error = caught.value
    assert "compiling duo failed" in str(error)
    assert "duo.c:2" in str(error), "the message does not lead to the line"
    assert error.code == 1
    assert "-O3" in error.command
    assert any("error" in line for line in error.stderr)
    assert "\n" not in str(error)
    assert str(cache.root) not in str(error)
    assert list(cache.root.iterdir()) == [], "a failed build left something in the cache"


def test_compiler_ended_by_a_signal(fake_compiler: FakeCompiler, folder: Path, cache: Cache) -> None:
    fake_compiler(f"{ANSWERS}kill -9 $$")
    with pytest.raises(CompilerError, match="was ended by signal 9"):
        build_folder(folder, cache=cache)


def test_compiler_that_never_answers(fake_compiler: FakeCompiler) -> None:
    fake_compiler("sleep 600")
    with pytest.raises(CompilerError, match="still ran after 0.3 s and was stopped"):
        find_compiler(CompilerOptions(timeout=0.3))


def test_hanging_compiler_ends_with_all_it_started(
    fake_compiler: FakeCompiler, folder: Path, cache: Cache, tmp_path: Path
) -> None:
    fake_compiler(f"{ANSWERS}sleep 600 & echo $! > {tmp_path}/started; wait")
    find_compiler()
    start = time.monotonic()
    with pytest.raises(CompilerError, match="still ran after 1 s") as caught:
        build_folder(folder, CompilerOptions(timeout=1.0), cache)
    assert "raise the time limit" in caught.value.remedy
    assert time.monotonic() - start < 60.0
    assert list(cache.root.iterdir()) == []
    assert not is_running(int((tmp_path / "started").read_text()))


def is_running(process: int) -> bool:
    """Whether a process does more than wait for its parent to notice its end."""
    for _ in range(100):
        try:
            os.kill(process, 0)
            state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[-1].split()[0]
        except (ProcessLookupError, FileNotFoundError):
            return False
        if state == "Z":
            return False
        time.sleep(0.05)
    return True


@pytest.mark.parametrize("lie", ["true", "touch library.so", "echo nonsense > library.so"])
def test_success_without_a_result(fake_compiler: FakeCompiler, folder: Path, cache: Cache, lie: str) -> None:
    fake_compiler(f"{ANSWERS}{lie}")
    with pytest.raises(CompilerError) as caught:
        build_folder(folder, cache=cache)
    assert "CC" in caught.value.remedy
    assert cache.info().entries == 0


def test_full_disk_is_not_blamed_on_the_source(
    fake_compiler: FakeCompiler, folder: Path, cache: Cache
) -> None:
    fake_compiler(f"{ANSWERS}echo 'ld: final link failed: No space left on device' >&2; exit 1")
    with pytest.raises(OutputError, match="full disk"):
        build_folder(folder, cache=cache)


def test_march_native_is_left_out_where_it_is_refused(
    fake_compiler: FakeCompiler, folder: Path, cache: Cache
) -> None:
    native = find_compiler()
    fake_compiler(
        f'case "$*" in *-march=native*) echo no such -march >&2; exit 1;; esac\nexec {REAL_COMPILER} "$@"'
    )
    compiler = find_compiler()
    assert compiler.options == CompilerOptions().portable()
    assert compiler.digest != native.digest
    assert "forward_dynamics" in build_folder(folder, cache=cache).functions


def test_identity_tells_processors_apart_and_ignores_where_the_compiler_stands(tmp_path: Path) -> None:
    (tmp_path / "cc").symlink_to(REAL_COMPILER)
    here = find_compiler(environment={"PATH": str(tmp_path)})
    assert here.digest == find_compiler(environment={"PATH": os.environ["PATH"], "CC": REAL_COMPILER}).digest
    # Another processor shows in the predefined macros alone; the flags read -march=native on both machines.
    baseline = find_compiler(CompilerOptions().portable())
    with_avx = find_compiler(CompilerOptions(flags=(*CompilerOptions().portable().flags, "-DSTANDS_FOR_AVX")))
    assert baseline.macros != with_avx.macros
    assert moved_to(here, baseline.macros).digest != moved_to(here, with_avx.macros).digest


def moved_to(compiler: Compiler, macros: str) -> Compiler:
    """The same installation on a processor with other instruction sets."""
    return Compiler(
        compiler.command, compiler.version, compiler.target, macros, compiler.libc, compiler.options
    )


def test_upgraded_compiler_is_asked_again(fake_compiler: FakeCompiler) -> None:
    fake_compiler(f'exec {REAL_COMPILER} "$@"')
    before = find_compiler()
    fake_compiler(f'case "$*" in --version) echo next release; exit;; esac\nexec {REAL_COMPILER} "$@"')
    after = find_compiler()
    assert after.version == "next release"
    assert after.digest != before.digest


def test_objects_do_not_depend_on_where_they_were_compiled(tmp_path: Path) -> None:
    objects = []
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
        objects.append(
            compile_shared(find_compiler(), {"x.c": b"int x(void) { return 1; }\n"}, tmp_path / name, "x")
        )
    assert objects[0] == objects[1]


def test_command_that_cannot_be_started(tmp_path: Path) -> None:
    with pytest.raises(CompilerError, match="cannot be started"):
        run(("/nowhere/cc",), tmp_path, 1.0, "nothing")
