"""A ball with a surface rolls as a smooth ball does over the sum of both surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from ball_scenes import TURN, small_ball
from hard_cases.gaussian_heights import gaussian
from helpers import march_all, roll

from acoustics import envelope_spectrum
from rolling.check import cost
from rolling.check.force_estimate import force_rms
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.scene_surface import ball_heights, heights, scene_surface
from rolling.kinds.run_folder import RunFolder
from rolling.marches.piece import contact_identity
from rolling.results.run_result import make_run
from rolling.scene.surfaces import GRADES
from rolling.surface.ball_form import rolled_together

ROUGH = {"kind": "gaussian", "roughness_ra_um": 0.005, "correlation_length_um": 10, "seed": 4}


@pytest.mark.slow
@pytest.mark.law("Ball surface: a rough ball on a smooth plate is a smooth ball on the same field.")
def test_a_rough_ball_on_a_smooth_plate_is_a_smooth_ball_on_that_field() -> None:
    """Bit by bit, over one turn and the beginning of the next."""
    scene = small_ball(**ROUGH)
    ra = 0.005 * 1e-6
    length = 10 * 1e-6
    field = gaussian((TURN, 16), scene.spacing, ra, (length, length), "gaussian", (4, 1))
    rough = rolling_contact(scene)
    smooth = rolling_contact(small_ball(), field)
    for ours, theirs in zip(roll(rough, 290, 330), roll(smooth, 290, 330), strict=True):
        assert np.array_equal(ours.pressure, theirs.pressure)
        assert ours.approach == theirs.approach


@pytest.mark.parametrize("kind", ["smooth", "gaussian"])
def test_equal_seeds_of_ball_and_plate_make_different_heights(kind: str) -> None:
    """Equal heights would add up to +6 dB instead of +3 dB."""
    law = {**ROUGH, "spacing_um": 2, "width_um": 32}
    plate = heights(small_ball().with_(surface=law))
    ball = heights(small_ball(**ROUGH))
    assert abs(np.corrcoef(plate.ravel(), ball.ravel())[0, 1]) < 0.3  # 1 if they were equal


@pytest.mark.law("Ball surface: mean squares of ball and plate add.")
def test_equal_roughness_of_ball_and_plate_adds_three_decibels() -> None:
    """Within 0.3 dB: 20 turns on a wide plate have some 1,400 patches of a correlation length."""
    law = {**ROUGH, "spacing_um": 2, "width_um": 256}
    changes = {"surface": law, "rolling.distance_mm": 20 * 0.628, "sphere.surface": ROUGH}
    both = small_ball().with_(changes)
    alone = both.with_({"sphere.surface": None})
    ratio = scene_surface(both).statistics.rq / scene_surface(alone).statistics.rq
    assert 20 * np.log10(ratio) == pytest.approx(10 * np.log10(2), abs=0.3)
    assert cost.roughness(both) == pytest.approx(np.sqrt(2) * np.array(cost.roughness(alone)))
    # The linear chain adds them up as well; roughness widens the contact of its estimate a little.
    fine = {"dynamics": {}, "surface.roughness_ra_um": 1e-5}
    one, two = (
        force_rms(scene.with_(fine | more)) or 0
        for scene, more in (
            (alone, {}),
            (both, {"sphere.surface.roughness_ra_um": 1e-5}),
        )
    )
    assert two == pytest.approx(np.sqrt(2) * one, rel=0.01)


@pytest.mark.parametrize(
    ("start_um", "step", "rough_plate"),
    [(0.0, "1", False), (0.0, "0.5", True), (-700.3, "3", True), (5000.0, "1", True)],
)
def test_the_sum_holds_on_a_track_that_does_not_close(
    start_um: float, step: str, rough_plate: bool
) -> None:
    """Each place of the track meets its own place of the ball, and no jump lies behind it."""
    law = {**ROUGH, "seed": 9} if rough_plate else {"kind": "smooth"}
    scene = small_ball(f"numerics.step_nodes={step}", "rolling.distance_mm=0.9", **ROUGH)
    scene = scene.with_(
        {"rolling.start_um": start_um, "surface": {**law, "spacing_um": 2, "width_um": 32}}
    )
    track = scene.track
    total = heights(scene)
    assert not track.closed
    assert track.solved_steps == track.steps == round(0.9e-3 / track.step)
    assert scene.sphere.surface is not None
    ball, _ = ball_heights(scene, scene.sphere.surface)
    alone = {"sphere.surface": None, "rolling.distance_mm": 2e-3 * len(total)}
    plate = heights(scene.with_({**alone, "numerics.step_nodes": 1}))
    first = int(np.floor(start_um / 2))
    places = np.arange(first - 8, first + 450 + 8)  # half a width beyond either end
    expected = ball[places % TURN] + plate[places % len(total)]
    assert np.abs(total[places % len(total)] - expected).max() < 1e-20
    steps = np.abs(np.diff(total, axis=0, append=total[:1]))
    assert steps.max() < 1.5 * steps[:400].max()


def test_a_track_one_node_longer_than_a_turn_does_not_close() -> None:
    whole, longer = (small_ball(f"rolling.distance_mm={d}", **ROUGH) for d in (0.628, 0.63))
    assert (whole.track.closed, whole.track.n_along) == (True, TURN)
    assert (longer.track.closed, longer.track.n_along) == (False, TURN + 1 + 2 * 16)
    assert longer.track.turns == pytest.approx(315 / 314)


@pytest.mark.law("Ball surface: a wave of order k has k periods in a turn.")
def test_waves_of_a_circumference_make_lines_at_multiples_of_the_turn() -> None:
    """The approach under a constant load follows them: they are long for the contact."""
    orders = {3: 0.004, 7: 0.002}
    result = march_all(small_ball(kind="smooth", waviness=orders))
    lines = np.abs(np.fft.rfft(result.whole_series("approach")[:-1])) * 2 / TURN
    for order, amplitude_um in orders.items():
        assert lines[order] == pytest.approx(amplitude_um * 1e-6, rel=0.02)
    others = np.delete(lines[1:], [order - 1 for order in orders])
    assert others.max() < 0.02 * lines[7]  # tones of the grid and of the varying curvature


@pytest.mark.law("Ball surface: one pit is heard once per turn.")
def test_a_pit_of_the_ball_ticks_once_per_turn() -> None:
    """Lines at multiples of v/(2 pi R) stand 10 times above the median of the lines about them."""
    pit = {"kind": "pit", "at_mm": [0.2, 0], "size_um": 12, "depth_um": 0.1}
    law = {**ROUGH, "roughness_ra_um": 0.002, "spacing_um": 2, "width_um": 32}
    scene = small_ball("rolling.distance_mm=3.14", kind="smooth", faults=[pit])
    scene = scene.with_(surface=law)
    run = make_run(RunFolder({}, scene, scene.folder), "pit", march_all(scene))
    assert run.numbers.turns.turns == pytest.approx(5)
    turn_hz = run.numbers.turns.frequency_hz
    assert turn_hz == pytest.approx(0.03 / 0.628e-3)
    sound = run.sound
    band = run.numbers.turns.band_hz
    spectrum = envelope_spectrum(sound.pressure, sound.sample_rate, band, sound.closed)
    about = np.median(spectrum.modulation[spectrum.frequency_hz < 6 * turn_hz])
    for multiple in range(1, 6):
        assert spectrum.at(multiple * turn_hz) > 10 * about
    assert run.numbers.turns.modulation == spectrum.at(turn_hz)
    assert run.numbers.turns.prominence == spectrum.prominence(turn_hz) > 10
    assert run.numbers.turns.reason is None
    alone = scene.with_({"sphere.surface.faults": None})
    plain = make_run(RunFolder({}, alone, alone.folder), "round", march_all(alone))
    assert plain.numbers.turns.prominence < 5


@pytest.mark.parametrize("turns", [1.5, 2.0, 2.5, 3 - 1 / TURN, 3.0])
def test_a_pit_is_heard_from_two_turns_on(turns: float) -> None:
    """A node more or less changes neither the octave nor the judgement; less tells nothing."""
    pit = {"kind": "pit", "at_mm": [0.2, 0], "size_um": 12, "depth_um": 0.1}
    law = {**ROUGH, "roughness_ra_um": 0.002, "spacing_um": 2, "width_um": 32}
    ball = {"kind": "smooth", "faults": [pit]}
    scene = small_ball(f"rolling.distance_mm={turns * 0.628:.3f}", **ball).with_(surface=law)
    run = make_run(RunFolder({}, scene, scene.folder), "pit", march_all(scene))
    assert run.numbers.turns.turns == pytest.approx(turns)
    if turns < 2:
        assert run.numbers.turns.prominence is run.numbers.turns.band_hz is None
        assert "distance_mm of at least 1.3" in run.numbers.turns.reason
        assert "turns_unknown" in [doubt.key for doubt in run.numbers.doubts]
    else:
        assert run.numbers.turns.prominence > 10
        assert run.numbers.turns.band_hz == pytest.approx([4466.8, 8912.5], abs=0.1)


@pytest.mark.parametrize("grade", GRADES)
def test_a_grade_gives_roughness_and_form(grade: str) -> None:
    """ISO 3290-1: Ra is that of the roughness alone, the deviation the height of the form."""
    scene = small_ball(kind="graded", grade=grade, seed=4)
    assert scene.sphere.surface is not None
    ra, deviation = GRADES[grade]
    alone = small_ball(**{**ROUGH, "roughness_ra_um": ra})
    assert scene_surface(alone).statistics.ra == pytest.approx(ra * 1e-6)
    form = (heights(scene) - heights(alone))[:, 0]
    lines = np.abs(np.fft.rfft(form))
    assert np.ptp(form) == pytest.approx(deviation * 1e-6)
    assert lines[2:16] == pytest.approx(2 * lines[2] / np.arange(2, 16))
    assert max(lines[:2].max(), lines[16:].max()) < 1e-9 * lines[2]


@pytest.mark.parametrize(
    "changed",
    [
        {"sphere.surface.seed": 5},
        {"sphere.surface.waviness": {2: 0.001}},
        {"sphere.surface": {"kind": "graded", "grade": "G3"}},
        {"sphere.surface": None},
        {"surface.faults": [{"kind": "groove", "at_mm": [0.1, 0], "size_um": 9, "depth_um": 0.1}]},
    ],
)
def test_another_surface_of_the_ball_is_another_march(changed: dict[str, Any]) -> None:
    scene = small_ball(**ROUGH)
    assert contact_identity(scene.with_(changed)) != contact_identity(scene)


def test_a_file_of_a_turn_is_laid_around_the_ball(tmp_path: Any) -> None:
    """Its mean and the wave of order 1 are removed; a line is the same all across."""
    angle = 2 * np.pi * np.arange(TURN) / TURN
    line = 2e-9 * np.cos(5 * angle + 1)
    np.save(tmp_path / "turn.npy", 1e-6 + 3e-9 * np.sin(angle) + line)
    ball = {"kind": "file", "path": str(tmp_path / "turn.npy"), "spacing_um": 2}
    scene = small_ball(**ball)
    assert np.abs(heights(scene) - line[:, None]).max() < 1e-15
    before = contact_identity(scene)
    np.save(tmp_path / "turn.npy", 2 * line)
    assert contact_identity(scene) != before


def test_a_ball_with_a_surface_rolls_over_a_file(tmp_path: Any) -> None:
    """The sum closes after the common period of file and turn, and not before."""
    np.save(tmp_path / "plate.npy", 1e-9 * np.random.default_rng(1).standard_normal((157, 16)))
    plate = {"kind": "file", "path": str(tmp_path / "plate.npy"), "spacing_um": 2, "level": "none"}
    once = small_ball(**ROUGH).with_(surface=plate)
    assert (once.track.closed, once.track.lap_steps, once.track.n_along) == (True, TURN, TURN)
    half = once.with_({"rolling.distance_mm": None})  # once round the file, half a turn
    assert (half.track.closed, half.track.steps, half.track.n_along) == (False, 157, 157 + 32)
    both = rolled_together(
        heights(half.with_({"sphere.surface": None})), heights(small_ball(**ROUGH)), once.track, 0
    )
    places = np.arange(-8, 157 + 8)
    assert np.array_equal(heights(once), both)
    assert np.abs(heights(half)[places] - both[places % TURN]).max() < 1e-20
