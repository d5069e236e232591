"""What goes wrong on the way from a scene to code is one typed error, and nothing half-written stays behind."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from phichain.mechanics import derive
from phichain.native import Cache, CompilerOptions, build_folder
from phichain.emit import library_files
from phichain.errors import CompilerError, OutputError
from phichain.files import write_folder
from phichain.pipeline import build, generate
from phichain.lowering import lower
from phichain.scene import Scene, scene_from_dict, standard_scene
from phichain.contract.functions import ROWS
from phichain.system import System
from tests.offered import offered

ROOT = Path(__file__).parents[2]
SCENE = Scene("duo", 2, mass=[1.0, 2.0], length=1.0, want=["forward_dynamics", "energy"])


def everything_under(folder: Path) -> dict[str, bytes]:
    """Every file, hidden ones too, with its content; folders with nothing."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b""
        for path in folder.rglob("*")
    }


def phichain(
    *words: object, cwd: Path, before: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own, which runs a line of Python first."""
    script = f"import sys\n{before}\nfrom phichain.app.cli import main\nmain(sys.argv[1:])"
    variables = {**os.environ, "PYTHONPATH": str(ROOT / "codegen"), **environment}
    command = [sys.executable, "-c", script, *map(str, words)]
    return subprocess.run(
        command, cwd=cwd, env=variables, capture_output=True, text=True, check=False, timeout=300
    )


def failing(code: int) -> object:
    def fail(*arguments: object, **keywords: object) -> None:
        raise OSError(code, os.strerror(code))

    return fail


# --- folders that cannot be written ------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EIO])
@pytest.mark.parametrize("call", ["mkdir", "open", "fsync"])
def test_a_disk_that_refuses_leaves_no_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, code: int
) -> None:
    """Whichever of the system's calls fails first: making the folder, opening a file, forcing it to disk."""
    place = {"mkdir": (Path, "mkdir"), "open": (os, "open"), "fsync": (os, "fsync")}[call]
    with monkeypatch.context() as patch, pytest.raises(OutputError) as caught:
        patch.setattr(*place, failing(code))
        generate(SCENE, tmp_path / "deep" / "out")
    assert caught.value.field == "output"
    assert os.strerror(code) in str(caught.value) and caught.value.remedy
    assert everything_under(tmp_path) == {}


def test_a_full_disk_keeps_what_was_generated_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generate(SCENE, tmp_path)
    before = everything_under(tmp_path)
    with monkeypatch.context() as patch, pytest.raises(OutputError, match="free some space"):
        patch.setattr(os, "fsync", failing(errno.ENOSPC))
        generate(Scene("duo", 2, mass=3.0, length=2.0), tmp_path)
    assert everything_under(tmp_path) == before


@pytest.mark.long
def test_a_read_only_folder_is_named_by_the_command(tmp_path: Path) -> None:
    (tmp_path / "locked").mkdir(mode=0o500)
    if os.access(tmp_path / "locked", os.W_OK):
        out = Path("/proc/nowhere" if Path("/proc").is_dir() else "/dev/null/nowhere")
    else:
        out = tmp_path / "locked" / "out"
    done = phichain("generate", "planar1", "--out", out, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("phichain: output") and str(out) in done.stderr


@pytest.mark.long
def test_a_file_size_limit_is_an_error_of_the_folder(tmp_path: Path) -> None:
    """As under a quota: the system refuses to let a file grow, with a signal that Python turns into an error."""
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))"
    done = phichain("generate", "planar1", cwd=tmp_path, before=limit)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "file size limit" in done.stderr
    assert everything_under(tmp_path) == {}


