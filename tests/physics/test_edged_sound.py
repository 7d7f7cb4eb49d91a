"""Records of plates with edges: closed, open and moving contacts, listeners, and scenes of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from finished import VIBRATING, doubt_lines, heard_again, marched

from acoustics import wav
from acoustics.arrays import Array
from rolling.in_si.physics_of_scene import bodies_of, listener_of, plate_of
from rolling.results.level_words import number_rows
from rolling.results.listening import ListenSound
from rolling.results.run_lines import other_listeners
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.sound import edged_sound, vibration_sound

EDGES = ("plate.length_mm=200", "plate.width_mm=150", "plate.thickness_mm=2")


def heard(force: Array, closed: bool, *changes: str) -> Array:
    """Return the pressures of a force at the listeners of a scene."""
    scene = loads(VIBRATING, (*EDGES, *changes))
    return edged_sound.pressures(bodies_of(scene), listener_of(scene), scene.motion, force, closed)


def pulses(samples: int, *at_s: float) -> Array:
    """Return a force of bursts of 2 ms at 3 kHz, each about a time [s]."""
    t = np.arange(samples) / wav.SAMPLE_RATE_HZ
    bursts = [np.exp(-np.square((t - at) / 4e-4)) * np.cos(6000 * np.pi * (t - at)) for at in at_s]
    return np.asarray(np.sum(bursts, axis=0))


def test_a_closed_record_is_what_an_open_one_of_many_laps_tends_to() -> None:
    """With a loss factor of 0.1 modes forget a lap of 50 ms: 1e-3 of the maximum."""
    lap = pulses(2400, 0.02)
    closed = heard(lap, True, "plate.loss_factor=0.1")[0]
    opened = heard(np.tile(lap, 8), False, "plate.loss_factor=0.1")[0]
    difference = opened[6 * 2400 : 7 * 2400] - closed
    assert np.abs(difference).max() < 1e-3 * np.abs(closed).max()


@pytest.mark.parametrize("loss_factor", [1e-4, 0.05])
def test_the_ringing_of_an_open_record_does_not_wrap_round(loss_factor: float) -> None:
    """A plate that rings for a minute is silent before the pulse, within -60 dB."""
    pressure = heard(pulses(24_000, 0.3), False, f"plate.loss_factor={loss_factor}")[0]
    assert np.abs(pressure[:13_000]).max() < 1e-3 * np.abs(pressure).max()


@pytest.mark.law("Sound of a plate with edges: a moving contact is a fixed one during a pulse.")
def test_a_moving_contact_is_a_fixed_one_during_a_pulse() -> None:
    """Pulses at three points of a path at 0.3 m/s: each lasts 0.5 mm, so 2 % are left."""
    path = ("plate.contact_mm=[30, 40]", "plate.contact_path=to-and-fro")
    path += ("plate.contact_end_mm=[50, 60]",)
    times = (0.03, 0.11, 0.17)
    samples = 12_000
    moving = heard(pulses(samples, *times), False, *path, "sound.listener_mm=[90, 20, 400]")[0]
    scene = loads(VIBRATING, (*EDGES, *path))
    points = 1e3 * plate_of(scene.plate).contact_points(scene.motion.distance(times))
    fixed = np.zeros(samples)
    first = np.hypot(np.hypot(60, 20), 400)  # the distance whose delay the moving record leaves out
    for at, (x, y) in zip(times, points, strict=True):
        place = f"plate.contact_mm=[{x}, {y}]"
        record = heard(pulses(samples, at), False, place, "sound.listener_mm=[90, 20, 400]")[0]
        later = (np.hypot(np.hypot(x - 90, y - 20), 400) - first) * 1e-3 / 343.2
        lines = np.fft.rfft(record) * np.exp(
            -2j * np.pi * later * np.fft.rfftfreq(samples, 1 / wav.SAMPLE_RATE_HZ)
        )
        fixed += np.fft.irfft(lines, samples)
    error = np.sqrt(np.mean(np.square(moving - fixed)) / np.mean(np.square(fixed)))
    assert error < 0.02


def test_stretches_and_stations_of_a_long_record_change_little(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Modes that fade within 20 ms, from all 12 stations in the shortest wave: 3 % at 3 kHz."""
    path = ("plate.contact_mm=[30, 40]", "plate.contact_path=to-and-fro")
    path += ("plate.contact_end_mm=[150, 110]", "plate.loss_factor=0.1", "rolling.speed_m_s=0.5")
    record = pulses(24_000, *np.linspace(0.03, 0.47, 30))
    whole = heard(record, False, *path)[0]
    monkeypatch.setattr(edged_sound, "_STRETCH_S", 0.02)
    parts = heard(record, False, *path)[0]
    assert 0 < np.abs(parts - whole).max() < 0.03 * np.abs(whole).max()


