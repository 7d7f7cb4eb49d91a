"""A figure keeps its numbers, its bytes and its edges, and compared figures share axes."""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from scene_text import BODIES, MADE

from rolling import commands
from rolling.figures import run_figures
from rolling.figures.picture import DPI, SIDE_IN, Picture
from rolling.scene.scene import Scene
from rolling.simulation import labels, result_file
from rolling.simulation.run_result import RunResult, hear
from rolling.sound.contact_sound import contact_sound

pytestmark = pytest.mark.slow

SCENE = f"""\
name: small
{BODIES}{MADE}\
rolling: {{load_n: 1, speed_m_s: 0.1, duration_s: 0.009}}
recovery: {{events: true}}
sweep: {{rolling.load_n: [0.5, 2]}}
"""
SMOOTH = """\
name: smooth
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: smooth, spacing_um: 2, width_um: 200}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.003}
"""


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def heard(text: str, folder: Path) -> list[RunResult]:
    """Return the runs of a scene, solved and read again from their folder."""
    (folder / "s.yaml").write_text(text)
    commands.run(folder / "s.yaml", [], folder / "out", wanted=commands.Wanted(workers=1))
    return read(folder / "out")


def read(folder: Path) -> list[RunResult]:
    runs = [
        hear(
            one.label, one.values, one.folder, one.scene, result_file.load(one.folder / "result.h5")
        )
        for one in commands.read_runs(folder)
    ]
    return [one for one in runs if one is not None]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunResult]:
    return heard(SCENE, tmp_path_factory.mktemp("figures"))


def by_name(pictures: Iterator[Picture]) -> dict[str, Picture]:
    return {picture.name: picture for picture in pictures}


def note(picture: Picture) -> str:
    return picture.figure.texts[1].get_text()


def labelled(runs: list[RunResult]) -> list[RunResult]:
    """Return the runs with labels made together."""
    return [replace(one, label=label) for one, label in zip(runs, labels.labels(runs), strict=True)]


def renamed(one: RunResult, name: str) -> Scene:
    return Scene.from_dict(one.scene.to_dict() | {"name": name}, one.scene.folder)


ALWAYS = {
    "spectrum",
    "article_spectrum",
    "psd",
    "third_octaves",
    "third_octaves_a",
    "spectrogram",
    "release_power",
    "surface",
    "contact",
}


def test_a_run_folder_has_them_all(runs: list[RunResult]) -> None:
    for one in runs:
        for name in ALWAYS | {"recovery_events"}:
            for suffix in ("png", "svg"):
                assert (one.folder / f"{name}.{suffix}").stat().st_size > 5000
    together = {path.name for path in runs[0].folder.parent.glob("*.svg")}
    assert together == {
        f"{name}.svg"
        for name in (
            "spectrum",
            "article_spectrum",
            "psd",
            "third_octaves",
            "third_octaves_a",
            "levels",
        )
    }


def test_what_is_compared_has_the_same_axes(runs: list[RunResult]) -> None:
    first, second = (by_name(run_figures.of_run(one, runs)) for one in runs)
    both = by_name(run_figures.of_runs(runs))
    for name in ("spectrum", "article_spectrum", "psd", "third_octaves", "third_octaves_a"):
        axes = [pictures[name].figure.axes[0] for pictures in (first, second, both)]
        assert len({ax.get_ylim() for ax in axes}) == len({ax.get_xlim() for ax in axes}) == 1
    images = [
        pictures["spectrogram"].figure.axes[0].get_images()[0] for pictures in (first, second)
    ]
    assert images[0].get_clim() == images[1].get_clim()
    for name in ("spectrogram", "release_power"):
        assert first[name].plot_area() == second[name].plot_area()
    # The power axis spans the same share of either mean.
    limits = [
        np.array(pictures["release_power"].figure.axes[0].get_ylim()) / np.mean(one.sound.power)
        for one, pictures in zip(runs, (first, second), strict=True)
    ]
    units = limits[0] / limits[1]  # the powers may be in different units
    assert units[0] == pytest.approx(units[1], rel=1e-9)
    for number in (0, 2):
        maps = [pictures["contact"].figure.axes[number] for pictures in (first, second)]
        assert maps[0].get_images()[0].get_clim() == maps[1].get_images()[0].get_clim()
        assert np.ptp(maps[0].get_xlim()) == pytest.approx(np.ptp(maps[1].get_xlim()), rel=1e-12)
    # Alone, a run has axes of its own.
    alone = by_name(run_figures.of_run(runs[0]))
    assert alone["spectrum"].figure.axes[0].get_ylim() != both["spectrum"].figure.axes[0].get_ylim()