@pytest.mark.long
@pytest.mark.parametrize(
    ("step", "existed"),
    [("os.fsync", False), ("os.rename", False), ("os.fsync", True), ("phichain.files._exchange", True)],
)
def test_a_generation_killed_half_way_leaves_the_folder_whole_or_absent(
    tmp_path: Path, step: str, existed: bool
) -> None:
    """Killed in the moment of writing; what it was writing on the side goes with the next generation."""
    target = tmp_path / "planar1"
    if existed:
        generate(standard_scene(1), tmp_path)
    before = everything_under(target)
    kill = f"import os, signal, phichain.files\n{step} = lambda *a, **k: os.kill(os.getpid(), signal.SIGKILL)"
    killed = phichain("generate", "planar1", "--out", tmp_path, cwd=tmp_path, before=kill)
    assert killed.returncode == -signal.SIGKILL
    assert everything_under(target) == before
    assert len(list(tmp_path.iterdir())) == 1 + existed

    generate(standard_scene(1), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["planar1"]
    assert {path.name for path in target.iterdir()} >= {"planar1.c", "planar1.h", "manifest.json"}


# --- compilers ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compiler", ["no-such-compiler", "false", "true"])
def test_a_compiler_that_is_missing_or_fails_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: str
) -> None:
    monkeypatch.setenv("CC", compiler)
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    (tmp_path / "scratch").mkdir()
    with pytest.raises(CompilerError) as caught:
        build(SCENE)
    assert "\n" not in str(caught.value) and caught.value.remedy
    left = [path for path in everything_under(tmp_path) if path.endswith((".c", ".so", ".o"))]
    # How the scene was proven is whole, and kept.
    assert not [path for path in left if not (tmp_path / path).read_bytes().startswith(b"{")]
    assert list((tmp_path / "scratch").iterdir()) == []


def test_a_compiler_that_hangs_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sleeper = tmp_path / "cc"
    sleeper.write_text("#!/bin/sh\nexec sleep 600\n")
    sleeper.chmod(0o755)
    monkeypatch.setenv("CC", str(sleeper))
    folder = write_folder(tmp_path / "duo", library_files(SCENE, lower(derive(SCENE))))
    with pytest.raises(CompilerError, match="still ran after 0.5 s"):
        build_folder(folder, CompilerOptions(timeout=0.5), Cache(tmp_path / "cache"))


# --- states that are no numbers ----------------------------------------------------------------------------------------


def every_function(space: str, base: str) -> Scene:
    functions = offered(space, on_request=True)
    return Scene(
        f"{space}_{base}", 2, space=space, base=base, mass=0.3, length=0.5, com=0.2 if base == "fixed" else None,
        cart_mass=1.0 if base == "cart" else None, want=[name for name in functions if name != "linearization"],
        code="loops" if (space, base) != ("planar", "fixed") else "unrolled",
    )  # fmt: skip


@pytest.fixture(
    scope="module",
    params=[("planar", "fixed"), ("planar", "cart"), ("spatial", "fixed"), ("spatial", "cart")],
    ids="-".join,
)
def system(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> System:
    scene, folder = every_function(*request.param), tmp_path_factory.mktemp("states")
    files = library_files(scene, lower(derive(scene)))
    options = CompilerOptions(flags=("-std=c99", "-O1", "-fPIC", "-shared"))
    return build_folder(write_folder(folder / scene.name, files), options, Cache(folder / "cache"))


def arguments(system: System, value: float) -> dict[str, list[np.ndarray | float]]:
    """Arguments of every function, the value in each entry of all of them."""
    chain = scene_from_dict(dict(system.scene))
    return {
        name: [
            np.full(argument.shape(chain), value) if argument.shape(chain) else value
            for argument in ROWS[name].arguments_of(chain)
            if argument.direction == "in"
        ]
        for name in chain.want
    }


@pytest.mark.long
def test_nan_in_is_nan_out(system: System) -> None:
    for name, given in arguments(system, np.nan).items():
        results = getattr(system, name)(*given)
        for result in results if isinstance(results, tuple) else [results]:
            assert np.isnan(result).any(), name


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e308, -1e300, 5e-324, 1e22])
def test_no_number_is_too_large_or_too_small_to_return(system: System, value: float) -> None:
    for name, given in arguments(system, value).items():
        results = getattr(system, name)(*given)
        for result in results if isinstance(results, tuple) else [results]:
            assert np.asarray(result).dtype == np.float64, name


def test_one_state_that_is_no_number_spoils_no_other(system: System) -> None:
    rng = np.random.default_rng(7)
    q, v = rng.normal(size=(2, 5, system.nq))
    u = [rng.normal(size=(5, system.nu))] if system.nu else []
    alone = system.forward_dynamics(q, v, *u)
    q[2, -1] = np.nan
    together = system.forward_dynamics(q, v, *u)
    assert np.isnan(together[2]).any()
    np.testing.assert_array_equal(np.delete(together, 2, axis=0), np.delete(alone, 2, axis=0))
