"""The store of a study: one Zarr group, a row a task, found by the key of what was computed.

Rows are only ever added. A batch writes its results first and their status last, each chunk by one rename, so that whatever
ends a run leaves rows that are done and rows that are pending. Every chunk carries a checksum.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain._version import __version__
from phichain.errors import OutputError, StudyError
from phichain.studies.plan import Plan
from phichain.studies.point import KEY_SIZE
from phichain.studies.task import DONE, FAILED, PENDING, STATUS, Failure, Output, Row

if TYPE_CHECKING:
    import zarr

FORMAT: Final = "phichain study 1"
ABOUT: Final = "phichain"
"""The attribute that says what a store holds."""


class Store:
    """Results by key, open for one writer."""

    def __init__(self, path: Path, group: zarr.Group, outputs: Mapping[str, Output]) -> None:
        """Take an open group; `opened` makes one."""
        self.path, self.group, self.outputs = path, group, outputs
        keys: np.ndarray = np.asarray(self._read("key"))
        self.rows = {key.tobytes(): row for row, key in enumerate(keys)}
        self.status: np.ndarray = np.asarray(self._read("status"))[: len(keys)].copy()

    @classmethod
    def opened(cls, path: Path, plan: Plan) -> Store:
        """The store of a study, made when missing; one of an earlier extent is added to.

        Raises:
            StudyError: The folder holds another study, or no study.
            OutputError: It cannot be written.
        """
        import zarr

        try:
            if not path.exists():
                group = zarr.create_group(path, zarr_format=3)
                _create(group, plan)
            group = zarr.open_group(path, mode="r+")
        except PermissionError as error:
            raise OutputError("out", str(path), f"cannot be written, {error.strerror}", "name a folder of your own") from error
        except Exception as error:
            raise StudyError("out", str(path), "holds no study that can be read", "name another folder, or remove that one") from error
        demand_same(path, group.attrs.asdict().get(ABOUT), plan)
        store = cls(path, group, plan.outputs)
        store._fit(plan)
        return store

    def register(self, keys: np.ndarray, values: Sequence[tuple[Any, ...]], names: Sequence[str]) -> np.ndarray:
        """Rows of tasks by their keys; unknown ones are added at the end, pending.

        Args:
            keys: (n, 32).
            values: The values of the axes of every task.
            names: The axes.

        Returns:
            Rows (n,).
        """
        raw = [key.tobytes() for key in keys]
        new: dict[bytes, int] = {}
        for place, key in enumerate(raw):
            if key not in self.rows and key not in new:
                new[key] = place
        first, total = len(self.rows), len(self.rows) + len(new)
        if new:
            places = list(new.values())
            for array in self._by_task():
                if array.path != "key":
                    array.resize((total, *array.shape[1:]))
            for k, name in enumerate(names):
                array = self._array(_column(name))
                array[first:total] = np.array([values[place][k] for place in places], dtype=object if array.dtype.kind not in "fiub" else array.dtype)
            # Keys come last: a row exists once it has one.
            self._array("key").resize((total, KEY_SIZE))
            self._array("key")[first:total] = keys[places]
            self.rows |= {key: first + k for k, key in enumerate(new)}
            self.status = np.concatenate([self.status, np.full(len(new), PENDING, np.uint8)])
        return np.array([self.rows[key] for key in raw], dtype=np.int64)

    def write(self, rows: np.ndarray, results: Sequence[Row | Failure]) -> None:
        """Put the results of some rows in place.

        Raises:
            OutputError: The disk is full, or the folder is gone.
        """
        good = [isinstance(result, dict) for result in results]
        kept = rows[good]
        done = [result for result in results if isinstance(result, dict)]
        status = np.where(good, DONE, FAILED).astype(np.uint8)
        failures = np.array(["" if isinstance(result, dict) else result.text for result in results], dtype=object)
        try:
            for name, output in self.outputs.items():
                if done:
                    _put(self._array(name), kept, _stacked([row[name] for row in done], output))
            if not all(good) or np.any(self.status[rows] == FAILED):
                _put(self._array("failure"), rows, failures)
            _put(self._array("status"), rows, status)
        except OSError as error:
            raise OutputError("out", str(self.path), f"cannot be written, {error.strerror or error}", "free some space; what was computed before is kept") from error
        self.status[rows] = status

    def mend(self, rows: np.ndarray) -> int:
        """Make rows pending again whose chunks cannot be read; returns how many.

        Every chunk of every result is read once; damage is told by its checksum.
        """
        broken = np.zeros(len(self.status), bool)
        for name in self.outputs:
            array = self._array(name)
            size = array.chunks[0]
            for first in range(0, array.shape[0], size):
                try:
                    array[first : first + size]
                except Exception:  # noqa: BLE001 - whatever a damaged chunk makes of the codecs
                    broken[first : first + size] = True
                    _remove(array, first // size)
        broken &= self.status == DONE
        if broken.any():
            lost = np.flatnonzero(broken)
            warnings.warn(f"{self.path} held {len(lost)} results that cannot be read; they are computed again", StudyWarning, 3)
            _put(self._array("status"), lost, np.full(len(lost), PENDING, np.uint8))
            self.status[lost] = PENDING
        return int(np.sum(broken[rows]))

    def say(self, plan: Plan) -> None:
        """Record which study the store now serves."""
        self.group.attrs[ABOUT] = about(plan)

    def failures(self, rows: np.ndarray) -> dict[int, str]:
        """Why tasks failed, by the place of their row in `rows`."""
        failed = np.flatnonzero(self.status[rows] == FAILED)
        if not len(failed):
            return {}
        texts = self._array("failure")[:]
        return {int(k): str(texts[rows[k]]) for k in failed}

    def _by_task(self) -> list[Any]:
        """Every array: all have a row a task."""
        return [array for _, array in self.group.arrays()]

    def _array(self, name: str) -> Any:
        return self.group[name]

    def _read(self, name: str) -> Any:
        try:
            return self._array(name)[:]
        except Exception as error:
            raise StudyError("out", str(self.path), f"has a chunk of '{name}' that cannot be read", "restore the store, or begin another one") from error

    def _fit(self, plan: Plan) -> None:
        """Make room for axes, outputs and chains that the store has not met; rows that a broken run left half made go."""
        rows = len(self.rows)
        for name, output in plan.outputs.items():
            array = self._array(name)
            rest = tuple(max(size, old) for size, old in zip(output.dims.values(), array.shape[1:], strict=True))
            if array.shape != (rows, *rest):
                array.resize((rows, *rest))
        for axis in (*plan.grid, *plan.samples):
            if _column(axis.key) not in self.group:
                _column_array(self.group, axis.key, axis.is_number, rows, plan.task.chunk)
        for array in self._by_task():
            if array.shape[0] != rows:
                array.resize((rows, *array.shape[1:]))


class StudyWarning(UserWarning):
    """A store held what cannot be read."""


def about(plan: Plan) -> dict[str, Any]:
    """What a store says of itself."""
    return {
        "format": FORMAT, "version": __version__, "study": plan.name, "task": plan.task.name, "scene": plan.base.scene.name,
        "digest": plan.base.scene.digest, "plan": _plain(plan.document),
    }  # fmt: skip


def demand_same(path: Path, said: Any, plan: Plan) -> None:
    """Refuse a store that holds another study.

    Raises:
        StudyError: It does, or none.
    """
    if not isinstance(said, Mapping) or said.get("format") != FORMAT:
        raise StudyError("out", str(path), "holds no study", "name another folder")
    for key, mine in (("study", plan.name), ("task", plan.task.name), ("scene", plan.base.scene.name)):
        if said.get(key) != mine:
            raise StudyError("out", str(path), f"holds another study, whose {key} is {said.get(key)!r} and not {mine!r}", "name another folder")


def _column(name: str) -> str:
    """An axis as an array's name: brackets and dots are kept, slashes do not occur."""
    return f"at {name}"


