"""A figure keeps its numbers, its bytes and its edges, and compared figures share axes."""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.image import imread
from report_runs import runs_of, single
from scene_sounds import sound_of_release

from acoustics import plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.spectrum import article_line_level_db
from rolling import plot
from rolling.figures import plot_run, sweep_figures, write_figures, write_number_figures
from rolling.figures.catalogue import comparing_pictures
from rolling.figures.picture import Picture
from rolling.figures.settings import PictureWarning
from rolling.kinds.reading import read_scene
from rolling.report.report_page import page
from rolling.results.run_result import Run
from rolling.scene.scene import Scene


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.fixture
def three() -> list[Run]:
    return runs_of("three")


def table_of(picture: Picture) -> dict[str, np.ndarray]:
    """Read the CSV file of a picture; cells of text stay text."""
    head, *rows = csv.reader(io.StringIO((picture.file("csv") or b"").decode()))
    columns = {}
    for name, cells in zip(head, zip(*rows, strict=True), strict=True):
        try:
            columns[name] = np.array([float(cell or "nan") for cell in cells])
        except ValueError:
            columns[name] = np.array(cells)
    return columns


def renamed(run: Run, name: str) -> Run:
    scene = Scene.from_dict(run.scene.to_dict() | {"name": name}, run.scene.folder)
    return replace(run, scene=scene)


def sounding(run: Run, energy: np.ndarray) -> Run:
    """Return a run with another release energy per step [J]."""
    sound = sound_of_release(run.scene, energy, 2e-6, True, len(energy))
    return replace(run, sound=sound)


def words(picture: Picture) -> str:
    """Return title and note of a picture."""
    assert picture.caption is not None
    return "\n".join(picture.caption)


def test_a_picture_that_cannot_be_drawn_costs_that_picture(
    three, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*values: Any, **named: Any) -> None:
        raise RuntimeError("no pencil")

    monkeypatch.setattr(plots, "spectrum", fail)
    monkeypatch.setattr(plots, "spectrogram", fail)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PictureWarning)
        paths = write_figures(three, tmp_path)
        content = page(three)
    assert {"third_octaves", "third_octaves_a", "levels"} <= {path.stem for path in paths}
    assert not (tmp_path / "figures" / "spectrum.png").exists()
    assert b'data-name="third_octaves"' in content and b'data-name="spectrum"' not in content
    # The spectrum of the folder, both of the page, and a spectrogram of each run.
    assert len(caught) == 3 + len(three)
    assert all("left out" in str(item.message) for item in caught)


# ---- numbers


def test_curves_in_the_csv_add_up_to_the_levels(three) -> None:
    """The record is limited to the bands drawn; nine digits of a level leave 1e-7 dB."""
    pictures = {drawn.name: table_of(drawn) for drawn in comparing_pictures(three)}
    for name, column, source, level in (
        ("spectrum", "a_weighted_line_level_db", "vibration", "laeq_db"),
        ("third_octaves", "level_db", "vibration", "level_db"),
        ("third_octaves_a", "level_db", "vibration", "laeq_db"),
        ("released_spectrum", "a_weighted_line_level_db", "release", "laeq_db"),
        ("released_third_octaves_a", "level_db", "release", "laeq_db"),
    ):
        for run in three:
            stated = run.stated(source)
            levels = pictures[name][column][pictures[name]["run"] == run.label]
            total = 10 * np.log10(np.nansum(10 ** (levels / 10)))
            assert total == pytest.approx(getattr(stated.sound.levels, level), abs=1e-6)
            if level == "laeq_db":
                assert total == pytest.approx(stated.stated_db, abs=1e-6)
    power = table_of(single("release_power", three[0]))["release_power_w"]
    np.testing.assert_allclose(power, three[0].sound.power, rtol=1e-8)


def test_shares_of_recovery_events_add_up_to_one() -> None:
    events = table_of(single("recovery_events", runs_of("seeds")[0]))
    for name in ("share_of_events", "share_of_release"):
        assert events[name].sum() == pytest.approx(1.0, rel=1e-8)
    assert np.all(events["lower_edge_j"] < events["upper_edge_j"])


