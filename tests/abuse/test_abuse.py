"""Every entry of the public API with every wrong kind of argument: a typed error, or the value of the clean call.

One row of `CASES` is one call. Nothing raw comes out, nothing that was handed over is changed, and afterwards the clean call gives
the same bits as before.
"""

from __future__ import annotations

import os
import pickle
import threading
import warnings
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from phichain.errors import PhichainError
from tests.abuse.abused import CALLS, Call, bits, systems
from tests.abuse.values import BAD, SAME

BY_NAME = {call.name: call for call in CALLS}


def cases(call: Call) -> Iterator[tuple[str, str, Any, bool]]:
    """Argument, name of the value, the value, and whether it must be refused."""
    for argument, kind in call.kinds.items():
        for name, make in BAD[kind].items():
            if (argument, name) not in call.fits:
                yield argument, name, make, True
        for name, make in SAME.get(kind, {}).items():
            yield argument, name, make, False


CASES = [(call.name, *case) for call in CALLS for case in cases(call)]


@pytest.fixture(scope="module")
def s() -> SimpleNamespace:
    return systems()


def run(call: Call, s: SimpleNamespace, **changed: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return bits(call.run(s, {**call.clean, **changed}))


def test_there_are_enough_of_them() -> None:
    assert len(CASES) >= 476 and len({(name, argument, value, bad) for name, argument, value, _, bad in CASES}) == len(CASES)


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name, call in BY_NAME.items() if call.clean != {"path": None}])
def test_a_typed_error_or_the_right_value(s: SimpleNamespace, name: str) -> None:
    call = BY_NAME[name]
    right, before = run(call, s), bits(tuple(call.clean.values()))
    wrong = []
    for argument, value, make, is_bad in cases(call):
        try:
            found = run(call, s, **{argument: make(call.clean[argument])})
        except PhichainError as refusal:
            if not is_bad:
                wrong.append(f"{argument} = {value}: refused, {refusal}")
            if not str(refusal).isprintable():
                wrong.append(f"{argument} = {value}: printed raw")
        except Exception as raw:  # noqa: BLE001
            wrong.append(f"{argument} = {value}: {type(raw).__name__}: {raw}")
        else:
            if is_bad or found != right:
                wrong.append(f"{argument} = {value}: {'taken' if is_bad else 'another value'}")
    assert not wrong, "\n".join(wrong)
    assert run(call, s) == right and bits(tuple(call.clean.values())) == before


def test_paths_that_lead_nowhere(s: SimpleNamespace) -> None:
    call = BY_NAME["Trajectory.from_npz"]
    for _, _, make, _ in cases(call):
        with pytest.raises(PhichainError):
            run(call, s, path=make(None))


SAFE = [name for name, call in BY_NAME.items() if name not in ("Trajectory.from_npz", "trace", "trace with options")]


def test_threads_give_the_bits_of_one(s: SimpleNamespace) -> None:
    right = {name: run(BY_NAME[name], s) for name in SAFE}
    found: list[dict[str, Any]] = []
    order = [SAFE[k:] + SAFE[:k] for k in (0, 5, 10, 15)]

    def work(names: list[str]) -> None:
        found.append({name: bits(BY_NAME[name].run(s, BY_NAME[name].clean)) for name in names})

    threads = [threading.Thread(target=work, args=(names,)) for names in order]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all(each == right for each in found)


def test_a_fork_and_a_pickle_give_the_same_bits(s: SimpleNamespace) -> None:
    right = {name: run(BY_NAME[name], s) for name in SAFE}
    child = os.fork()
    if child == 0:
        os._exit(0 if {name: run(BY_NAME[name], s) for name in SAFE} == right else 1)
    assert os.waitpid(child, 0)[1] == 0
    back = pickle.loads(pickle.dumps(s))
    assert {name: run(BY_NAME[name], back) for name in SAFE} == right
