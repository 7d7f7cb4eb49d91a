"""The processor time of a march counts neither waiting nor compilation; oracles are own clocks."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from itertools import count
from typing import Any

import pytest
from finished import VIBRATING, WITHOUT_DYNAMICS, run_of

from rolling.contact import compiling, processor_time
from rolling.contact.processor_time import ProcessorTime, counted_as_compilation
from rolling.marches import effort, march_piece
from rolling.marches.effort import ARRAY, PieceEffort
from rolling.marches.piece import Piece, contact_identity
from rolling.scene.file import loads

WAIT_S = 0.1
STEPS = 4


@pytest.fixture
def ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let each look at the clock take a second of processor time."""
    ticking = count()
    monkeypatch.setattr(processor_time.time, "thread_time", lambda: float(next(ticking)))


def test_kernels_that_compile_each_other_are_counted_once(ticks: None) -> None:
    before = ProcessorTime.now()
    with counted_as_compilation(), counted_as_compilation(), counted_as_compilation():
        pass
    with counted_as_compilation():
        pass
    spent = ProcessorTime.now().since(before)
    # The clock was read twice in each of two outermost contexts, and once at the end.
    # What the thread compiled before this test leaves rounding of its sum.
    assert spent == pytest.approx(ProcessorTime(work_s=3.0, compilation_s=2.0))


def test_compilation_of_another_thread_is_not_counted_here(ticks: None) -> None:
    def compile_something() -> None:
        with counted_as_compilation():
            pass

    before = ProcessorTime.now().compilation_s
    thread = threading.Thread(target=compile_something)
    thread.start()
    thread.join()
    assert ProcessorTime.now().compilation_s == before


def piece_of_steps() -> Piece:
    """Return a piece of a few steps."""
    scene = loads(VIBRATING, WITHOUT_DYNAMICS)
    return Piece(scene, contact_identity(scene), "track", 0, STEPS)


def test_a_march_that_waits_and_compiles_states_its_own_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each step waits, and one compiles a kernel, which takes far longer than all steps."""
    march_piece.march_piece(piece_of_steps())  # its kernels are loaded
    march = march_piece.march

    def slow_march(*arguments: Any) -> Iterator[Any]:
        for number, state in enumerate(march(*arguments)):
            time.sleep(WAIT_S)
            if number == 1:
                kernel = compiling.njit(cache=False)(lambda x: x**3 + 1.0 / (1.0 + x))
                kernel(2.0)
            yield state

    monkeypatch.setattr(march_piece, "march", slow_march)
    arrays = march_piece.march_piece(piece_of_steps())
    own = PieceEffort(*arrays[ARRAY].tolist())
    assert own.compilation_s > own.march_s > 0
    assert own.march_s < WAIT_S  # of more than STEPS times so long on the clock
    assert 0 < arrays["step_time"].sum() < WAIT_S
    assert own.surface_s < WAIT_S


def test_a_run_states_the_time_of_each_part() -> None:
    run = run_of(loads(VIBRATING))
    parts = run.numbers.effort.parts_cpu_s
    assert parts.keys() == {*effort.OF_SPHERE, effort.SOUND, effort.PAGE}
    assert run.numbers.effort.march_cpu_s == parts["march"] > 0
    assert parts["load_marches"] > 0 and parts["sound"] > 0 and parts["page"] is None
    steps = float(run.result.series["step_time"].sum())
    assert 0 < steps <= parts["march"]
