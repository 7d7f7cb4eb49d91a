"""Laws of a choice: pairs, their ±, its parts, and where a difference lies."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student

import rolling as rc
from acoustics.bands import BAND_NAMES
from acoustics.pairs import FIRST_PAIRS, LOOKS, looks, paired_mean, pairs_needed, student_factor
from acoustics.unbaffled import SHARED_PART
from rolling.ball_kinds.ball_candidates import LOSS_FACTORS, candidate, candidates_of
from rolling.ball_kinds.ball_difference import difference
from rolling.ball_kinds.ball_heard import HeardBall, LevelError
from rolling.ball_kinds.ball_specimens import BallSpecimens
from rolling.choice.choice_doubts import left_out_text
from rolling.choice.choice_sentences import frequencies_of_difference
from rolling.in_si import scene_surface
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.numbers.quantity import PART_WORDS

SMALL = {
    "name": "small",
    "sphere": {"radius_mm": 3, "material": "steel-100cr6"},
    "plate": {"material": "steel-100cr6", "thickness_mm": 3},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.2,
        "correlation_length_um": 12,
        "spacing_um": 3,
        "width_um": 192,
        "seed": 5,
    },
    "rolling": {"load_n": 1, "speed_m_s": 0.1, "distance_mm": 1.5},
    "dynamics": {},
}


def heard(levels_db: list[float], band: str = "1000", grid_db: float | None = None) -> HeardBall:
    """Make what is heard of a specimen whose sound lies in one third octave, by loss factor."""
    squares = (20e-6) ** 2 * 10 ** (np.array(levels_db) / 10)
    bands = np.zeros((len(levels_db), len(BAND_NAMES)))
    bands[:, BAND_NAMES.index(band)] = squares
    return HeardBall(
        loss_factors=tuple(LOSS_FACTORS[: len(levels_db)]),
        squares=squares,
        bands=bands,
        released_power_db=70.0,
        errors={} if grid_db is None else {"grid": LevelError(grid_db, 0.0)},
    )


def scan(folder: Path) -> rc.Scene:
    """Write a scan of 1.2 x 1 mm, and return a scene of it."""
    heights = 1e-7 * np.random.default_rng(3).normal(size=(300, 256))
    np.save(folder / "scan.npy", heights)
    surface = {"kind": "file", "path": str(folder / "scan.npy"), "spacing_um": 4}
    return rc.Scene.from_dict(
        SMALL | {"surface": surface, "rolling": {"load_n": 1, "speed_m_s": 0.1}}
    )


# ---- statistics


@pytest.mark.law("Choice: what a baffle changes on a free plate cancels between sounds of it.")
def test_equal_free_plates_share_what_the_baffle_changes() -> None:
    """Sounds in the same band keep a part of it, sounds in other bands and of other plates all."""
    free = np.full(len(BAND_NAMES), 6.0)

    def part(first: HeardBall, second: HeardBall) -> float:
        return difference([first] * 4, [second] * 4).parts_db["baffle"]

    low = replace(heard([60.0]), baffle_db=free)
    assert part(heard([60.0]), heard([55.0])) == 0.0
    assert part(low, replace(heard([55.0]), baffle_db=free)) == pytest.approx(SHARED_PART * 6.0)
    assert part(low, replace(heard([55.0], "4000"), baffle_db=free)) > 6.0
    assert part(low, replace(heard([55.0]), baffle_db=free / 2)) == pytest.approx(np.hypot(6, 3))
    assert part(low, heard([55.0])) == pytest.approx(6.0)


@pytest.mark.law("Choice: what the ± of a difference leaves out of the ± of the runs has a name.")
def test_the_uncertainty_names_what_it_leaves_out() -> None:
    """Pairs, losses, grid and instrument have parts of their own; all else of the runs is named.

    On plates of different size the baffles differ, and both count whole.
    """
    free = np.full(len(BAND_NAMES), 6.0)
    parts = {"record": 2.0, "comb": 0.0, "contact_loss": 1.0, "time_step": 0.3, "baffle": 6.0}
    low = replace(heard([60.0]), baffle_db=free, parts_db=parts)
    louder = replace(heard([55.0]), baffle_db=free, parts_db=parts | {"time_step": 0.4})
    apart = difference([low] * 4, [louder] * 4)
    assert apart.left_out_db == pytest.approx({"time_step": 0.5, "baffle": 6 * math.sqrt(2)})
    assert apart.parts_db["baffle"] == pytest.approx(SHARED_PART * 6.0)
    assert apart.uncertainty_db == pytest.approx(SHARED_PART * 6.0)
    smaller = replace(louder, baffle_db=free / 2)
    assert difference([low] * 4, [smaller] * 4).left_out_db.keys() == {"time_step"}
    said = left_out_text([apart])
    assert PART_WORDS["baffle"] in said and PART_WORDS["time_step"] in said
    assert left_out_text([difference([heard([60.0])] * 4, [heard([55.0])] * 4)]) == ""


def test_what_pairs_share_cancels() -> None:
    shared = np.random.default_rng(1).normal(0, 5, 6)
    apart = difference(
        [heard([float(db) + 3]) for db in shared], [heard([float(db)]) for db in shared]
    )
    assert apart.db == pytest.approx(3)
    assert apart.uncertainty_db == pytest.approx(0, abs=1e-9)
    assert apart.is_sure


def test_uncertainty_is_that_of_student() -> None:
    values = [1.0, 2.0, 4.0, 1.5, 0.5, 3.0]
    apart = difference([heard([db]) for db in values], [heard([0.0])] * 6)
    error = np.std(values, ddof=1) / math.sqrt(6)
    assert apart.uncertainty_db == pytest.approx(student_factor(5) * error)
    assert apart.parts_db["scatter"] == pytest.approx(error)
    assert student_factor(5) == pytest.approx(1.11, abs=0.01)


def test_equal_candidates_differ_by_nothing_and_are_not_sure() -> None:
    same = [heard([20.0])] * 6
    apart = difference(same, same)
    assert apart.db == 0 and not apart.is_sure


def test_half_of_what_the_loss_factor_changes_is_in_the_uncertainty() -> None:
    first = [heard([12.0, 16.0])] * 6
    second = [heard([10.0, 10.0])] * 6
    apart = difference(first, second)
    assert apart.db == pytest.approx(4)
    assert apart.parts_db["loss_factor"] == pytest.approx(2)
    assert apart.uncertainty_db == pytest.approx(2, rel=0.01)


def test_a_pair_that_is_left_out_counts_as_one_on_the_other_side() -> None:
    """Nobody knows its difference; five pairs of 3 dB and one unknown are no six of 3 dB."""
    first = [heard([23.0])] * 5
    second = [heard([20.0])] * 5
    whole = difference(first, second)
    apart = difference(first, second, omitted=1)
    # Student's t of five values of 3 dB and one of -3 dB
    values = np.array([3.0] * 5 + [-3.0])
    ratio = values.mean() / (values.std(ddof=1) / math.sqrt(6))
    assert apart.sureness == pytest.approx(student.cdf(ratio, 5))
    assert apart.db == whole.db == pytest.approx(3)
    assert whole.sureness == 1.0 and not difference(first, second, omitted=2).is_sure
    assert apart.parts_db["left_out"] == pytest.approx(3 - values.mean())


def test_a_pair_that_is_left_out_lies_beside_a_wide_scatter() -> None:
    """Where pairs scatter by more than their mean, it lies two standard deviations off."""
    levels = [0.1 + db for db in (-3.0, 3.0) * 5]
    silent = [heard([0.0])] * 10
    apart = difference([heard([db]) for db in levels], silent, omitted=1)
    assert apart.parts_db["left_out"] == pytest.approx(2 * np.std(levels, ddof=1) / 11)
    assert apart.sureness == 0.5  # one such pair turns the sign round


def test_pairs_are_looked_at_after_numbers_that_are_fixed() -> None:
    assert looks(60) == [*LOOKS] and looks(1) == [1]
    assert looks(7) == [4, 6, 7]


def test_a_stated_loss_factor_stands_beside_both_of_the_other() -> None:
    apart = difference([heard([12.0])] * 6, [heard([10.0, 8.0])] * 6)
    assert apart.db == pytest.approx(3)
    assert apart.parts_db["loss_factor"] == pytest.approx(1)


def test_errors_of_the_grid_count_as_far_as_they_differ() -> None:
    first = [heard([12.0], grid_db=1.5)] * 6
    second = [heard([10.0], grid_db=0.5)] * 6
    assert difference(first, second).parts_db["grid"] == pytest.approx(1)
    assert difference(first, first).parts_db["grid"] == 0


@pytest.mark.law("Choice: bands that only one of two candidates resolves are in the ±.")
def test_bands_of_one_candidate_alone_are_in_the_uncertainty() -> None:
    """Both sound alike up to 8 kHz. The finer one has as much again above, 3 dB."""
    fine = [heard([30.0, 30.0], band="4000") for _ in range(6)]
    coarse = []
    for one in fine:
        one.bands[:, BAND_NAMES.index("16000")] = one.squares
        cut = one.bands.copy()
        cut[:, BAND_NAMES.index("10000") :] = np.nan
        coarse.append(replace(one, bands=cut))
    fine = [replace(one, squares=2 * one.squares) for one in fine]
    apart = difference(fine, coarse)
    assert apart.db == pytest.approx(10 * math.log10(2))
    assert apart.parts_db["band"] == pytest.approx(10 * math.log10(2))
    assert not apart.is_sure
    assert difference(fine, fine).parts_db["band"] == 0.0


def test_silence_has_no_difference() -> None:
    apart = difference([heard([-math.inf])] * 6, [heard([10.0])] * 6)
    assert apart.db is None and not apart.is_sure


@pytest.mark.parametrize("scatter_db", [0.5, 1.5, 3.0])
def test_stated_uncertainties_hold_although_the_scatter_decides_the_count(
    scatter_db: float,
) -> None:
    """The rule of the program, with normal pairs: coverage 68 % and 92 % (Student, 5 degrees)."""
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(3000):
        values = rng.normal(0, scatter_db, 400)
        count = max(FIRST_PAIRS, pairs_needed(values[:FIRST_PAIRS], 1.0))
        mean = paired_mean(values[: min(count, 400)])
        ratios.append(abs(mean.mean) / (student_factor(mean.freedom) * mean.error))
    assert np.mean(np.array(ratios) < 1) == pytest.approx(0.683, abs=0.03)
    assert np.mean(np.array(ratios) < 2) == pytest.approx(0.922, abs=0.02)


def test_more_scatter_needs_more_pairs() -> None:
    values = np.array([0.0, 1.0, 2.0, 0.5, 1.5, 1.0])
    assert pairs_needed(4 * values, 1.0) > pairs_needed(2 * values, 1.0) > 0


# ---- where a difference lies


def test_frequencies_hold_most_of_the_difference() -> None:
    squares = np.zeros(31)
    squares[BAND_NAMES.index("4000")] = 5
    squares[BAND_NAMES.index("5000")] = 4
    squares[BAND_NAMES.index("200")] = 1
    assert frequencies_of_difference(squares) == "between 4 kHz and 5 kHz"
    assert frequencies_of_difference(-squares) is None


# ---- candidates and specimens


def test_candidates_meet_the_same_seeds() -> None:
    scene = rc.Scene.from_dict(SMALL)
    both = candidates_of([scene, scene.with_(name="fine", roughness_ra_um=0.1, seed=9)])
    specimens = BallSpecimens(both)
    for number in range(3):
        seeds = {specimens.scene(one, number).surface.seed for one in both}
        assert seeds == {5 + number}


def test_a_sweep_over_seeds_makes_no_candidates() -> None:
    scene = rc.Scene.from_dict(SMALL)
    swept = scene.with_(sweep={"surface.roughness_ra_um": [0.1, 0.2], "surface.seed": [1, 2]})
    assert [one.label for one in candidates_of([swept])] == ["Ra 0.1 µm", "Ra 0.2 µm"]


def test_a_scene_without_dynamics_gets_its_bodies() -> None:
    data = {key: value for key, value in SMALL.items() if key != "dynamics"}
    data["plate"] = {"material": "steel-100cr6"}
    one = candidate("one", rc.Scene.from_dict(data))
    assert one.scene.dynamics is not None
    assert "10 mm plate" in one.added
    assert one.loss_factors == LOSS_FACTORS


def test_candidates_of_one_surface_share_their_contact() -> None:
    from rolling.marches.piece import contact_identity

    scene = rc.Scene.from_dict(SMALL)
    thick = scene.with_(name="thick", thickness_mm=8)
    fast = scene.with_(name="fast", speed_m_s=1.0)
    specimens = BallSpecimens(candidates_of([scene, thick]))
    found = {contact_identity(specimens.scene(one, 0)) for one in candidates_of([scene, thick])}
    assert len(found) == 1
    steps = {one.scene.numerics.step_nodes for one in candidates_of([scene, thick])}
    assert len(steps) == 1
    with pytest.raises(rc.SceneError, match="duration"):
        candidates_of([scene, fast])


def test_scans_of_different_length_are_rolled_as_far_as_the_shortest(tmp_path: Path) -> None:
    scene = scan(tmp_path)
    (tmp_path / "short").mkdir()
    short = scan(tmp_path / "short").with_(name="short")
    np.save(tmp_path / "short" / "scan.npy", np.load(tmp_path / "scan.npy")[:200])
    short = short.with_({"surface.path": str(tmp_path / "short" / "scan.npy")})
    both = candidates_of([scene, short])
    assert [one.scene.duration for one in both] == pytest.approx([short.duration] * 2, rel=0.01)
    assert scene.duration == pytest.approx(1.5 * short.duration)
    # A stated length ends a lap, and a lap does not stretch to a longer one.
    half = scene.with_({"name": "half", "rolling.distance_mm": 0.5})
    assert all(
        one.scene.duration == pytest.approx(half.duration, rel=0.01)
        for one in candidates_of([scene, short, half])
    )
    with pytest.raises(rc.SceneError, match="equal durations"):
        candidates_of([short, scene.with_({"rolling.distance_mm": 1.1})])


def test_places_of_a_scan_are_a_contact_width_apart(tmp_path: Path) -> None:
    scene = scan(tmp_path)
    (one, _) = candidates_of([scene, scene.with_(name="heavier", load_n=1.1 * scene.load)])
    specimens = BallSpecimens([one])
    assert specimens.count >= LOOKS[0]
    assert f"room for {specimens.count} of the 99 places" in specimens.shortage_words(99)
    across = sorted(
        specimens.scene(one, number).rolling.across_um for number in range(specimens.count)
    )
    width_um = 2e6 * smooth_contact_of(one.scene).semi_axes_m()[1]
    assert np.diff(across).min() >= width_um * (1 - 1e-9)


def test_places_of_a_scan_share_its_prepared_surface(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six places on each of two scans: each scan is read and prepared once, in any order."""
    prepared = []
    make = scene_surface._make_plate
    monkeypatch.setattr(
        scene_surface, "_make_plate", lambda given: prepared.append(given) or make(given)
    )
    scenes = []
    for name in ("ground", "lapped"):
        (tmp_path / name).mkdir()
        scenes.append(scan(tmp_path / name).with_(name=name))
    candidates = candidates_of(scenes)
    specimens = BallSpecimens(candidates)
    first = {}
    for _ in range(2):
        for number in range(6):
            for one in candidates:
                placed = specimens.scene(one, number)
                heights = scene_surface.heights(placed)
                # the track of a place lies in the middle, as if its surface were made alone
                moved = np.roll(first.setdefault(one.label, heights), -placed.across_nodes, axis=1)
                np.testing.assert_array_equal(heights, moved)
    assert len(prepared) == 2
