"""A motion beyond the solved track is the solved one first, and has its statistics later."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from finished import VIBRATING, marched
from helpers import hertz_law
from long_listening_study import compare

from acoustics import resampling
from acoustics.uncertainty import kurtosis
from rolling.contact.track import Motion
from rolling.dynamics import long_motion
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.long_motion import LongLaw, LongMotion
from rolling.in_si.physics_of_scene import bodies_of, listener_of, turn_of
from rolling.results.long_record import motion_at_speed
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.sound.linear_sound import LinearVibration
from rolling.sound.long_listening import (
    Listening,
    LongTravel,
    listen_to_chain,
    listen_to_release,
    listen_to_vibration,
)
from rolling.sound.radiators import roughness_transfers

RATE = 48000


@pytest.fixture(scope="module")
def run() -> Run:
    return marched(VIBRATING, ["surface.width_um=128", "rolling.distance_mm=2.4"])


def long_motion_of(
    scene: Scene, law: ForceLaw, seconds: float, seed: int, motion: Motion | None = None
) -> LongMotion:
    return LongMotion(
        bodies=bodies_of(scene),
        motion=motion or scene.motion,
        law=law,
        seconds=seconds,
        rate=RATE,
        seed=seed,
        turn=turn_of(scene),
    )


def forces(
    run: Run, scene: Scene, seconds: float, seed: int = 0, motion: Motion | None = None
) -> np.ndarray:
    assert run.vibration_sound is not None
    law = run.vibration_sound.law
    return np.concatenate([*long_motion_of(scene, law, seconds, seed, motion).forces()])


def listening_to(
    scene: Scene, law: ForceLaw, seconds: float, motion: Motion | None = None
) -> Listening:
    travel = LongTravel(motion=motion or scene.motion, seconds=seconds)
    return listen_to_vibration(bodies_of(scene), listener_of(scene), law, travel)


def test_the_solved_track_comes_first(run: Run) -> None:
    """Steps differ by 1 % in length, which changes the force by 0.1 % at 40 steps per period."""
    assert run.vibration_sound is not None
    motion = run.vibration_sound.motion
    force = forces(run, run.scene, 0.02)
    times = (np.arange(len(force)) + 0.5) * 0.02 / len(force)
    inside = times < 0.95 * motion.time_s[-1]
    known = np.interp(times[inside], motion.time_s, motion.force_n)
    error = force[inside] - known
    assert np.std(error) < 0.03 * np.std(known - run.scene.load)


def test_forces_do_not_depend_on_the_stretches(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = forces(run, run.scene, 0.1)
    monkeypatch.setattr(long_motion, "STRETCH_STEPS", 1_500)
    assert np.allclose(forces(run, run.scene, 0.1), whole, rtol=0, atol=1e-9)
    assert not np.allclose(forces(run, run.scene, 0.1, 1), whole, rtol=0, atol=1e-3)


def test_the_continued_law_is_a_force_law(run: Run) -> None:
    """Slopes are positive, and the statistics of approach and stiffness are the solved ones."""
    assert run.vibration_sound is not None
    law = run.vibration_sound.law
    long = LongLaw(law, run.scene.load, 3, None)
    table = long.table(0.0, 100 * law.period_m)
    own = law.table.values[:-1]
    values = table.values[len(own) : -100]
    assert np.array_equal(np.argsort(table.breaks), np.arange(len(table.breaks)))
    assert values[:, 1:].min() > 0 and long.limited < 0.01 * long.continued
    assert np.allclose(values.mean(axis=0), own.mean(axis=0), rtol=0.02)
    # The deviation of a track of 2.4 mm is known to a tenth.
    assert np.allclose(values.std(axis=0), own.std(axis=0), rtol=0.15)
    known = np.corrcoef(own.T)
    assert np.allclose(np.corrcoef(values.T), known, atol=0.1)


def test_a_changing_speed_ends_at_its_last_speed_and_at_rest(run: Run) -> None:
    motion = motion_at_speed(run.scene, (0.4, 0.0), 0.2)
    force = forces(run, run.scene, 0.3, motion=motion)
    assert float(motion.distance(0.3)) == pytest.approx(0.04)
    late = force[-len(force) // 6 :]
    early = force[: len(force) // 6]
    assert np.std(late) < 1e-3 * np.std(early)  # it rests and rings out


def test_a_continuation_agrees_with_a_longer_solved_track(run: Run) -> None:
    """The continuations of six parts of 0.4 mm know 2.4 mm to their stated uncertainty."""
    table = compare(run, parts=6, lengths=6)
    spread = math.sqrt(float(np.mean(np.square(table["level"]))))
    assert spread < 2 * table["stated"].mean()
    # The mean level over parts is lower than that of the mean power, by a decibel for few lines.
    assert abs(table["level"].mean()) < 3 * table["stated"].mean() / math.sqrt(6)
    assert table["bands"].mean() > 0.8
    own = table["kurtosis"] + table["solved kurtosis"]  # 48 ms of a resonance: three times 0.3
    assert (table["impacts"] == 0).all() and (own - 3).abs().max() < 1


def test_impacts_go_on(run: Run) -> None:
    """A fast ball flies beyond the solved track as on it, whose fifteen impacts come in groups."""
    scene = run.scene.with_({"rolling.speed_m_s": 3, "plate.thickness_mm": 20})
    assert run.vibration_sound is not None
    law = run.vibration_sound.law
    solved = 0.0024 / 3
    counts = []
    for seconds in (solved, 100 * solved):
        motion = long_motion_of(scene, law, seconds, 0)
        force = np.concatenate([*motion.forces()])
        assert motion.free_steps == np.sum(force == 0) and motion.taken == len(force)
        assert motion.impacts == np.sum((force[:-1] == 0) & (force[1:] > 0))
        counts.append(motion.impacts / seconds)
    assert counts[0] > 0 and 1 / 3 < counts[1] / counts[0] < 3


def test_a_plate_with_edges_is_heard_in_stereo(run: Run) -> None:
    """Both ears hear the plate, whose modes ring for longer than a stretch."""
    edges = {"plate.length_mm": 60, "plate.width_mm": 50, "plate.contact_mm": [26, 18]}
    ears = {"sound.listener_mm": [[10, 25, 200], [50, 25, 200]]}
    assert run.vibration_sound is not None
    listening = listening_to(run.scene.with_(edges | ears), run.vibration_sound.law, 0.1)
    left, right = listening.channels.T
    assert len(left) == 4800 and not np.allclose(left, right, rtol=0, atol=0.1 * np.std(left))
    assert np.std(left) == pytest.approx(np.std(right), rel=0.5)


def test_a_dropped_sphere_may_rest_before_the_end_of_the_solved_track(run: Run) -> None:
    """It rolls 10 um, and the knocks of the fall are heard; the record begins in silence."""
    assert run.vibration_sound is not None
    dropped = run.scene.with_({"rolling.drop_mm": 0.01})
    slow = motion_at_speed(dropped, (2e-4, 0.0), 0.1)
    listening = listening_to(dropped, run.vibration_sound.law, 0.1, slow)
    assert listening.numbers.rolled_mm == pytest.approx(0.01)
    assert listening.numbers.impacts > 0 and listening.numbers.level_db is not None


def test_a_smooth_track_stays_at_the_load() -> None:
    run = marched(VIBRATING, ["surface={kind: smooth, spacing_um: 2, width_um: 160}"])
    assert run.vibration_sound is not None
    law = hertz_law(1.0, 5e-3, 2.3e11, np.zeros(100))
    listening = listening_to(run.scene, law, 0.2)
    assert np.abs(listening.pressure).max() < 1e-12


@pytest.mark.parametrize("source", ["vibration", "release"])
def test_the_caller_learns_of_every_second_of_a_record(run: Run, source: str) -> None:
    seconds: list[float] = []
    listener = listener_of(run.scene)
    travel = LongTravel(motion=run.scene.motion, seconds=0.1)
    if source == "vibration":
        assert run.vibration_sound is not None
        law = run.vibration_sound.law
        listen_to_vibration(bodies_of(run.scene), listener, law, travel, seconds.append)
    else:
        energy = 1e-9 * (1 + 0.1 * np.random.default_rng(1).standard_normal(400))
        listen_to_release(energy, 2e-6, True, listener, travel, seconds.append)
    assert sum(seconds) == pytest.approx(0.1)


@pytest.mark.parametrize("factor", [1, 2, 12, 31])
def test_a_decimator_passes_hearing_and_stops_beyond_it(factor: int) -> None:
    times = np.arange(4800 * factor) / (RATE * factor)
    for frequency, gain in ((1_000, 1), (19_900, 1), (30_000, 0)):
        tone = np.sin(2 * np.pi * frequency * times)
        if frequency > RATE * factor / 2:
            continue
        decimator = resampling.Decimator(factor)
        parts = np.split(tone, [7 * factor, 900 * factor])
        heard = np.concatenate([*(decimator.add(part) for part in parts), decimator.end()])
        expected = gain * tone[::factor]
        assert len(heard) == 4800
        assert np.abs(heard - expected)[30:-30].max() < 1e-3
    assert kurtosis(heard) > 0


WAVES = "sphere.surface={kind: smooth, waviness: {60: 0.01}}"
SMOOTH_PLATE = "surface={kind: smooth, spacing_um: 2, width_um: 160}"


def test_the_waves_around_a_ball_have_the_approach_that_is_solved() -> None:
    """They are known from the scene, and the contact averages them over its length."""
    run = marched(VIBRATING, [SMOOTH_PLATE, WAVES, "rolling.start_um=100"])
    turn = turn_of(run.scene)
    assert turn is not None and turn.length_m == pytest.approx(2 * math.pi * 5e-3)
    solved = run.series["approach"]
    known = turn.form_at(2e-6 * np.arange(len(solved)))
    rest = (solved - known) - np.mean(solved - known)
    assert np.std(rest) < 0.02 * np.std(known)


def test_the_waves_around_a_ball_go_on_turn_after_turn(run: Run) -> None:
    """A ball that follows waves of order n and amplitude A has the force M (2 pi f)^2 A.

    The solved track is a twentieth of a turn, and the force is read over the second to sixth turn.
    """
    scene = run.scene.with_({"sphere.surface": {"kind": "smooth", "waviness": {60: 0.1}}})
    turn = turn_of(scene)
    assert turn is not None and run.vibration_sound is not None
    spacing = 2e-6
    rough = 1e-11 * np.random.default_rng(2).standard_normal(800)
    smooth = hertz_law(1.0, 5e-3, 2.3e11, rough)
    law = replace(
        smooth,
        position_m=spacing * np.arange(800),
        approach_m=smooth.approach_m + turn.form_at(spacing * np.arange(800)),
    )
    turn_s = turn.length_m / 0.3
    force = np.concatenate([*long_motion_of(scene, law, 6 * turn_s, 0).forces()])
    times = (np.arange(len(force)) + 0.5) * 6 * turn_s / len(force)
    late = times > turn_s
    frequency = 60 / turn_s
    line = 2 * np.mean(force[late] * np.exp(-2j * np.pi * frequency * times[late]))
    expected = scene.mass * (2 * math.pi * frequency) ** 2 * 0.1e-6
    assert abs(line) == pytest.approx(expected, rel=0.05)
    others = force[late] - 1.0
    assert np.std(others) == pytest.approx(expected / math.sqrt(2), rel=0.05)


def test_a_linear_chain_hears_the_waves_around_a_ball_turn_after_turn(run: Run) -> None:
    """The pressure of a long record of a single wave is one line, as loud as the chain makes it."""
    scene = run.scene.with_({"sphere.surface": {"kind": "smooth", "waviness": {60: 0.1}}})
    turn = turn_of(scene)
    assert turn is not None
    rough = 1e-12 * np.random.default_rng(2).standard_normal(800)
    approach = 1e-7 + rough + turn.form_at(2e-6 * np.arange(800))
    chain = LinearVibration(
        bodies=bodies_of(scene),
        listener=listener_of(scene),
        stiffness_n_m=1e7,
        motion=scene.motion,
        approach=approach,
        step=2e-6,
        closed=False,
    )
    turn_s = turn.length_m / 0.3
    travel = LongTravel(motion=scene.motion, seconds=6 * turn_s, turn=turn)
    pressure = listen_to_chain(chain, approach, False, travel).pressure
    frequency = np.array([60 / turn_s])
    transfers = roughness_transfers(chain.bodies, chain.listener, chain.bodies.chain(1e7))
    expected = 0.1e-6 * abs(transfers(frequency)[0, 0]) / math.sqrt(2)
    middle = pressure[len(pressure) // 6 : -len(pressure) // 6]
    assert np.sqrt(np.mean(np.square(middle))) == pytest.approx(expected, rel=0.02)