def test_a_louder_force_is_louder_and_silence_is_silent() -> None:
    force = pulses(2400, 0.02)
    one, two = (heard(gain * force, False)[0] for gain in (1.0, 2.0))
    assert np.allclose(two, 2 * one, rtol=1e-9, atol=1e-15)
    assert not heard(np.zeros(2400), False).any()


@pytest.fixture(scope="module")
def run() -> Run:
    places = "[[86, 55, 300], [140, 55, 300], [86, 55, -300]]"
    return marched(VIBRATING, (*EDGES, f"sound.listener_mm={places}"))


def test_listeners_in_numbers_words_and_files(run: Run, tmp_path: Path) -> None:
    """The first listener has the main levels, and the first two are the channels of the WAVs."""
    numbers = run.numbers
    assert [list(x.at_mm) for x in numbers.levels.listeners] == [
        [86, 55, 300],
        [140, 55, 300],
        [86, 55, -300],
    ]
    assert numbers.levels.listeners[0].laeq_db == numbers.of_record.laeq_db
    assert numbers.levels.compact_source_level_db is None
    assert numbers.levels.hemisphere_mean_level_db is not None
    others = "; ".join(other_listeners(numbers))
    assert "at [140, 55, 300] mm" in others and "at [86, 55, 300]" not in others
    assert any("half sphere" in row.head for row in number_rows([numbers]))
    assert {"at_listener", "plate_edges"} <= doubt_lines(run).keys()
    samples, _, comment = wav.read(_written(tmp_path / "listen.wav", ListenSound(run).wav()))
    assert samples.shape[1] == 2 and "left and right" in comment
    record = (
        np.stack(run.vibration_sound.pressures[:2], axis=1) if run.vibration_sound else np.zeros(1)
    )
    stored = run.to_xarray()["sound"]
    assert np.array_equal(stored["pressure"], record[:, 0])
    assert np.array_equal(stored["pressure_right"], record[:, 1])
    assert np.allclose(
        wav.read(_written(tmp_path / "s.wav", wav.calibrated(record, "")))[0], record
    )


def _written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def test_another_listener_over_the_same_marches(run: Run) -> None:
    """Twice as far is 6 dB quieter in the far field; a default listener is above the contact."""
    heard = [
        heard_again(run, run.scene.with_({"sound.listener_mm": [86, 55, z]}))
        for z in (20_000, 40_000)
    ]
    levels = [again.numbers.of_record.laeq_db for again in heard]
    assert levels[0] - levels[1] == pytest.approx(6.02, abs=0.05)
    above = run.scene.with_({"sound.listener_mm": None, "sound.distance_m": 0.3})
    assert above.listeners == [(pytest.approx(0.086), pytest.approx(0.0555), 0.3)]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("[1, 2]", "three numbers in mm"),
        ("[1, 2, 0]", "z above 0"),
        (f"{[[1, 2, 3]] * 17}", "17 places"),
        ("[86, 55.5, 6]", "inside the sphere"),
        ("[[1, 2, 3], [1, 2]]", "three numbers in mm"),
    ],
)
def test_refused_listeners(change: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        loads(VIBRATING, (*EDGES, f"sound.listener_mm={change}"))
    with pytest.raises(SceneError, match="listener_mm"):
        loads(VIBRATING, (f"sound.listener_mm={change}",))


def test_an_early_impact_sounds_like_a_late_one() -> None:
    """A fall that begins with an impact of 0.1 ms after 2 ms, or with one 50 ms later: 1e-4.

    A fade at the beginning leaves 73 %, and the step of a force without its mean 1 %.
    """
    scene = loads(VIBRATING, (*EDGES, "plate.loss_factor=0.1", "rolling.drop_mm=0.02"))
    early, late = np.zeros((2, 9600))
    impact = np.sin(np.pi * np.arange(5) / 5)
    early[96:101] = late[2496:2501] = impact
    first, second = (
        vibration_sound.radiated(
            bodies_of(scene), listener_of(scene), scene.motion, force, wav.SAMPLE_RATE_HZ, False
        )[1][0]
        for force in (early, late)
    )
    error = second[2400:7200] - first[:4800]
    assert np.std(error) < 1e-4 * np.std(second[2400:7200])
