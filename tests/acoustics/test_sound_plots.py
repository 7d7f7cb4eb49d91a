"""A plot has units, limits and gaps, and marks levels that are too uncertain."""

import io

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from acoustics import plots
from acoustics.bands import BAND_NAMES, EDGES_HZ, MID_HZ, band_uncertainty_db
from acoustics.plot_style import envelope
from acoustics.spectrum import spectrogram


@pytest.fixture
def ax():
    return Figure(figsize=(8, 4)).subplots()


def drawn(ax):
    """Render a figure, since formatters and layouts fail only then."""
    ax.figure.tight_layout()
    ax.figure.savefig(io.BytesIO(), format="png", dpi=50)
    return ax


def legend(ax):
    return ax.get_legend_handles_labels()[1]


def test_spectrum(ax):
    f = np.arange(0.0, 25000.0, 2.0)
    level = np.full(len(f), 30.0)
    level[500] = 62.0  # 1 kHz
    level[0] = -np.inf
    few = (np.array([100.0, 1000.0, 30000.0]), np.array([10.0, -np.inf, 99.0]))
    curves = [("20 N", plots.Lines.audible(f, level)), ("closed form", plots.Lines.audible(*few))]
    assert plots.spectrum(ax, curves) is ax
    drawn(ax)
    assert ax.get_xscale() == "log" and ax.get_xlim() == pytest.approx((17.78, 22387.2), rel=1e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency [Hz]", "level [dB]")
    assert legend(ax) == ["20 N", "closed form"]
    # Lowest 10 and highest audible 62 dB with 2.5 dB of room, in steps of 5; the 99 dB at 30 kHz
    # cannot be heard.
    assert ax.get_ylim() == (5.0, 65.0)
    ticks = [tick.get_text() for tick in ax.get_xticklabels()]
    assert ticks == ["31.5", "63", "125", "250", "500", "1k", "2k", "4k", "8k", "16k"]


def test_spectrum_mean_is_of_powers(ax):
    # White noise of unit power: 1/12 octaves hold their lines' mean power, 0 dB, where they hold
    # many lines.
    f = np.arange(1.0, 24000.0)
    power = np.random.default_rng(1).exponential(size=len(f))
    lines = plots.Lines.audible(f, 10.0 * np.log10(power))
    plots.spectrum(ax, [("noise", lines)])
    middle, level = np.array(ax.get_lines()[1].get_data())
    np.testing.assert_array_equal([middle, level], lines.mean)
    above = middle > 2000.0  # 115 lines or more: a standard deviation of 0.40 dB at most
    assert above.sum() > 30 and np.max(np.abs(level[above])) < 1.6


def test_third_octaves_have_hollow_marks_on_grey_ground_where_bt_is_below_5(ax):
    levels = dict.fromkeys(BAND_NAMES, 40.0) | {"20": None, "20000": None}
    spread = dict(zip(BAND_NAMES, band_uncertainty_db(0.5).tolist(), strict=True))
    curves = [("5 N, Z", levels, spread), ("20 N, Z", dict.fromkeys(BAND_NAMES, 50.0), spread)]
    plots.third_octaves(ax, curves, 0.5)
    drawn(ax)
    assert ax.get_ylabel() == "sound pressure level [dB re 20 µPa]"
    assert ax.get_xlabel() == "third octave, nominal mid frequency [Hz]"
    ticks = [tick.get_text() for tick in ax.get_xticklabels()]
    assert (
        len(ticks) == 31
        and ticks[:3] == ["20", "25", "31.5"]
        and ticks[-3:] == ["12.5k", "16k", "20k"]
    )
    np.testing.assert_allclose(ax.get_xticks(), MID_HZ)
    assert legend(ax)[:2] == ["5 N, Z", "20 N, Z"] and "B T < 5" in legend(ax)[2]
    # 0.5 s: bands up to 40 Hz have hollow marks, from 50 Hz on full ones, in the curve's colour.
    marks = [line for line in ax.get_lines() if line.get_label().startswith("_")]
    hollow = [line for line in marks if line.get_markerfacecolor() == "white"]
    full = [line for line in marks if line.get_markerfacecolor() == line.get_color()]
    full = [line for line in full if line.get_marker() in ("o", "s")]
    assert len(hollow) == len(full) == 2
    for below, above in zip(hollow, full, strict=True):
        assert below.get_color() == above.get_color()
        np.testing.assert_allclose(below.get_xdata(), MID_HZ[:4])
        np.testing.assert_allclose(above.get_xdata(), MID_HZ[4:])
    (span,) = [patch for patch in ax.patches if "B T" in str(patch.get_label())]
    assert span.get_extents().transformed(ax.transData.inverted()).x1 == pytest.approx(EDGES_HZ[4])


def test_silence_is_drawn_as_an_empty_axis(ax):
    plots.third_octaves(ax, [("Z", dict.fromkeys(BAND_NAMES), dict.fromkeys(BAND_NAMES))], 1.0)
    assert drawn(ax).get_ylim() == (0.0, 70.0)
    assert [text.get_text() for text in ax.texts] == ["no sound"]


def test_error_bars_are_the_uncertainty(ax):
    spread = dict(zip(BAND_NAMES, band_uncertainty_db(0.5).tolist(), strict=True))
    plots.third_octaves(ax, [("Z", dict.fromkeys(BAND_NAMES, 50.0), spread)], 0.5)
    (bars,) = [c for c in ax.collections if isinstance(c, LineCollection)]
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    # From 50 Hz on: 11.5 Hz wide at 0.5 s, 4.34 / sqrt(5.76) dB.
    assert len(ends) == 27 and ends[0] == pytest.approx([50.0 - 1.81, 50.0 + 1.81], abs=0.01)


def test_more_curves_than_three_are_means_and_none_looks_like_another(ax):
    f = np.arange(20.0, 20000.0, 100.0)
    curves = [(f"{n}", plots.Lines.audible(f, np.full(len(f), 30.0 + n))) for n in range(12)]
    plots.spectrum(ax, curves)
    drawn(ax)
    lines = ax.get_lines()
    assert len(lines) == 12 and all(len(line.get_xdata()) < len(f) for line in lines)
    assert len({line.get_color() for line in lines}) == 12
    # In grey, those of the same line style are a third of the way from black to white apart or
    # more: 0.3 of luminance.
    grey = [np.dot([0.299, 0.587, 0.114], to_rgb(line.get_color())) for line in lines]
    for n in range(5):
        assert lines[n].get_linestyle() == lines[n + 7].get_linestyle()
        assert grey[n + 7] - grey[n] > 0.3


def test_envelope_keeps_every_extreme():
    # 200,000 values, one of them up and one down: what is drawn has both, at most two points a
    # column, times rising.
    time = np.arange(200_000) / 2e4
    power = np.ones(200_000)
    power[[123_456, 77]] = 5.0, -3.0
    t, p = envelope(time, power)
    assert len(t) <= 2 * 1500 and np.all(np.diff(t) >= 0.0)
    assert p.max() == 5.0 and p.min() == -3.0
    width = 10.0 / 1500
    assert t[p == 5.0] == pytest.approx(time[123_456], abs=width) and t[p == -3.0] == pytest.approx(
        time[77], abs=width
    )


def test_spectrogram_places_a_tone(ax):
    # A tone of 1 kHz in the second half of half a second; frames of 40 ms.
    time = np.arange(24000) / 48000
    shown = spectrogram(np.where(time > 0.25, np.sin(2e3 * np.pi * time), 0.0), 48000.0)
    plots.spectrogram(ax, shown, 0.5, (20.0, 90.0))
    (bar,) = drawn(ax).child_axes
    (image,) = ax.get_images()
    assert ax.get_xlim() == (0.0, 500.0) and ax.get_xlabel() == "time [ms]"
    assert bar.get_ylabel() == "density level [dB re (20 µPa)²/Hz]" and image.get_clim() == (
        20.0,
        90.0,
    )
    left, right, low, high = image.get_extent()
    rows, columns = shown.level_db.shape
    row = int((np.log10(1000.0) - low) / (high - low) * rows)
    at = [int((ms - left) / (right - left) * columns) for ms in (100.0, 400.0)]
    quiet, loud = np.ma.filled(image.get_array()[row, at], np.nan)
    assert loud > 70.0 and not quiet > loud - 60.0


def test_level_limits():
    assert plots.level_limits([]) == plots.level_limits([None, -np.inf]) == (0.0, 70.0)
    assert plots.level_limits([50.0]) == (45.0, 55.0)
    assert plots.level_limits([61.0, None, -90.0]) == (-5.0, 65.0)  # 70 dB at most
    low, high = plots.level_limits(np.linspace(33.3, 44.4, 7))
    assert low <= 33.3 - 2.5 and high >= 44.4 + 2.5


def test_curves_with_an_order_go_from_dark_to_light(ax) -> None:
    """Each is lighter than the one before, and all stand out from white paper."""
    lines = plots.Lines.audible(np.array([100.0, 1000.0]), np.array([40.0, 60.0]))
    for count in (3, 7, 24):
        plots.spectrum(ax, [(f"{n}", lines) for n in range(count)], ordered=True)
        grey = [np.dot([0.299, 0.587, 0.114], to_rgb(each.get_color())) for each in ax.get_lines()]
        assert np.all(np.diff([g for g in grey if g > 0][-count:]) > 0)
        assert max(grey) < 0.7
        ax.clear()
    two = plots.spectrum(ax, [("a", lines), ("b", lines)], ordered=True)
    assert [each.get_color() for each in two.get_lines()] == list(plots.COLOURS[:2])


def test_third_octaves_mark_levels_less_their_errors_where_they_are_off() -> None:
    levels = dict.fromkeys(BAND_NAMES, 50.0)
    spread = dict.fromkeys(BAND_NAMES, 0.5)
    errors = plots.BandErrors(dict.fromkeys(BAND_NAMES, 0.4) | {"8000": 2.0, "20": None}, spread)
    ax = plots.third_octaves(Figure().subplots(), [("a", levels, spread)], 10.0, errors=[errors])
    (diamonds,) = [line for line in ax.get_lines() if line.get_marker() == "D"]
    assert diamonds.get_xdata() == pytest.approx([MID_HZ[BAND_NAMES.index("8000")]])
    assert diamonds.get_ydata() == pytest.approx([48.0])
    plain = plots.third_octaves(Figure().subplots(), [("a", levels, spread)], 10.0, errors=[None])
    assert plain.get_ylim() == (45, 55)


def test_marks_show_inside_their_diamonds_in_the_colour_of_their_curve() -> None:
    levels = dict.fromkeys(BAND_NAMES, 50.0)
    errors = plots.BandErrors(dict.fromkeys(BAND_NAMES, 1.5), dict.fromkeys(BAND_NAMES, 0.1))
    curves = [(label, levels, levels) for label in "ab"]
    ax = plots.third_octaves(Figure().subplots(), curves, 10.0, errors=[errors, errors])
    diamonds = [line for line in ax.get_lines() if line.get_marker() == "D"]
    marks = [line for line in ax.get_lines() if line.get_marker() in ("o", "s")]
    assert all(line.get_markerfacecolor() == "none" for line in diamonds)
    assert min(x.get_zorder() for x in marks) > max(x.get_zorder() for x in diamonds)
    assert {x.get_color() for x in diamonds} == {x.get_color() for x in marks}


def test_a_spectrogram_masks_what_its_frames_cannot_resolve(ax) -> None:
    """Two periods in a frame of 2.4 ms are 833 Hz; above it the levels are unchanged."""
    noise = np.random.default_rng(1).standard_normal(1440)
    shown = spectrogram(noise, 48000.0)
    plots.spectrogram(ax, shown, 0.03, (20.0, 90.0))
    (image,) = ax.get_images()
    drawn = np.ma.filled(image.get_array().astype(float), np.nan)
    is_below = shown.edges_hz[:-1] < 2.0 / shown.frame_s
    assert is_below.any() and np.isnan(drawn[is_below]).all()
    np.testing.assert_array_equal(drawn[~is_below], shown.level_db[~is_below])