def test_the_same_run_gives_the_same_bytes(runs: list[RunResult]) -> None:
    again = read(runs[0].folder.parent)
    pairs = zip(run_figures.of_run(runs[0], runs), run_figures.of_run(again[0], again), strict=True)
    for one, other in [
        *pairs,
        *zip(run_figures.of_runs(runs), run_figures.of_runs(again), strict=True),
    ]:
        assert (one.png(), one.svg(), one.csv()) == (other.png(), other.svg(), other.csv()), (
            one.name
        )


def columns(picture: Picture) -> dict[str, np.ndarray]:
    # text stays text
    head, *rows = csv.reader(io.StringIO(picture.csv().decode()))
    texts = {"run", "quantity", "curve"}
    return {
        name: np.array([row[k] if name in texts else float(row[k] or "nan") for row in rows])
        for k, name in enumerate(head)
    }


def test_curves_in_the_csv_add_up_to_the_levels(runs: list[RunResult]) -> None:
    one = runs[0]
    pictures = by_name(run_figures.of_run(one, runs))
    spectrum = columns(pictures["spectrum"])
    assert list(spectrum) == ["smoothed", "frequency_hz", "a_weighted_line_level_db"]
    lines = spectrum["a_weighted_line_level_db"][spectrum["smoothed"] == 0]
    # The record is limited to what is drawn; nine digits of a level leave 1e-7 dB.
    assert 10 * np.log10(np.sum(10 ** (lines / 10))) == pytest.approx(
        one.sound.levels.laeq_db, abs=1e-6
    )
    density = columns(pictures["psd"])
    lines_only = density["smoothed"] == 0
    level, frequency = (
        density[name][lines_only] for name in ("density_level_db_per_hz", "frequency_hz")
    )
    # Seven averages of noise, and a closed record cut open: 1 dB.
    total = 10 * np.log10(np.sum(10 ** (level / 10)) * (frequency[1] - frequency[0]))
    assert total == pytest.approx(one.sound.levels.level_db, abs=1.0)
    for name, column, whole in (
        ("third_octaves", "level_db", "level_db"),
        ("third_octaves_a", "a_weighted_level_db", "laeq_db"),
    ):
        bands = columns(pictures[name])[column]
        assert 10 * np.log10(np.nansum(10 ** (bands / 10))) == pytest.approx(
            getattr(one.sound.levels, whole), abs=1e-6
        )
    np.testing.assert_allclose(
        columns(pictures["release_power"])["release_power_w"], one.sound.power, rtol=1e-8
    )
    profile = columns(pictures["surface"])
    assert len(profile["height_um"]) == 400  # 0.8 mm of nodes 2 µm apart
    events = columns(pictures["recovery_events"])
    for kind in ("energy_j", "duration_steps"):
        for of in ("events", "release"):
            shares = events[f"share_of_{of}"][events["quantity"] == kind]
            assert shares.sum() == pytest.approx(1.0, rel=1e-8)


def test_tables_of_several_runs_are_those_of_one_with_a_column_more(runs: list[RunResult]) -> None:
    """Rows of one run, taken from the table of all of them, are the rows of its own table."""
    together, own = (
        by_name(run_figures.of_runs(runs)),
        by_name(run_figures.of_run(runs[0], runs)),
    )
    for name in ("spectrum", "article_spectrum", "psd", "third_octaves", "third_octaves_a"):
        all_runs, alone = columns(together[name]), columns(own[name])
        assert list(all_runs) == ["run", *alone]
        assert len({len(values) for values in all_runs.values()}) == 1
        rows = all_runs["run"] == runs[0].label
        assert 0 < rows.sum() < len(rows)
        for column, values in alone.items():
            assert np.array_equal(all_runs[column][rows], values, equal_nan=True)


def test_levels_against_the_load(runs: list[RunResult]) -> None:
    picture = by_name(run_figures.of_runs(runs))["levels"]
    found = columns(picture)
    assert found["load_n"].tolist() == [0.5, 2.0]
    for k, one in enumerate(runs):
        assert found["laeq_db"][k] == pytest.approx(one.sound.levels.laeq_db, abs=1e-6)
        assert found["lzeq_standard_uncertainty_db"][k] == pytest.approx(
            one.sound.uncertainty.level_db, abs=1e-6
        )
    left, right = picture.figure.axes
    assert left.get_ylim() == right.get_ylim()