def test_levels_and_areas_against_the_load_are_the_numbers_of_the_runs(three) -> None:
    ax = plot.levels(three, "rolling.load_n", Figure().subplots())
    (right,) = [other for other in ax.figure.axes if other is not ax]
    vibrations = [run.vibration for run in three]
    released = [run.released_power for run in three]
    for side, quantities in ((ax, vibrations), (right, released)):
        line = side.get_lines()[0]
        assert line.get_xdata().tolist() == [0.5, 1, 2]
        assert line.get_ydata() == pytest.approx([one.value for one in quantities])
    assert np.ptp(ax.get_ylim()) == pytest.approx(np.ptp(right.get_ylim()))  # decibels per length
    area = plot.contact_areas(three, None, Figure().subplots()).get_lines()[0].get_ydata()
    mean = [run.series["contact_area"][:-1].mean() * 1e12 for run in three]
    assert area == pytest.approx(mean, rel=0.01)  # the numbers weight the ends of the track


def test_vibration_stands_before_released_power_in_a_sweep(three) -> None:
    """Each keeps to its half of the axes, and the table names both with their uncertainty."""
    ax = plot.levels(three, "rolling.load_n", Figure().subplots())
    assert "vibration" in ax.get_ylabel() and "vibration" in ax.get_legend_handles_labels()[1][0]
    (drawn,) = comparing_pictures(three, ["levels"])
    assert words(drawn).index("ibration") < words(drawn).index("released power")
    columns = [*table_of(drawn)]
    assert columns.index("vibration_db") < columns.index("released_power_db")
    assert {"vibration_uncertainty_db", "released_power_uncertainty_db"} < {*columns}


def test_nothing_joins_two_names_and_lines_join_numbers(tmp_path) -> None:
    runs = runs_of("seeds")
    named = [
        replace(run, values={"surface": f"plate {run.values['surface.seed']}"}) for run in runs
    ]
    for draw in (plot.levels, plot.contact_areas):
        ax = draw(named[:3], "surface", Figure().subplots())
        drawn = [line for each in ax.figure.axes for line in each.get_lines()]
        data = [line for line in drawn if len(line.get_xdata()) == 3 and line.get_label()[0] != "_"]
        assert data and {line.get_linestyle() for line in data} == {"None"}
        assert [text.get_text() for text in ax.get_xticklabels()] == [
            "plate 1",
            "plate 2",
            "plate 3",
        ]
    ax = plot.levels(runs, "rolling.load_n", Figure().subplots())
    assert ax.get_lines()[0].get_linestyle() == "-"


def test_figures_8_and_9_of_the_article_are_drawn_from_a_sweep_over_loads_and_seeds(
    tmp_path,
) -> None:
    """Mean and standard deviation of the maximum line are those of the lines of the runs."""
    runs = runs_of("seeds")
    (drawn,) = comparing_pictures(runs, ["max_level_over_load"])
    table = table_of(drawn)
    maxima = []
    for run in runs[:3]:
        rate_hz = len(run.release_power) / run.sound.duration
        frequency_hz, level_db = article_line_level_db(run.release_power, rate_hz, 1.0)
        maxima.append(level_db[(frequency_hz > 17.8) & (frequency_hz < 22387)].max())
    assert table["rolling.load_n"].tolist() == [0.1, 0.2] and table["seeds"].tolist() == [3, 3]
    assert table["maximum_db"][0] == pytest.approx(np.mean(maxima))
    assert table["standard_deviation_db"][0] == pytest.approx(np.std(maxima, ddof=1))
    paths = plot_run(runs, ["max_level_over_load", "spectra_over_load"], out=tmp_path)
    assert [path.name for path in paths] == ["max_level_over_load.png", "spectra_over_load.png"]
    assert "max_level_over_load" in {picture.name for picture in comparing_pictures(runs)}
    # Without seeds it is drawn on request only.
    assert "max_level_over_load" not in {x.name for x in comparing_pictures(runs_of("three"))}
    assert plot_run(runs_of("three"), ["max_level_over_load"], out=tmp_path)


