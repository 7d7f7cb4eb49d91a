"""Oracle: what a reader must find on a plot: units, limits, gaps, and grey where a level says little."""

import io

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from acoustics import plots
from acoustics.bands import BAND_NAMES, EDGES_HZ, MID_HZ


@pytest.fixture
def ax():
    return Figure(figsize=(8, 4)).subplots()


def drawn(ax):
    """Render for real: formatters and layouts fail only here."""
    ax.figure.tight_layout()
    ax.figure.savefig(io.BytesIO(), format="png", dpi=50)
    return ax


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_spectrum(ax):
    f = np.arange(0.0, 25000.0, 2.0)
    level = np.full(len(f), 30.0)
    level[500] = 62.0  # 1 kHz
    level[0] = -np.inf
    few = (np.array([100.0, 1000.0, 30000.0]), np.array([10.0, -np.inf, 99.0]))
    curves = [("20 N, dB re 1 pW/m²", f, level), ("closed form, dB re 1 pW/m²", *few)]
    assert plots.spectrum(ax, curves, "quickstart, T = 0.5 s") is ax
    drawn(ax)
    assert ax.get_xscale() == "log" and ax.get_xlim() == pytest.approx((17.78, 22387.2), rel=1e-3)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == (
        "frequency [Hz]",
        "level [dB]",
        "quickstart, T = 0.5 s",
    )
    assert legend(ax) == ["20 N, dB re 1 pW/m², mean over 1/12 octave", "closed form, dB re 1 pW/m²"]
    # Lowest 10 and highest audible 62 dB with 2.5 dB of room, in steps of 5; the 99 dB at 30 kHz cannot be heard.
    assert ax.get_ylim() == (5.0, 65.0)
    ticks = [tick.get_text() for tick in ax.get_xticklabels()]
    assert ticks == ["31.5", "63", "125", "250", "500", "1k", "2k", "4k", "8k", "16k"]


def test_spectrum_mean_is_of_powers(ax):
    # White noise of unit power: 1/12 octaves hold their lines' mean power, 0 dB, where they hold many lines.
    f = np.arange(1.0, 24000.0)
    power = np.random.default_rng(1).exponential(size=len(f))
    plots.spectrum(ax, [("noise, dB", f, 10.0 * np.log10(power))], "")
    mean = ax.get_lines()[1]
    middle, level = np.array(mean.get_data())
    above = middle > 2000.0  # 115 lines or more: a standard deviation of 0.40 dB at most
    assert above.sum() > 30 and np.max(np.abs(level[above])) < 1.6


def test_an_isolated_line_is_seen(ax):
    # Neighbours at -inf must not swallow it: the line stands on the axis.
    f = np.arange(1.0, 401.0)
    plots.spectrum(ax, [("tone, dB", f, np.where(f == 200.0, 60.0, -np.inf))], "")
    x, y = ax.get_lines()[0].get_data()
    assert np.all(np.isfinite(y)) and y[x == 200.0] == 60.0 and ax.get_ylim()[0] > y[x == 199.0]


def test_third_octaves_grey_where_bt_is_below_5(ax):
    levels = dict.fromkeys(BAND_NAMES, 40.0) | {"20": None, "20000": None}
    plots.third_octaves(ax, [("5 N, Z", levels), ("20 N, Z", [50.0] * 31)], 0.5, "Ra 0.1 µm")
    drawn(ax)
    assert ax.get_ylabel() == "sound pressure level [dB re 20 µPa]"
    assert ax.get_xlabel() == "third octave, nominal mid frequency [Hz]"
    ticks = [tick.get_text() for tick in ax.get_xticklabels()]
    assert len(ticks) == 31 and ticks[:3] == ["20", "25", "31.5"] and ticks[-3:] == ["12.5k", "16k", "20k"]
    np.testing.assert_allclose(ax.get_xticks(), MID_HZ)
    assert legend(ax) == ["5 N, Z", "20 N, Z", "B T < 5: uncertain by 2 dB or more"]
    # 0.5 s: bands up to 40 Hz are grey, from 50 Hz on coloured.
    grey, coloured = [], []
    for line in (line for line in ax.get_lines() if len(line.get_xdata())):
        red, green, blue = to_rgb(line.get_color())
        (grey if red == green == blue else coloured).append(line.get_xdata())
    assert len(grey) == len(coloured) == 2
    for x in grey:
        np.testing.assert_allclose(x, MID_HZ[:4])
    for x in coloured:
        np.testing.assert_allclose(x, MID_HZ[4:])
    (span,) = [patch for patch in ax.patches if "B T" in str(patch.get_label())]
    assert span.get_extents().transformed(ax.transData.inverted()).x1 == pytest.approx(EDGES_HZ[4])