def test_notes_say_what_was_assumed(runs: list[RunResult]) -> None:
    pictures = by_name(run_figures.of_run(runs[0], runs))
    # 0.009 s: 432 samples; Welch segments of a quarter, 108 samples.
    for name, facts in {
        "spectrum": ("at 1 m", "T = 0.009 s", "lines of 111 Hz"),
        "article_spectrum": ("at 1 m", "q = 1", "T = 0.009 s", "lines of 111 Hz"),
        "psd": ("Welch, Hann", "lines of 444 Hz", "ENBW 667 Hz"),
        "spectrogram": ("Hann frames of", "every", "ENBW"),
        "surface": ("Ra 0.1 µm", "kurtosis"),
        "contact": ("hardness 2.1 GPa", "same scales for all runs compared"),
        "recovery_events": ("events", "per mm", "the top tenth releases"),
    }.items():
        for fact in facts:
            assert fact in note(pictures[name]), (name, note(pictures[name]))
        assert f"small, {runs[0].label}" in pictures[name].figure.texts[0].get_text()


def test_other_distances_are_named_as_a_range(runs: list[RunResult]) -> None:
    far = Scene.from_dict(
        runs[1].scene.to_dict() | {"sound": {"distance_m": 4}}, runs[1].scene.folder
    )
    both = by_name(run_figures.of_runs([runs[0], replace(runs[1], scene=far)]))
    assert "at 1 to 4 m" in note(both["spectrum"])


def test_runs_of_other_scenes_stand_together(runs: list[RunResult]) -> None:
    other = replace(runs[1], scene=renamed(runs[1], "other"), values={"sphere.radius_mm": 5.0})
    pictures = by_name(run_figures.of_runs([runs[0], other]))
    assert "levels" not in pictures  # no swept quantity in common
    assert pictures["psd"].figure.texts[0].get_text().endswith("small, other")


def edges_are_blank(picture: Picture) -> bool:
    """Tell whether nothing is drawn within half the margin of any edge."""
    pixels = imread(io.BytesIO(picture.png()))[..., :3].min(axis=2)
    rim = int(SIDE_IN / 2 * DPI)
    inner = pixels[2:-2, rim:-rim].size
    return bool(
        (
            pixels[:2].min()
            == pixels[-2:].min()
            == pixels[:, :rim].min()
            == pixels[:, -rim:].min()
            == 1.0
        )
        and inner
    )