def test_tables_of_third_octaves_hold_the_nominal_beside_the_exact_frequency() -> None:
    three = runs_of("three")
    pictures = [*comparing_pictures(three, ["third_octaves", "third_octaves_a"])]
    pictures += [single("sources", runs_of("flying")[0])]
    pictures += [*comparing_pictures(runs_of("seeds"), ["mean_third_octaves"])]
    for drawn in pictures:
        table = table_of(drawn)
        assert table["band_hz"][:3].tolist() == [20, 25, 31.5], drawn.name
        exact = table["mid_frequency_hz"]
        assert exact[:31] == pytest.approx(MID_HZ, rel=1e-8)


def test_yielded_nodes_have_a_colour_of_their_own(three) -> None:
    """Those at the hardness lie beyond the scale, all others within it."""
    ax = plot.contact_pressure(three[2], Figure().subplots())
    (image,) = ax.get_images()
    pressure = three[2].result.snapshot.pressure.T
    has_yielded = pressure >= three[2].scene.hardness * (1 - 1e-6)
    assert has_yielded.any()
    np.testing.assert_array_equal(image.get_array() > image.get_clim()[1], has_yielded)
    assert any("yielded" in name for name in ax.get_legend_handles_labels()[1])


def test_the_surface_is_shown_at_its_fault_and_the_ball_has_a_surface_of_its_own() -> None:
    scene = read_scene("ball-with-pit")
    fault = scene.sphere.surface.faults[0]
    for draw in (plot.surface, plot.ball_surface):
        ax = draw(scene, Figure().subplots())
        left, right = ax.get_xlim()
        assert left < 1e3 * fault.at_mm[0] < right
        (image,) = ax.get_images()
        assert image.get_array().min() == pytest.approx(-fault.depth_um, rel=0.1)
        assert image.get_clim()[0] <= image.get_array().min()
    with pytest.raises(ValueError, match="no surface"):
        plot.ball_surface(read_scene("quickstart"))


def test_seeds_have_their_mean_and_standard_deviation() -> None:
    runs = runs_of("seeds")
    (drawn,) = comparing_pictures(runs, ["mean_third_octaves"])
    table = table_of(drawn)
    band = BAND_NAMES.index("4000")
    levels = [run.numbers.bands.vibration_a.by_name["4000"] for run in runs[:3]]
    assert table["curve"][band] == "load 0.1 N"
    assert drawn.caption.title.startswith("Mean third octaves of the vibration")
    assert table["mean_a_weighted_level_db"][band] == pytest.approx(np.mean(levels))
    assert table["standard_deviation_db"][band] == pytest.approx(np.std(levels, ddof=1))
    assert not [*comparing_pictures(runs[:2], ["mean_third_octaves"])]  # two seeds have no spread


def test_figures_of_a_table_draw_means_over_the_seeds(tmp_path) -> None:
    runs = runs_of("seeds")
    paths = write_number_figures(runs, ["released_power_db"], ["rolling.load_n"], tmp_path)
    paths += write_number_figures(
        runs, ["released_power_db"], ["rolling.load_n", "surface.seed"], tmp_path
    )
    names = ["mean_third_octaves", "released_power_db_against_rolling.load_n"]
    both = "released_power_db_against_rolling.load_n_surface.seed"
    assert [path.stem for path in paths] == [*names, "mean_third_octaves", both]
    assert all(path.stat().st_size > 5000 for path in paths)


