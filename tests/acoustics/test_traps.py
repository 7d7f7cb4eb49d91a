"""Traps that a caller sets for underflow do not reach the program, and come back to the caller."""

from __future__ import annotations

import inspect
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_text import TINY

import acoustics
import rolling
from acoustics import wav
from acoustics.spectrum import spectrogram
from acoustics.traps import ignoring_underflow
from rolling.scene.file import loads

RATE = 48000
NUMBERS = np.random.default_rng(1).standard_normal(RATE // 2)
with np.errstate(under="ignore"):
    RECORDS = {
        "faint": 1e-160 * NUMBERS,
        "subnormal": 1e-310 * NUMBERS,
        "mixed": np.where(np.arange(len(NUMBERS)) % 2, 1e-170, NUMBERS),
    }


@pytest.fixture(autouse=True)
def trapped() -> Iterator[None]:
    with np.errstate(all="raise"):
        yield


@pytest.mark.parametrize("kind", RECORDS)
def test_faint_records_are_no_faults(kind: str) -> None:
    record = RECORDS[kind]
    levels = acoustics.sound_levels(record, RATE)
    acoustics.laeq_db(record, RATE)
    acoustics.welch(record, RATE)
    spectrogram(record, RATE)
    acoustics.third_octave_mean_square(*acoustics.line_spectrum(record, RATE))
    acoustics.level_uncertainty(record, RATE, levels, False, 1.0)
    acoustics.loudest_octave(record, RATE)
    acoustics.envelope_spectrum(record, RATE, (500.0, 1000.0))
    acoustics.sound_pressure(np.abs(record))
    assert wav.listening(record, wav.listening_gain(record), "faint").startswith(b"RIFF")
    assert np.geterr()["under"] == "raise"


@pytest.mark.slow
def test_a_run_and_its_numbers_meet_no_trap(tmp_path: Path) -> None:
    run = rolling.simulate(loads(TINY), workers=1, progress=False)
    saved = run.save(tmp_path / "run")
    assert (saved / "report.html").is_file()
    assert rolling.open_run(saved).numbers.played.laeq_db == run.numbers.played.laeq_db
    heights = 1e-7 * NUMBERS[:4096].reshape(64, 64)
    assert rolling.surface_parameters(heights, 1e-6)["Sq"] > 0
    assert np.geterr() == {"divide": "raise", "over": "raise", "under": "raise", "invalid": "raise"}


def test_a_thread_with_traps_of_its_own_meets_none() -> None:
    answers = list[Any]()

    def work() -> None:
        np.seterr(all="raise")
        answers.append(acoustics.laeq_db(RECORDS["faint"], RATE))
        answers.append(np.geterr()["under"])

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert len(answers) == 2 and answers[1] == "raise"


def test_a_march_leaves_the_traps_of_its_caller_between_its_states() -> None:
    """A generator that changed them would change them for the caller, too."""

    @ignoring_underflow
    def squares() -> Iterator[float]:
        for value in (1e-200, 1e-300):
            yield float(np.square(np.float64(value)))

    for value in squares():
        assert value == 0.0 and np.geterr()["under"] == "raise"
        with pytest.raises(FloatingPointError):
            np.square(np.float64(1e-200))


def test_every_public_function_ignores_underflow() -> None:
    """A public function that is called is at work when numpy's setting is the program's."""
    for package in (acoustics, rolling):
        for name in package.__all__:
            public = getattr(package, name)
            if inspect.isfunction(public):
                assert hasattr(public, "__wrapped__"), f"{package.__name__}.{name}"
    for module in (rolling.closed_forms, rolling.plot, acoustics.plots):
        for name in getattr(module, "__all__", ()):
            public = getattr(module, name)
            if inspect.isfunction(public):
                assert hasattr(public, "__wrapped__"), f"{module.__name__}.{name}"