def test_long_names_and_twelve_runs_stay_within_the_figure(runs: list[RunResult]) -> None:
    one = replace(runs[0], scene=renamed(runs[0], "W" * 64))
    many = [
        replace(
            one,
            label=f"load {k + 1} N, correlation length {k} µm, Ra 0.{k} µm",
            values={"rolling.load_n": k // 4 + 1.0, "surface.correlation_length_um": k % 4 + 10.0},
        )
        for k in range(12)
    ]
    for picture in [*run_figures.of_runs(many), *run_figures.of_run(many[-1], many)]:
        assert edges_are_blank(picture), picture.name
        for legend in picture.figure.legends:
            box = legend.get_window_extent()
            for ax in picture.figure.axes:
                below = ax.get_tightbbox()
                # a dot of rounding
                assert below is not None and below.y0 > box.y1 - 1.0, picture.name


def test_labels_do_not_change_where_the_plot_lies(runs: list[RunResult]) -> None:
    long = replace(runs[0], scene=renamed(runs[0], "W" * 64))
    for name in ("spectrogram", "release_power"):
        areas = [
            by_name(run_figures.of_run(one, runs))[name].plot_area() for one in (runs[0], long)
        ]
        assert areas[0] == areas[1]


def test_ten_seconds_stay_small(runs: list[RunResult]) -> None:
    """A picture of 500,000 steps of noise adds less than 150 kB to a page."""
    energy = 1e-9 * (1.0 + 0.1 * np.random.default_rng(1).standard_normal(500_000))
    sound = contact_sound(runs[0].scene, energy, 2e-6, True, 500_000)
    assert sound.duration == pytest.approx(10.0)
    pictures = by_name(run_figures.of_run(replace(runs[0], sound=sound)))
    for name, picture in pictures.items():
        assert len(picture.svg()) < 150e3, name
    assert "minimum and maximum in each of 1,500 columns" in note(pictures["release_power"])
    assert len(pictures["release_power"].columns["release_power_w"]) == 500_000


def test_large_surfaces_are_drawn_from_every_other_node(runs: list[RunResult]) -> None:
    wide = Scene.from_dict(
        runs[0].scene.to_dict()
        | {"surface": runs[0].scene.to_dict()["surface"] | {"width_um": 1200}},
        runs[0].scene.folder,
    )
    picture = by_name(run_figures.of_run(replace(runs[0], scene=wide)))["surface"]
    assert "map: every 2 nodes" in note(picture) and len(picture.svg()) < 150e3


def test_silence_is_drawn(tmp_path: Path) -> None:
    (one,) = heard(SMOOTH, tmp_path)
    assert one.sound.levels.level_db is None
    pictures = by_name(run_figures.of_run(one))
    assert set(pictures) == ALWAYS
    for name in ("spectrum", "psd", "third_octaves", "spectrogram"):
        assert [text.get_text() for text in pictures[name].figure.axes[0].texts] == ["no sound"]
        assert pictures[name].png() and pictures[name].svg() and pictures[name].csv() is not None
    # Beside a run that sounds, too.
    for picture in run_figures.of_runs([one, replace(one, label="again")]):
        assert picture.svg()


@pytest.mark.parametrize("steps", [2, 3, 10])
def test_the_beginning_of_a_run_is_drawn(runs: list[RunResult], steps: int) -> None:
    """A figure draws two steps as two samples."""
    result = result_file.load(runs[0].folder / "result.h5")
    result.series["release_energy"][steps:] = np.nan
    part = hear("part", {}, runs[0].folder, runs[0].scene, result)
    assert part is not None and len(part.sound.pressure) == max(2, round(steps * 2e-5 * 48000))
    for picture in [*run_figures.of_run(part), *run_figures.of_runs([part, runs[1]])]:
        assert picture.png() and picture.svg() and picture.csv() is not None


def test_one_band_alone_is_drawn(runs: list[RunResult]) -> None:
    """A tone has a single line and a single band, on axes that contain it."""
    steps = len(runs[0].sound.power)
    # 9 periods in 0.009 s: 1 kHz
    energy = 1e-9 * (1.0 + 0.1 * np.sin(2 * np.pi * 9 * np.arange(steps) / steps))
    tone = replace(runs[0], sound=contact_sound(runs[0].scene, energy, 2e-6, True, steps))
    pictures = by_name(run_figures.of_run(tone))
    bands = {
        name
        for name, level in tone.sound.levels.third_octave_db.items()
        if level is not None and level > 0
    }
    assert "1000" in bands
    low, high = pictures["third_octaves"].figure.axes[0].get_ylim()
    assert low < tone.sound.levels.third_octave_db["1000"] < high
    for picture in pictures.values():
        assert picture.svg()


def test_maps_and_events_only_where_there_are_any(runs: list[RunResult]) -> None:
    bare = replace(runs[0].result, snapshot=None, event_pieces={})
    assert set(by_name(run_figures.of_run(replace(runs[0], result=bare)))) == ALWAYS - {"contact"}


def test_runs_alike_in_name_stay_apart(runs: list[RunResult]) -> None:
    """A run from another place and a run of another scene keep their own curves."""
    far = Scene.from_dict(
        runs[0].scene.to_dict() | {"sound": {"distance_m": 4}}, runs[0].scene.folder
    )
    for other, expected in (
        (replace(runs[0], scene=far), ["load 0.5 N, distance 1 m", "load 0.5 N, distance 4 m"]),
        (
            replace(runs[0], scene=renamed(runs[0], "other")),
            ["small, load 0.5 N", "other, load 0.5 N"],
        ),
        (runs[0], ["load 0.5 N (1)", "load 0.5 N (2)"]),
    ):
        pictures = by_name(run_figures.of_runs(labelled([runs[0], other])))
        assert "levels" not in pictures
        for name in ("spectrum", "psd", "third_octaves"):
            assert [text.get_text() for text in pictures[name].figure.legends[0].get_texts()][
                :2
            ] == expected
        assert len(set(pictures["third_octaves"].columns["run"].tolist())) == 2
    sweeps = [*runs, *(replace(one, scene=renamed(one, "other")) for one in runs)]
    found = by_name(run_figures.of_runs(sweeps))["levels"].columns
    assert found["curve"].tolist() == ["other", "other", "small", "small"]
    assert found["load_n"].tolist() == [0.5, 2.0, 0.5, 2.0]
