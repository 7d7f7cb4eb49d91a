"""Traps that a caller sets for underflow do not reach the program, and come back to the caller."""

from __future__ import annotations

import inspect
import pickle
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scene_text import TINY

import acoustics
import rolling
from acoustics import wav
from acoustics.traps import ignoring_underflow
from rolling.scene.file import loads

RATE = 48000
NUMBERS = np.random.default_rng(1).standard_normal(RATE // 2)
SQUARE = NUMBERS[:4096].reshape(64, 64)
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


Call = Callable[[Any], object]
# The doors of `acoustics`: each public function with a record.
SOUND_DOORS: dict[str, Call] = {
    "a_weighting_db": lambda record: acoustics.a_weighting_db(np.abs(record) + 20),
    "band_uncertainty_db": lambda record: acoustics.band_uncertainty_db(len(record) / RATE),
    "default_room_db": lambda record: acoustics.default_room_db(),
    "envelope_spectrum": lambda record: acoustics.envelope_spectrum(record, RATE, (500.0, 1000.0)),
    "in_room": lambda record: acoustics.in_room(record, reverberation_s=0.3),
    "intensity": lambda record: acoustics.intensity(np.abs(record), 1.0),
    "is_single_event": lambda record: acoustics.is_single_event(record, RATE),
    "kurtosis": lambda record: acoustics.kurtosis(record),
    "kurtosis_uncertainty": lambda record: acoustics.kurtosis_uncertainty(record),
    "lae_db": lambda record: acoustics.lae_db(record, RATE),
    "laeq_db": lambda record: acoustics.laeq_db(record, RATE),
    "level_db": lambda record: acoustics.level_db(1e-320),
    "level_uncertainty": lambda record: acoustics.level_uncertainty(
        record, RATE, acoustics.sound_levels(record, RATE), False, 1.0
    ),
    "line_spectrum": lambda record: acoustics.line_spectrum(record, RATE),
    "band_pulses": lambda record: acoustics.band_pulses(
        np.tile(record, 4), RATE, {"medium": (300.0, 1800.0)}
    ),
    "kurtogram": lambda record: acoustics.kurtogram(
        np.tile(record, 4), RATE, (300.0, 5000.0), 300.0
    ),
    "pulse_kurtogram": lambda record: acoustics.pulse_kurtogram(
        np.tile(record, 4), RATE, 5000.0, 50.0
    ),
    "velocity_of": lambda record: acoustics.velocity_of(record, RATE),
    "loudest_octave": lambda record: acoustics.loudest_octave(record, RATE),
    "modulated_octave": lambda record: acoustics.modulated_octave(record, RATE, 20.0),
    "narrow_spectrum": lambda record: acoustics.narrow_spectrum(np.tile(record, 4), RATE),
    "reliable": lambda record: acoustics.reliable(len(record) / RATE),
    "room_noise": lambda record: acoustics.room_noise(None, 0.1),
    "sound_levels": lambda record: acoustics.sound_levels(record, RATE),
    "sound_pressure": lambda record: acoustics.sound_pressure(np.abs(record)),
    "squared_envelope_spectrum": lambda record: acoustics.squared_envelope_spectrum(
        np.tile(record, 4), RATE
    ),
    "third_octave_mean_square": lambda record: acoustics.third_octave_mean_square(
        *acoustics.line_spectrum(record, RATE)
    ),
    "velocity_bands": lambda record: acoustics.velocity_bands(np.tile(record, 4), RATE),
    "vibration_levels": lambda record: acoustics.vibration_levels(record, RATE, "velocity"),
    "welch": lambda record: acoustics.welch(record, RATE),
    "wav.calibrated": lambda record: wav.calibrated(record, "faint"),
    "wav.listening": lambda record: wav.listening(record, wav.listening_gain(record), "faint"),
    "wav.listening_gain": lambda record: wav.listening_gain(record),
}


@pytest.mark.parametrize("kind", RECORDS)
def test_faint_records_are_no_faults(kind: str) -> None:
    for door in SOUND_DOORS.values():
        door(RECORDS[kind])
        assert np.geterr()["under"] == "raise"


def functions(package: Any, names: Iterable[str]) -> set[str]:
    """Return those names of a package or module that are functions."""
    return {name for name in names if inspect.isfunction(getattr(package, name))}


def test_every_public_function_of_sound_is_a_door() -> None:
    named = {name for name in SOUND_DOORS if "." not in name}
    assert {*named, "audible_difference"} == functions(acoustics, acoustics.__all__)
    assert pickle.loads(pickle.dumps(acoustics.laeq_db)) is acoustics.laeq_db


STEEL = rolling.HalfSpace(4e-6, 230e9)
GAP = 1e-9 * np.arange(64 * 64).reshape(64, 64)
CONTACT = rolling.RollingContact(
    heights=1e-200 * SQUARE,
    spacing=4e-6,
    radius=5e-3,
    contact_modulus=230e9,
    hardness=np.inf,
    load=0.5,
    step=4e-6,
    start=0.0,
    tolerance=1e-5,
)
SCENARIOS = Path(__file__).parents[2] / "scenarios"
# The doors of `rolling` that take milliseconds. The others need a run.
QUICK_DOORS: dict[str, Callable[[], object]] = {
    "HeightArray": lambda: rolling.HeightArray(1e-7 * SQUARE, spacing_um=1),
    "march": lambda: list(rolling.march(CONTACT, 0, 3, STEEL)),
    "read_scene": lambda: [
        rolling.read_scene(SCENARIOS / f"{name}.yaml") for name in ("bearing-6204", "quickstart")
    ],
    "solve_contact": lambda: rolling.solve_contact(STEEL, GAP, load=0.1),
    "surface_parameters": lambda: rolling.surface_parameters(1e-7 * SQUARE, 1e-6),
}
RUN_DOORS = {
    *("choose", "coarsest_below", "design", "live", "open_run", "save_run", "sensitivities"),
    "simulate",
    "simulate_sweep",
}
NO_NUMBERS = {"register"}  # takes a kind of scene, and computes nothing


def test_scenes_surfaces_and_contacts_meet_no_trap() -> None:
    for door in QUICK_DOORS.values():
        door()
        assert np.geterr()["under"] == "raise"


def test_every_public_function_of_rolling_is_a_door() -> None:
    """A function that needs a run has the shield itself; `simulate` shows that it works."""
    doors = functions(rolling, rolling.__all__) - NO_NUMBERS
    assert QUICK_DOORS.keys() | RUN_DOORS == doors
    for name in RUN_DOORS:
        assert hasattr(getattr(rolling, name), "__wrapped__"), name


def numbers_of(shown: object) -> None:
    """Ask an object for all its public properties."""
    for name in dir(type(shown)):
        member = inspect.getattr_static(type(shown), name)
        if name == "summary":  # warns of names of version 0.8
            continue
        if not name.startswith("_") and isinstance(member, property | cached_property):
            getattr(shown, name)


def test_the_numbers_and_figures_of_a_run_meet_no_trap() -> None:
    run = rolling.simulate(loads(TINY), workers=1, progress=False)
    numbers_of(run)
    numbers_of(run.sound)
    for name in ("third_octaves", "spectrum", "power_density", "contact_pressure", "surface"):
        figure = getattr(rolling.plot, name)(run).figure
        plt.close(figure)
    assert np.geterr() == {"divide": "raise", "over": "raise", "under": "raise", "invalid": "raise"}


@pytest.mark.slow
def test_a_difference_of_faint_records_is_no_fault() -> None:
    acoustics.audible_difference([RECORDS["faint"]], [RECORDS["mixed"]], RATE)


@pytest.mark.slow
def test_a_run_and_its_numbers_meet_no_trap(tmp_path: Path) -> None:
    run = rolling.simulate(loads(TINY), workers=1, progress=False)
    saved = run.save(tmp_path / "run")
    assert (saved / "report.html").is_file()
    assert rolling.open_run(saved).numbers.of_record.laeq_db == run.numbers.of_record.laeq_db
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