def _create(group: Any, plan: Plan) -> None:
    group.attrs[ABOUT] = about(plan)
    chunk = plan.task.chunk
    _array_of(group, "key", (0, KEY_SIZE), (chunk, KEY_SIZE), np.dtype(np.uint8), 0, ("task", "byte"), {})
    codes = {"flag_values": list(range(len(STATUS))), "flag_meanings": " ".join(STATUS)}
    _array_of(group, "status", (0,), (chunk,), np.dtype(np.uint8), PENDING, ("task",), codes)
    group.create_array("failure", shape=(0,), chunks=(chunk,), dtype=str, fill_value="", dimension_names=("task",))
    for name, output in plan.outputs.items():
        said: dict[str, Any] = {"long_name": output.text} | ({"units": output.units} if output.units else {})
        if output.meanings:
            said |= {"flag_values": list(range(len(output.meanings))), "flag_meanings": " ".join(m.replace(" ", "_") for m in output.meanings)}
        sizes = tuple(output.dims.values())
        empty = 255 if output.meanings else np.nan
        _array_of(group, name, (0, *sizes), (chunk, *(max(1, size) for size in sizes)), output.dtype, empty, ("task", *output.dims), said)


def _array_of(group: Any, name: str, shape: Any, chunks: Any, dtype: Any, fill: Any, dims: Any, said: dict[str, Any]) -> None:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    group.create_array(
        name, shape=shape, chunks=chunks, dtype=dtype, fill_value=fill, dimension_names=dims, attributes=said,
        compressors=(ZstdCodec(level=1), Crc32cCodec()),
    )  # fmt: skip