def test_a_number_of_runs_is_drawn_as_its_field_says() -> None:
    """Label, unit and factor are those of the field; levels say of which source they are."""
    runs = runs_of("seeds")
    pressure = sweep_figures.number_of(runs, "contact_max_pressure_pa")
    assert pressure.head == "maximum pressure [GPa]" and pressure.name == "Maximum pressure"
    expected = [run.numbers.contact.max_pressure_pa * 1e-9 for run in runs]
    assert pressure.values == pytest.approx(expected)
    heard = sweep_figures.number_of(runs, "vibration_db")
    assert heard.head == "vibration [dB(A)]"
    assert heard.uncertainties == pytest.approx([run.vibration.uncertainty for run in runs])
    peak = sweep_figures.number_of(runs, "levels_released_power_lz_peak_db")
    assert peak.head == "LZpeak of the released power [dB]"
    assert np.isnan(sweep_figures.number_of(runs, "motion_resonance_hz").values).all()


def test_bars_of_single_runs_are_the_uncertainty_of_the_quantity(three) -> None:
    """Runs of one seed have no standard deviation, so each point has the ± of its run."""
    number = sweep_figures.number_of(three, "vibration_db")
    ax = sweep_figures.number_against(
        sweep_figures.sweep_table(three), number, "rolling.load_n", [], Figure().subplots(), "three"
    )
    (bars,) = (container for container in ax.containers if isinstance(container, ErrorbarContainer))
    segments = bars.lines[2][0].get_segments()
    halves = [(segment[1][1] - segment[0][1]) / 2 for segment in segments]
    assert halves == pytest.approx([run.vibration.uncertainty for run in three])


def test_a_run_with_dynamics_has_four_figures_of_its_vibration() -> None:
    _, fast = runs_of("flying")
    tables = {
        name: table_of(single(name, fast))
        for name in ("sources", "contact_force", "contact_filter", "mobilities")
    }
    sources = tables["sources"]
    force = tables["contact_force"]
    assert np.nanmax(sources["released_power_level_db"]) > np.nanmax(sources["vibration_level_db"])
    assert force["minimum_ratio"].min() == pytest.approx(fast.numbers.motion.force_min_ratio)
    assert force["maximum_ratio"].max() == pytest.approx(fast.numbers.motion.force_max_ratio)
    assert np.nanmin(tables["contact_filter"]["contact_filter_db"]) < -6  # short waves average out
    total = tables["mobilities"]["all_three_in_a_row_s_kg"]
    f = tables["mobilities"]["frequency_hz"]
    assert f[total.argmin()] == pytest.approx(fast.numbers.motion.resonance_hz, rel=0.05)


def test_sources_are_compared_where_the_vibration_is_heard() -> None:
    """The levels at a listener of 0.25 m are not those at the distance of the release."""
    (placed,) = runs_of("placed")
    table = table_of(single("sources", placed))
    band = BAND_NAMES.index("4000")
    bands = placed.numbers.bands
    for column, levels in (
        ("vibration_level_db", bands.vibration),
        ("released_power_level_db", bands.released_power_at_listener),
        ("plate_power_level_db", bands.plate_power),
    ):
        assert table[column][band] == pytest.approx(levels.by_name["4000"])
    assert bands.released_power.by_name["4000"] != bands.released_power_at_listener.by_name["4000"]


# ---- axes and notes


@pytest.mark.parametrize(("scale", "unit"), [(2.0, "W"), (2e-4, "µW"), (2e-8, "nW"), (0.0, "W")])
def test_a_steady_release_power_looks_steady_in_its_own_unit(scale, unit, three) -> None:
    """A ripple of 2e-8, the error of the solver, does not fill the axis."""
    run = sounding(three[0], scale * 2e-5 * (1.0 + 2e-8 * np.sin(np.arange(100))))
    ax = plot.release_power(run, Figure().subplots())
    assert ax.get_ylabel().endswith(f"[{unit}]") and ax.get_xlabel() == "time [ms]"
    low, high = ax.get_ylim()
    assert scale == 0 or high / low > 1.02


