"""The levels of the patches of a track add up to LAeq, and stand where the surface sounds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from finished import VIBRATING, WITHOUT_DYNAMICS, marched
from hard_cases.gaussian_heights import gaussian

import rolling as rc
from rolling.results.run_result import Run
from rolling.sound.sound_by_place import SoundByPlace

NODES = 3000  # of 2 um
LENGTH_M = NODES * 2e-6
EDGES = (
    "plate.length_mm=200",
    "plate.width_mm=150",
    "plate.thickness_mm=3",
    "rolling.distance_mm=3",
)
SLOWING = "rolling.speed_m_s=[[0, 0.3], [0.01, 0.1]]"


def places_of(run: Run) -> SoundByPlace:
    places = run.sound_by_place
    assert places is not None
    return places


def energies(places: SoundByPlace) -> np.ndarray:
    """Return the energies of patches, those of faded ones 0."""
    level = np.where(np.isfinite(places.level_db), places.level_db, -np.inf)
    return np.asarray(places.seconds * 10 ** (level / 10))


def file(folder: Path, heights: np.ndarray) -> str:
    """Return the setting of a surface with some heights."""
    path = folder / f"{abs(hash(heights.tobytes()))}.npy"
    np.save(path, heights)
    return f"surface={{kind: file, path: {path}, spacing_um: 2, level: none}}"


@pytest.mark.law("Places: their levels add up to the level of the record.")
@pytest.mark.parametrize(
    "changes",
    [
        (),
        ("rolling.distance_mm=2", "rolling.start_um=700", "rolling.speed_m_s=0.1"),
        pytest.param(  # the ball flies
            ("rolling.distance_mm=6", "rolling.load_n=0.05", "surface.roughness_ra_um=0.3"),
            marks=pytest.mark.slow,
        ),
        ("rolling.distance_mm=3", SLOWING),
        (*WITHOUT_DYNAMICS, "rolling.distance_mm=2"),
        (*WITHOUT_DYNAMICS, "rolling.distance_mm=2", SLOWING),
        EDGES,
    ],
)
def test_the_patches_add_up_to_the_level(changes: tuple[str, ...]) -> None:
    """An open record loses less than 0.1 dB in the faded ends, where no level is stated."""
    run = marched(VIBRATING, changes)
    places = places_of(run)
    exact = 1e-6 if run.sound.closed else 0.1
    assert places.laeq_db == pytest.approx(run.record_laeq_db, abs=exact)
    assert places.seconds.sum() == pytest.approx(run.sound.duration, rel=1e-6)


def test_laps_and_open_stretches_of_a_file(tmp_path: Path) -> None:
    heights = file(tmp_path, gaussian((400, 80), 2e-6, 5e-8, (1e-5, 1e-5), "gaussian", 3))
    laps = marched(VIBRATING, [heights, "rolling.distance_mm=1.6", "rolling.start_um=300"])
    lap = places_of(marched(VIBRATING, [heights, "rolling.distance_mm=0.8"]))
    places = places_of(laps)
    assert places.laeq_db == pytest.approx(laps.record_laeq_db, abs=1e-6)
    assert places.position[-1] + places.length / 2 == pytest.approx(0.8e-3)
    # The same places sound alike, wherever a record begins and however often it goes round.
    assert np.nanmax(np.abs(places.level_db - lap.level_db)) < 1.0
    part = marched(VIBRATING, [heights, "rolling.distance_mm=0.5", "rolling.start_um=100"])
    places = places_of(part)
    assert places.laeq_db == pytest.approx(part.record_laeq_db, abs=0.1)
    ends = places.position[[0, -1]] + places.length / 2 * np.array([-1, 1])
    assert ends == pytest.approx([1e-4, 6e-4])


@pytest.mark.slow
@pytest.mark.parametrize(("speed_m_s", "load_n"), [(0.1, 2.0), (0.4, 1.0)])
def test_a_rough_half_and_a_smooth_half(tmp_path: Path, speed_m_s: float, load_n: float) -> None:
    """The halves are blended over 0.2 mm, and apart by what runs over each of them are apart."""
    rough = gaussian((NODES, 80), 2e-6, 1e-7, (1.2e-5, 1.2e-5), "gaussian", 1)
    smooth = gaussian((NODES, 80), 2e-6, 5e-9, (1.2e-5, 1.2e-5), "gaussian", 2)
    x = np.arange(NODES) / NODES
    share = np.clip(np.minimum(x, 0.5 - x) * LENGTH_M / 2e-4 + 0.5, 0, 1)[:, None]
    share = np.where((x > 1 - 1e-4 / LENGTH_M)[:, None], 0.0, share)
    both = np.sqrt(share) * rough + np.sqrt(1 - share) * smooth
    settings = (f"rolling.speed_m_s={speed_m_s}", f"rolling.load_n={load_n}")
    of = {}
    for name, heights in {"both": both, "rough": rough, "smooth": smooth}.items():
        length = f"rolling.distance_mm={1e3 * LENGTH_M}"
        of[name] = places_of(marched(VIBRATING, [file(tmp_path, heights), length, *settings]))
    places = of["both"]
    energy = energies(places)
    assert energy[places.position < LENGTH_M / 2 + 1e-4].sum() > 0.95 * energy.sum()

    def middle_db(places: SoundByPlace, middle: float) -> float:
        """Return the level of the middle of a half [dB(A)]."""
        inside = np.abs(places.position / LENGTH_M - middle) < 0.1
        return float(10 * np.log10(np.mean(10 ** (places.level_db[inside] / 10))))

    apart = middle_db(places, 0.25) - middle_db(places, 0.75)
    separate = middle_db(of["rough"], 0.25) - middle_db(of["smooth"], 0.75)
    # A stretch of some fifty patches of random roughness scatters by about 1 dB.
    assert apart == pytest.approx(separate, abs=3.0)
    assert apart > 10


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        (),
        ("rolling.speed_m_s=0.6",),
        ("rolling.load_n=0.1",),  # the scratch throws the ball
        ("sound.source=release",),
        EDGES[:3],
    ],
)
def test_a_scratch_is_found_at_its_place(changes: tuple[str, ...]) -> None:
    scratch = "{kind: scratch, at_mm: [2.2, 0], size_um: 40, depth_um: 2, length_um: 100}"
    smooth = "surface.roughness_ra_um=0.002"
    words = [f"surface.faults=[{scratch}]", "rolling.distance_mm=4", smooth]
    run = marched(VIBRATING, [*words, *changes])
    places = places_of(run)
    loudest = places.position[np.nanargmax(places.level_db)]
    assert abs(loudest - 2.2e-3) < 2 * places.length
    usual_db = float(np.nanmedian(places.level_db))
    assert np.nanmax(places.level_db) > usual_db + 10


def test_what_makes_no_sound_by_place_has_none() -> None:
    smooth = marched(VIBRATING, ["surface={kind: smooth, spacing_um: 2, width_um: 160}"])
    assert smooth.sound_by_place is None
    with pytest.raises(ValueError, match="is silent or falls, so no place sounds"):
        rc.plot.places(smooth)