def _column_array(group: Any, key: str, is_number: bool, rows: int, chunk: int) -> None:
    if is_number:
        _array_of(group, _column(key), (rows,), (chunk,), np.dtype(float), np.nan, ("task",), {"long_name": key})
    else:
        group.create_array(_column(key), shape=(rows,), chunks=(chunk,), dtype=str, fill_value="", dimension_names=("task",))


def _stacked(values: Sequence[Any], output: Output) -> np.ndarray:
    """The values of some rows, each padded to the room that its output has."""
    sizes = tuple(output.dims.values())
    arrays = [np.asarray(value, dtype=output.dtype) for value in values]
    if all(array.shape == sizes for array in arrays):
        return np.array(arrays, dtype=output.dtype)
    stacked = np.full((len(arrays), *sizes), np.nan)
    for place, array in zip(stacked, arrays, strict=True):
        place[tuple(slice(0, size) for size in array.shape)] = array
    return stacked


def _put(array: Any, rows: np.ndarray, values: np.ndarray) -> None:
    """Write rows, in one piece where they follow one another."""
    if values.ndim > 1 and values.shape[1:] != array.shape[1:]:
        wide = np.full((len(values), *array.shape[1:]), np.nan)
        wide[(slice(None), *(slice(0, size) for size in values.shape[1:]))] = values
        values = wide
    if len(rows) and rows[-1] - rows[0] == len(rows) - 1 and np.all(np.diff(rows) == 1):
        array[int(rows[0]) : int(rows[-1]) + 1] = values
    else:
        array.oindex[rows] = values


def _remove(array: Any, chunk: int) -> None:
    """Remove the chunks of one range of rows, so that they can be written again."""
    root = Path(array.store_path.store.root) / array.path / "c" / str(chunk)
    if root.is_dir():
        for path in sorted(root.rglob("*"), reverse=True):
            path.unlink() if path.is_file() else path.rmdir()
    else:
        root.unlink(missing_ok=True)


def _plain(value: Any) -> Any:
    """Tables as JSON holds them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.item() if hasattr(value, "item") else value