def test_compared_runs_have_the_same_axes(three) -> None:
    first = three[0]
    last = three[-1]
    spectrograms = [single("spectrogram", run, three).figure.axes[0] for run in (first, last)]
    assert len({ax.get_images()[0].get_clim() for ax in spectrograms}) == 1
    # The power axis spans the same share of either mean, whatever the units.
    powers = [single("release_power", run, three).figure.axes[0] for run in (first, last)]
    shares = [np.divide(*ax.get_ylim()) for ax in powers]
    assert shares[0] == pytest.approx(shares[1], rel=1e-9)
    maps = [single("contact_pressure", run, three).figure.axes[0] for run in (first, last)]
    assert maps[0].get_images()[0].get_clim() == maps[1].get_images()[0].get_clim()
    assert np.ptp(maps[0].get_xlim()) == pytest.approx(np.ptp(maps[1].get_xlim()), rel=1e-12)
    alone = single("release_power", first).figure.axes[0]
    assert np.divide(*alone.get_ylim()) != pytest.approx(shares[0], rel=1e-3)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [("three", "vibration, estimated"), ("flying", "vibration, computed")],
)
def test_figures_of_levels_say_what_their_level_is(name: str, quantity: str) -> None:
    """They show what plays; the released power beside it has figures of its own."""
    runs = runs_of(name)
    pictures = [*comparing_pictures(runs, ["third_octaves", "third_octaves_a", "spectrum"])]
    pictures.append(single("spectrogram", runs[0], runs))
    assert all(quantity in words(picture).lower() for picture in pictures)
    assert all("of the vibration" in picture.caption.title for picture in pictures)
    released = [*comparing_pictures(runs, ["released_third_octaves_a", "released_spectrum"])]
    assert len(released) == 2
    assert all("of the released power" in picture.caption.title for picture in released)


def test_figures_that_compare_runs_say_what_is_varied(three) -> None:
    for drawn in comparing_pictures(three):
        assert "load 0.5, 1 and 2 N" in words(drawn), drawn.name


def test_other_distances_are_named_as_a_range_and_other_scenes_by_name(three) -> None:
    far = Scene.from_dict(
        three[1].scene.to_dict() | {"sound": {"distance_m": 4}}, three[1].scene.folder
    )
    runs = [three[0], replace(renamed(three[1], "other"), values={})]
    both = {p.name: words(p) for p in comparing_pictures([runs[0], replace(runs[1], scene=far)])}
    assert "at 1 to 4 m" in both["spectrum"] and "levels" not in both  # no swept key in common
    (drawn,) = comparing_pictures(runs, ["spectrum"])
    assert "small, other" in words(drawn)


def test_figures_name_the_place_of_the_listener() -> None:
    """The listener at [20, 30, 250] mm is 252 mm from the contact at [51.6, 37, 0] mm.

    The release beside the vibration has the level of that place, not of sound.distance_m.
    """
    (placed,) = runs_of("placed")
    for name in ("spectrum", "third_octaves"):
        (drawn,) = comparing_pictures([placed], [name])
        assert "at 0.252 m from the contact" in words(drawn)
        assert "1 m" not in words(drawn)
    for name in ("spectrogram", "sources"):
        assert "at 0.252 m from the contact" in words(single(name, placed))
        assert " 1 m" not in words(single(name, placed))


# ---- files


@pytest.mark.slow
def test_the_same_run_gives_the_same_bytes(three) -> None:
    again = [replace(run) for run in three]
    for one, other in zip(comparing_pictures(three), comparing_pictures(again), strict=True):
        for form in ("png", "svg", "csv"):
            assert one.file(form) == other.file(form), one.name
    one, other = (single("spectrogram", runs[0], runs) for runs in (three, again))
    assert one.file("svg") == other.file("svg")


def edges_are_blank(picture: Picture) -> bool:
    """Return whether nothing is drawn on the outermost pixels of a picture."""
    pixels = imread(io.BytesIO(picture.file("png") or b""))[..., :3].min(axis=2)
    edges = pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]
    return all(edge.min() == 1.0 for edge in edges) and pixels.min() < 0.5


