"""Values that no argument of their kind may have, and other spellings of the right one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


class Stubborn:
    """An object that fails at whatever is asked of it."""

    def __array__(self, *_: Any, **__: Any) -> np.ndarray:
        raise RuntimeError("no array")

    def __float__(self) -> float:
        raise RuntimeError("no number")

    def __index__(self) -> int:
        raise TypeError("no whole number")

    def __len__(self) -> int:
        raise RuntimeError("no length")

    def __iter__(self) -> Any:
        raise TypeError("no items")

    def __repr__(self) -> str:
        raise RuntimeError("no text")


class Given:
    """An array in the wrapping of another library."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return self.array if dtype is None else self.array.astype(dtype)


Make = Callable[[Any], Any]

_NO_NUMBERS: dict[str, Make] = {
    "nothing": lambda x: None,
    "text": lambda x: "abc\x1b[31m",
    "number as text": lambda x: "0.5",
    "bytes": lambda x: b"\x00\x01",
    "mapping": lambda x: {"a": 1.0},
    "object": lambda x: object(),
    "stubborn object": lambda x: Stubborn(),
    "complex": lambda x: np.asarray(x, dtype=float) + 0j,
    "function": lambda x: abs,
}
_NO_ARRAYS: dict[str, Make] = {
    **_NO_NUMBERS,
    "texts": lambda x: np.asarray(x).astype(str),
    "objects": lambda x: np.asarray(x).astype(object),
    "dates": lambda x: np.asarray(x).astype("M8[s]"),
    "ragged": lambda x: [[1.0], [1.0, 2.0]],
    "structured": lambda x: np.zeros(np.shape(x), [("a", float)]),
}
_SHAPES: dict[str, Make] = {
    "one number": lambda x: 0.5,
    "longer": lambda x: np.concatenate([x, x, x]),
    "more dimensions": lambda x: np.asarray(x)[None, None],
    "empty list": lambda x: [],
}
_NOT_FINITE: dict[str, Make] = {
    "not a number": lambda x: np.full(np.shape(x), np.nan),
    "infinite": lambda x: np.full(np.shape(x), np.inf),
}
_VECTOR = {**_NO_ARRAYS, **_SHAPES}
_WHOLE = {**_NO_NUMBERS, "half": lambda x: 1.5, "not a number": lambda x: float("nan"), "infinite": lambda x: float("inf"),
          "list": lambda x: [1, 2], "negative": lambda x: -2, "huge": lambda x: 2**64, "huge float": lambda x: 1e300}  # fmt: skip
_NUMBER = {**_NO_NUMBERS, "list": lambda x: [1.0, 2.0], "not a number": lambda x: float("nan"), "infinite": lambda x: float("inf"),
           "minus infinity": lambda x: -np.inf, "huge": lambda x: 10**400, "empty list": lambda x: []}  # fmt: skip

