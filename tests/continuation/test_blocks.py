"""Points of a block: each is what its block says of it, whenever and by whomever it is asked, copied or not."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, replace
from threading import Barrier, Thread
from typing import Any

import numpy as np
import pytest

from phichain.continuation.compiled.block import BlockPoint, Columns
from phichain.continuation.point import Point

FIELDS = {field.name for field in fields(Point)}


class Counted:
    """Points whose fields tell where they are; how often they were asked."""

    def __init__(self) -> None:
        self.asked = 0

    def fields(self, place: int) -> dict[str, Any]:
        self.asked += 1
        told: dict[str, Any] = {**dict.fromkeys(FIELDS, place), "y": np.array([place, 1.0]), "arclength": 0.5 * place}
        return told

    def column(self, name: str) -> np.ndarray | None:
        return 0.5 * np.arange(4.0) if name == "arclength" else None


def test_a_point_is_asked_once_and_its_copies_say_the_same() -> None:
    block = Counted()
    point = BlockPoint.of(block, 3)
    others = [pickle.loads(pickle.dumps(point)), copy.copy(point), copy.deepcopy(point)]
    assert block.asked == 0
    assert [one.arclength for one in [point, *others]] == [1.5] * 4 and replace(point, energy=7.0).iterations == 3
    before = block.asked
    assert point.sigma == 3 and block.asked == before
    with pytest.raises(AttributeError):
        _ = point.nothing


def test_a_point_that_was_interrupted_can_be_asked_again() -> None:
    class Interrupted(Counted):
        def fields(self, place: int) -> dict[str, Any]:
            told = super().fields(place)
            if self.asked == 1:
                raise KeyboardInterrupt
            return told

    point = BlockPoint.of(Interrupted(), 2)
    with pytest.raises(KeyboardInterrupt):
        _ = point.arclength
    assert point.arclength == 1.0


def test_threads_ask_a_point_at_once() -> None:
    together = Barrier(2)

    class Slow(Counted):
        def fields(self, place: int) -> dict[str, Any]:
            told = super().fields(place)
            if self.asked <= 2:
                together.wait(10)
            return told

    point, said = BlockPoint.of(Slow(), 2), list[float]()
    threads = [Thread(target=lambda: said.append(point.arclength)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert said == [1.0, 1.0]


def test_columns_are_those_of_points_one_by_one() -> None:
    block, other = Counted(), Counted()
    points = [*(BlockPoint.of(block, k) for k in (1, 2)), BlockPoint.of(other, 3), BlockPoint.of(block, 3), BlockPoint.of(block, 0)]
    _ = points[1].energy
    columns = Columns(points)
    assert columns.of("arclength", lambda point: -1.0).tolist() == [0.5, -1.0, 1.5, 1.5, 0.0]
    assert columns.of("y", lambda point: point.y).tolist() == [[k, 1.0] for k in (1, 2, 3, 3, 0)]