def test_long_names_and_twelve_runs_stay_within_the_figure(three) -> None:
    run = renamed(three[0], "W" * 64)
    labels = [f"load {k} N, correlation length {k} µm, Ra 0.{k} µm" for k in range(12)]
    loads = [{"rolling.load_n": k // 4, "surface.seed": k % 4} for k in range(12)]
    many = [
        replace(run, label=label, values=values)
        for label, values in zip(labels, loads, strict=True)
    ]
    singles = (single(name, many[-1], many) for name in ("spectrogram", "release_power", "surface"))
    for picture in [*comparing_pictures(many, ["third_octaves", "spectrum"]), *singles]:
        assert edges_are_blank(picture), picture.name


def test_ten_seconds_stay_small(three) -> None:
    """A picture of 500,000 steps of noise adds less than 150 kB to a page."""
    noise = np.random.default_rng(1).standard_normal(500_000)
    run = sounding(three[0], 1e-9 * (1.0 + 0.1 * noise))
    assert run.sound.duration == pytest.approx(10.0)
    for name in ("release_power", "spectrogram"):
        assert len(single(name, run).file("svg")) < 150e3, name
    for picture in comparing_pictures([run], ["third_octaves", "spectrum"]):
        assert len(picture.file("svg")) < 150e3, picture.name


def test_values_that_are_equal_in_print_have_curves_of_their_own(tmp_path) -> None:
    runs = [
        replace(run, values=run.values | {"rolling.load_n": 0.3 if k % 2 else 0.1 * 3})
        for k, run in enumerate(runs_of("seeds"))
    ]
    (_, drawn) = write_number_figures(runs, ["released_power_db"], ["rolling.load_n"], tmp_path)
    assert drawn.stat().st_size > 5000


def test_a_record_of_two_steps_is_drawn(three) -> None:
    run = sounding(three[0], 1e-9 * np.arange(1.0, 3.0))
    for picture in comparing_pictures([run, three[1]], ["third_octaves", "spectrum"]):
        assert picture.file("svg") and picture.file("csv")
    assert single("spectrogram", run).file("svg") and single("release_power", run).file("svg")


def test_silence_is_drawn() -> None:
    (silent,) = runs_of("smooth")
    pictures = [*comparing_pictures([silent]), single("spectrogram", silent)]
    assert {picture.name for picture in pictures} > {"third_octaves", "spectrum"}
    for picture in pictures:
        assert picture.file("svg")
        assert "no sound" in [text.get_text() for text in picture.figure.axes[0].texts]


def test_a_folder_gets_the_figures_that_compare_runs(three, tmp_path) -> None:
    paths = write_figures(three, tmp_path)
    names = ["third_octaves", "third_octaves_a", "spectrum", "levels", "contact_areas"]
    assert paths == [tmp_path / "figures" / f"{name}.png" for name in names]
    assert all(imread(path).shape[2] >= 3 for path in paths)


def test_figures_on_request_have_one_file_per_run_or_for_all(three, tmp_path) -> None:
    paths = plot_run(three[:2], ["spectrum", "surface"], "svg", tmp_path / "new")
    names = ["spectrum.svg", "surface-load_0.5_N.svg", "surface-load_1_N.svg"]
    assert [path.name for path in paths] == names
    assert all(path.read_bytes().startswith(b"<?xml") for path in paths)
    assert [path.name for path in plot_run(three[0], ["surface"], out=tmp_path)] == ["surface.png"]
    tables = plot_run(three[0], form="csv", out=tmp_path)
    assert {"spectrum.csv", "release_power.csv"} < {path.name for path in tables}


@pytest.mark.parametrize(
    ("names", "form", "words"),
    [
        (["levls"], "png", "nearest: levels"),
        (["levels"], "gif", "png, svg, csv"),
        (["mobilities"], "png", "no such figure"),
        (["surface"], "csv", "no such figure in csv"),
        (["envelope"], "png", "no figure of these runs.*allowed: third_octaves"),
    ],
)
def test_wrong_requests_are_refused_before_a_file_is_written(
    names: list[str], form: str, words: str, three, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=words):
        plot_run(three, names, form, tmp_path / "out")
    assert not (tmp_path / "out").exists()