@pytest.mark.parametrize(("duration_s", "labels"), [(10.0, ["Z"]), (1e-4, ["Z", "B T < 5: uncertain by 2 dB or more"])])
def test_third_octaves_all_or_none_grey(ax, duration_s, labels):
    # 20 Hz is 4.6 Hz wide: reliable from 1.08 s on. 20 kHz is 4.6 kHz wide: from 1.08 ms on.
    plots.third_octaves(ax, [("Z", [50.0] * 31)], duration_s, "")
    assert legend(drawn(ax)) == labels


def test_silence_is_drawn_as_an_empty_axis(ax):
    plots.third_octaves(ax, [("Z", dict.fromkeys(BAND_NAMES))], 1.0, "silent")
    assert drawn(ax).get_ylim() == (0.0, 70.0)


@pytest.mark.parametrize(("scale", "unit"), [(2.0, "W"), (2e-4, "µW"), (2e-8, "nW"), (0.0, "W")])
def test_power_in_engineering_units(ax, scale, unit):
    plots.power(ax, np.arange(100) / 200.0, scale * (1.0 + 0.1 * np.sin(np.arange(100))), "20 N")
    drawn(ax)
    assert ax.get_ylabel() == f"release power [{unit}]" and ax.get_xlabel() == "time [ms]"
    assert legend(ax)[0].startswith("mean ") and legend(ax)[0].endswith(f" {unit}")


def test_a_steady_power_looks_steady(ax):
    # Solver noise of 2e-8 must not fill the axis.
    plots.power(ax, np.arange(100) / 5e4, 180e-6 * (1.0 + 2e-8 * np.sin(np.arange(100))), "smooth sphere")
    low, high = drawn(ax).get_ylim()
    assert low < 0.99 * 180.0 and high > 1.01 * 180.0


@pytest.mark.parametrize(("loads", "scale"), [([5, 20, 100], "log"), ([5, 20, 50], "linear"), ([0, 1, 100], "linear")])
def test_level_against_load(ax, loads, scale):
    curves = [("LAeq, dB re 20 µPa", [60.0, None, 70.0]), ("Z, dB re 20 µPa", [62.0, 66.0, 71.0])]
    plots.level_against(ax, loads, curves, "load [N]", "Ra 0.1 µm")
    drawn(ax)
    assert ax.get_xscale() == scale  # logarithmic when the loads span more than a decade
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("load [N]", "level [dB]")
    assert np.isnan(ax.get_lines()[0].get_ydata()[1])  # no sound is a gap
    assert legend(ax) == [label for label, _ in curves]
    if scale == "log":
        assert [tick.get_text() for tick in ax.get_xticklabels()] == ["5", "20", "100"]


def test_points_are_joined_in_order(ax):
    plots.level_against(ax, [100, 5, 20], [("LAeq", [3.0, 1.0, 2.0])], "load [N]", "")
    assert ax.get_lines()[0].get_xydata().tolist() == [[5.0, 1.0], [20.0, 2.0], [100.0, 3.0]]


def test_level_limits():
    assert plots.level_limits([]) == plots.level_limits([None, -np.inf]) == (0.0, 70.0)
    assert plots.level_limits([50.0]) == (45.0, 55.0)
    assert plots.level_limits([61.0, None, -90.0]) == (-5.0, 65.0)  # 70 dB at most
    low, high = plots.level_limits(np.linspace(33.3, 44.4, 7))
    assert low <= 33.3 - 2.5 and high >= 44.4 + 2.5


def test_curves_differ_without_colour():
    # Grey print: neighbouring colours also differ in line style and marker.
    assert len(set(plots.COLOURS)) == len(set(plots.LINE_STYLES)) == len(set(plots.MARKERS)) == 7
