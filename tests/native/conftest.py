"""A cache of its own for every test of building, and one compiled system that most of them share."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from phichain.native import Cache, build_folder
from phichain.system import System
from tests.native import generated_folder


@pytest.fixture
def cache(tmp_path: Path) -> Cache:
    return Cache(tmp_path / "cache")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return generated_folder.write(tmp_path)


@pytest.fixture(scope="session")
def shared_cache(tmp_path_factory: pytest.TempPathFactory) -> Cache:
    return Cache(tmp_path_factory.mktemp("shared") / "cache")


@pytest.fixture(scope="session")
def system(tmp_path_factory: pytest.TempPathFactory, shared_cache: Cache) -> System:
    return build_folder(generated_folder.write(tmp_path_factory.mktemp("double")), cache=shared_cache)


@pytest.fixture(scope="session")
def float_system(tmp_path_factory: pytest.TempPathFactory, shared_cache: Cache) -> System:
    return build_folder(generated_folder.write(tmp_path_factory.mktemp("float"), "float"), cache=shared_cache)


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 KiB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k,mode=700", "tmpfs", str(disk)]
    try:
        mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    except OSError:
        mounted = False
    if not mounted:
        pytest.skip("a small disk can only be mounted by root")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)