BAD: dict[str, dict[str, Make]] = {
    "vector": _VECTOR,
    "rows": {**_NO_ARRAYS, "longer": lambda x: np.concatenate([x, x]), "wider": lambda x: np.concatenate([x, x], axis=1),
             "more dimensions": lambda x: np.asarray(x)[None, None]},
    "finite": {**_VECTOR, **_NOT_FINITE},
    "finite rows": {**_VECTOR, **_NOT_FINITE},
    "finite wide": {**_VECTOR, **_NOT_FINITE},
    "finite loose": {**_NO_ARRAYS, **_NOT_FINITE},
    "loose": _NO_ARRAYS,
    "times": {**_NO_ARRAYS, **_NOT_FINITE, "outside": lambda x: [9.0], "unsorted": lambda x: [0.2, 0.1], "table": lambda x: [[0.1]]},
    "size": {**_NO_NUMBERS, "table": lambda x: [[[1.0]]]},
    "number": _NUMBER,
    "positive": {**_NUMBER, "zero": lambda x: 0.0, "negative": lambda x: -1.0},
    "budget": _WHOLE,
    "budget from 1": {**_WHOLE, "zero": lambda x: 0},
    "count": {**_WHOLE, "zero": lambda x: 0, "one": lambda x: 1},
    "mode": {**_WHOLE, "zero": lambda x: 0, "beyond": lambda x: 9},
    "links": {**_WHOLE, "zero": lambda x: 0, "beyond": lambda x: 5000, "truth": lambda x: True},
    "direction": {**_WHOLE, "beyond": lambda x: 2},
    "word": {**{name: make for name, make in _NO_NUMBERS.items() if name not in ("nothing", "complex")}, "list": lambda x: [x], "number": lambda x: 7},
    "record": {"number": lambda x: 5, "stubborn object": lambda x: Stubborn(), "object": lambda x: object(), "complex": lambda x: 1j,
               "nothing": lambda x: None, "empty list": lambda x: [], "empty text": lambda x: "", "empty mapping": lambda x: {}},
    "path": {"number": lambda x: 5.0, "object": lambda x: object(), "nothing": lambda x: None, "zero byte": lambda x: "a\0b",
             "folder": lambda x: "/", "device": lambda x: "/dev/null", "absent": lambda x: "/absent/file.npz", "long": lambda x: "a" * 5000},
    "signs": {**{k: m for k, m in _NO_ARRAYS.items() if k not in ("nothing",)}, "longer": lambda x: (*x, 1), "zero": lambda x: (0, 0),
              "not a number": lambda x: (np.nan, 1), "nothing": lambda x: None, "empty list": lambda x: []},
    "weight": {**{k: m for k, m in _VECTOR.items() if k != "one number"}, **_NOT_FINITE, "negative": lambda x: -np.asarray(x),
               "zero": lambda x: 0.0, "huge": lambda x: 1e300, "lopsided": lambda x: np.triu(np.ones((len(x), len(x))))},
    "scene numbers": {**{k: m for k, m in _NO_ARRAYS.items() if k != "objects"}, "longer": lambda x: np.concatenate([x, x]), **_NOT_FINITE, "negative": lambda x: -np.asarray(x),
                      "huge": lambda x: 10**400, "table": lambda x: [[1.0], [2.0]], "empty list": lambda x: []},
    "square": {**_NO_ARRAYS, **_NOT_FINITE, "one number": lambda x: 1.0, "row": lambda x: [1.0, 2.0], "empty list": lambda x: [],
               "wide": lambda x: np.ones((2, 3)), "singular": lambda x: [[0.0, 1.0], [0.0, 0.0]]},
    "exponent": {**{k: m for k, m in _NO_NUMBERS.items() if k != "complex"}, "not a number": lambda x: np.nan, "infinite": lambda x: np.inf},
    "parameters": {
        "number": lambda p: 3.0, "list": lambda p: [1.0, 2.0], "text": lambda p: "mass", "object": lambda p: object(),
        "stubborn object": lambda p: Stubborn(), "unknown": lambda p: {**p, "masses": 1.0}, "no names": lambda p: {1: 2.0},
        "negative": lambda p: {"mass": -p["mass"]}, "zero": lambda p: {"mass": 0 * p["mass"]}, "short": lambda p: {"mass": [1.0]},
        "not a number": lambda p: {"mass": np.nan * p["mass"]}, "infinite": lambda p: {"mass": np.inf * p["mass"]},
        "complex": lambda p: {"mass": p["mass"] + 0j}, "texts": lambda p: {"mass": ["1", "2"]}, "none inside": lambda p: {"mass": None},
    },
}  # fmt: skip


def strided(x: Any) -> np.ndarray:
    """A view of every second entry."""
    array = np.asarray(x)
    wide = np.zeros((*array.shape[:-1], 2 * array.shape[-1]))
    wide[..., ::2] = array
    return wide[..., ::2]


def read_only(x: Any) -> np.ndarray:
    """A copy that nobody may write to."""
    array = np.array(x)
    array.flags.writeable = False
    return array


def unaligned(x: Any) -> np.ndarray:
    """The numbers at an odd address."""
    array = np.asarray(x, dtype=float)
    room = np.zeros(array.nbytes + 1, np.uint8)[1:]
    view = room.view(float).reshape(array.shape) if room.ctypes.data % 8 == 0 else np.frombuffer(room, float).reshape(array.shape)
    view[...] = array
    return view


_LAYOUTS: dict[str, Make] = {
    "list": lambda x: np.asarray(x).tolist(),
    "Fortran's order": np.asfortranarray,
    "strided": strided,
    "backwards": lambda x: np.array(np.asarray(x)[::-1])[::-1],
    "read-only": read_only,
    "unaligned": unaligned,
    "big-endian": lambda x: np.asarray(x).astype(">f8"),
    "single precision": lambda x: np.asarray(x).astype(np.float32),
    "wrapped": lambda x: Given(np.asarray(x)),
    "subclass": lambda x: np.ma.array(x) if np.ndim(x) == 1 else np.asarray(x),
}
_SCALARS: dict[str, Make] = {
    "NumPy's": np.float64,
    "array": lambda x: np.array(float(x)),
    "big-endian": lambda x: np.array(float(x), ">f8"),
}
_COUNTS: dict[str, Make] = {"NumPy's": np.int64, "small": np.int16, "float": float}
_ARRAYS = ("vector", "rows", "finite", "finite rows", "finite wide", "finite loose", "loose", "times", "square")

SAME: dict[str, dict[str, Make]] = {
    **{kind: _LAYOUTS for kind in _ARRAYS},
    **{kind: _SCALARS for kind in ("number", "positive", "size")},
    **{kind: _COUNTS for kind in ("budget", "budget from 1", "count", "mode", "direction")},
    "signs": {"list": list, "array": np.array, "floats": lambda x: [float(k) for k in x]},
    "parameters": {"lists": lambda p: {k: v.tolist() for k, v in p.items()}, "read-only": lambda p: {k: read_only(v) for k, v in p.items()}},
}
