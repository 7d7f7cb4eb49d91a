"""Slow motion of a run for the page: maps that the page cuts up, powers, and the ball's motion."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, unit_prefix
from rolling.figures.picture import Caption, Picture
from rolling.figures.settings import own_settings
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.kinds.kind import Still
from rolling.marches.observers import SlowMotion
from rolling.report import maps
from rolling.report.charts import Chart, chart_of
from rolling.results.run_result import Run
from rolling.sound.vibration_sound import Vibration
from rolling.sound.wavelengths import weighted_lines

# Colour of releases, by their opacity. Cyan is grey for people who see no red or no green; a blue
# with less green differs from all pressures and from all greys for them, too.
LIT = np.tile(np.array((0, 150, 255), np.uint8), (256, 1))
BRIGHTEST = 0.999  # share of the releases that are less than fully lit
DIMMED = 0.7  # brightness of pressures above the surface
KEY_COLOURS = 16  # of pressures in the key of the picture
MIDDLE_GREY = 128.0  # of the surface
VEIL = 225  # opacity of pressures above the surface, of 255
SPREAD = 4.0  # standard deviations of the heights from grey to black and to white
CURVES_PX = 130  # height of the curves, so that the picture stays in sight above them
RATES = (20, 50, 100, 200, 1000, 2000)  # by which the film is slowed
AUDIBLE_RATES = RATES[:3]  # of which one is the first choice
AUDIBLE_HZ = 100.0  # that common loudspeakers play
MOSTLY = 0.5  # share of the sound that is still heard at the first choice


def film_of(run: Run, max_gpa: float, ends_at_hardness: bool) -> dict[str, Any] | None:
    """Return the film of a run for the script of the page; None without a slow motion of it.

    Parameters
    ----------
    run : Run.
    max_gpa : float, GPa. Pressure of the last colour.
    ends_at_hardness : bool. Whether that is the hardness, so that the last colour means yielding.

    Returns
    -------
    film : dict. `sheets` hold the surface, the pressures and the releases of its maps as PNG, with
        their places in it and from the centre of the sphere [um]; `times` [s], `said` and
        `flight_s`, the duration of the flight in which it lies, belong to the maps. `released` is
        the energy of a cell that is fully lit, in words. `heard` is the
        share of the sound that lies above `AUDIBLE_HZ` by the rate at which the record is slowed,
        and `rate` the first choice.
    """
    slow = slow_motion(run)
    if slow is None:
        return None
    times = run.position_time[slow.positions]
    flight_times = _flight_times(run, times)
    centres = _centres(run, slow)
    cell_um = slow.cell * 1e6
    cells_along, cells_across = slow.pressure.shape[1:]
    pressures = maps.shades(slow.pressure * slow.pressure_unit, max_gpa * 1e9)
    veil = bytes([0]) + bytes([VEIL]) * maps.SHADES
    shares = audible_shares(run)
    audible = [rate for rate in AUDIBLE_RATES if shares[rate] >= MOSTLY]
    return {
        "sheets": [
            _ground_sheet(run, slow, centres),
            _sheet(pressures, _dimmed(ends_at_hardness), veil, centres, cell_um),
            _sheet(glow(slow.release), LIT, bytes(range(256)), centres, cell_um),
        ],
        "size_um": [cells_along * cell_um, cells_across * cell_um],
        "hertz_um": [1e6 * axis for axis in smooth_contact_of(run.scene).semi_axes_m()],
        "times": np.round(times, 8).tolist(),
        "said": _descriptions(run, slow, flight_times),
        "flight_s": np.round(flight_times, 9).tolist(),
        "loudest": loudest(run, slow),
        "released": f"{most_released_words(slow)} per cell of {rounded(cell_um, 3)} µm",
        "heard": {rate: round(share, 3) for rate, share in shares.items()},
        "rate": max(audible, default=AUDIBLE_RATES[0]),
    }


def _ground_sheet(
    run: Run, slow: SlowMotion, centres: Sequence[tuple[float, float]]
) -> dict[str, Any]:
    """Return the surface below all maps as a sheet, in which each map has the whole picture."""
    pixels = _ground(run, slow)
    height, width = pixels.shape
    cell_um = slow.cell * 1e6
    pixel_um = cell_um * slow.pressure.shape[1] / width  # finer than a cell
    return {
        "png": maps.png(pixels),
        "tiles": [(0, 0, width, height)] * len(centres),
        "boxes": [maps.rounded_box(-x * cell_um, y * cell_um, pixel_um) for x, y in centres],
    }


def slow_motion(run: Run) -> SlowMotion | None:
    """Return the slow motion of a run; None where none is kept, and for a ball that falls.

    Its maps show the ball as it rolls under its load, which a ball that falls and bounces does not.
    """
    slow = run.result.slow_motion
    if slow is None or not slow.pressure.size or not run.scene.keeps_its_load:
        return None
    return slow


def audible_shares(run: Run) -> dict[int, float]:
    """Return the share of the A-weighted power above `AUDIBLE_HZ` by the rate of slowing."""
    sound = run.stated().along_track
    if sound.levels.laeq_db is None:
        return dict.fromkeys(RATES, 0.0)
    frequency, _, power = weighted_lines(sound)
    total = float(power.sum())
    return {rate: float(power[frequency > AUDIBLE_HZ * rate].sum()) / total for rate in RATES}


def _dimmed(ends_at_hardness: bool = False) -> maps.Pixels:
    """Return the colours of pressures above a surface."""
    return np.asarray(np.rint(DIMMED * maps.palette(ends_at_hardness)), dtype=np.uint8)


def glow(release: NDArray[np.uint16]) -> maps.Pixels:
    """Return the opacity of cells that release energy, linear up to nearly the maximum."""
    return np.asarray(np.rint(255 * np.minimum(release / _fully_lit(release), 1.0)), dtype=np.uint8)


def _fully_lit(release: NDArray[np.uint16]) -> float:
    """Return the release of a cell that is fully lit, in the unit of the maps; 1 without any."""
    released = release[release > 0]
    return float(np.quantile(released, BRIGHTEST)) if released.size else 1.0


def most_released_words(slow: SlowMotion) -> str:
    """Write the energy since the map before that fully lights a cell."""
    return _quantity(slow.release_unit * _fully_lit(slow.release), "J")


class ContactKey(NamedTuple):
    """The key of the pictures of a contact, for the page.

    pressures : list of str. Colours of rising pressures over a surface, of CSS.
    bare : list of str. Those of a picture without the surface.
    yielded, bare_yielded : str. Colours of a cell that has yielded; empty where no colour means it.
    lit : str. Colour of a cell that releases the most energy.
    most : str. The pressure of the last colour, in words.
    """

    pressures: list[str]
    bare: list[str]
    yielded: str
    bare_yielded: str
    lit: str
    most: str


def contact_key(scale: Mapping[str, Any]) -> ContactKey:
    """Return the key of pictures of contacts in the scale that they share, of `maps.map_scale`."""
    ends_at_hardness = scale["hardness"]
    veil = VEIL / 255
    bare = maps.palette(ends_at_hardness)[1:]
    veiled = np.rint(veil * _dimmed(ends_at_hardness)[1:] + (1 - veil) * MIDDLE_GREY)
    shown = np.linspace(0, maps.SHADES - 2, KEY_COLOURS).astype(int)
    return ContactKey(
        pressures=[maps.css(colour) for colour in veiled[shown]],
        bare=[maps.css(colour) for colour in bare[shown]],
        yielded=maps.css(veiled[-1]) if ends_at_hardness else "",
        bare_yielded=maps.css(bare[-1]) if ends_at_hardness else "",
        lit=maps.css(LIT[-1]),
        most=f"{rounded(scale['max_gpa'], 3)} GPa{', yielded' if ends_at_hardness else ''}",
    )


def _centres(run: Run, slow: SlowMotion) -> list[tuple[float, float]]:
    """Return the centre of the sphere in each map [cells]."""
    along = run.result.start + slow.positions * run.result.step
    middle = (run.scene.track.n_across - 1) / 2 * run.scene.spacing
    y = slow.pressure.shape[2] - (middle - slow.across) / slow.cell
    return [(round(float(x), 3), round(y, 3)) for x in (along - slow.along) / slow.cell]


def _ground(run: Run, slow: SlowMotion) -> maps.Pixels:
    """Draw the heights of the part of the plate that the slow motion shows, white is high."""
    spacing = run.scene.spacing
    heights = scene_surface(run.scene).heights
    nodes = round(slow.cell / spacing)  # along the side of a cell
    for axis, corner in enumerate((slow.along, slow.across)):
        first = round(corner / spacing + 0.5)
        shown = np.arange(slow.pressure.shape[1 + axis] * nodes)
        heights = heights.take(first + shown, axis, mode="wrap")
    spread = SPREAD * float(heights.std()) or 1.0
    share = np.clip(0.5 + 0.5 * (heights - heights.mean()) / spread, 0.0, 1.0)
    return maps.upright(np.rint(255 * share).astype(np.uint8))


def still(run: Run) -> Still | None:
    """Draw the loudest moment of a run, which is looked at where the contact is.

    Without a slow motion it is the map in the middle of the record; None without maps.
    """
    words = f"The contact of {run.label} seen from above"
    slow = slow_motion(run)
    if slow is None:
        drawn = maps.middle_map(run)
        return None if drawn is None else Still(drawn["png"], words, drawn["at"])
    number = loudest(run, slow)
    picture = Image.fromarray(_ground(run, slow)).convert("RGB")
    shades = maps.shades(slow.pressure[number], float(slow.pressure.max()) or 1.0)
    lit = glow(slow.release)[number]
    _paste(picture, colours=_dimmed()[shades], opacity=VEIL * (shades > 0))
    _paste(picture, colours=LIT[lit], opacity=lit)
    middle, _ = _centres(run, slow)[number]
    at = round(100 * middle / slow.pressure.shape[1])
    return Still(maps.png(np.asarray(picture)), words, at)


def _paste(picture: Image.Image, *, colours: NDArray[Any], opacity: NDArray[Any]) -> None:
    """Paste cells (along, across) over a whole picture."""
    layer = Image.fromarray(maps.upright(colours.astype(np.uint8)))
    mask = Image.fromarray(maps.upright(opacity.astype(np.uint8)))
    nearest = Image.Resampling.NEAREST
    picture.paste(layer.resize(picture.size, nearest), mask=mask.resize(picture.size, nearest))


def _sheet(
    shown: maps.Pixels,
    colours: maps.Pixels,
    opacity: bytes,
    centres: Sequence[tuple[float, float]],
    cell_um: float,
) -> dict[str, Any]:
    """Cut each map to its part that is not empty, and arrange the parts in one picture."""
    parts = []
    boxes = []
    for layer, (x, y) in zip(shown, centres, strict=True):
        picture = maps.upright(layer)
        left, top, right, bottom = Image.fromarray(picture).getbbox() or (0, 0, 1, 1)
        parts.append(picture[top:bottom, left:right])
        boxes.append(maps.rounded_box((left - x) * cell_um, (y - top) * cell_um, cell_um))
    return maps.packed(parts, colours, opacity) | {"boxes": boxes}


# ---- power, and motion of the ball


def loudest(run: Run, slow: SlowMotion) -> int:
    """Return the map at which the ball presses hardest, or at which most energy is released."""
    if run.vibration_sound is None:
        return int(np.argmax(slow.release.sum(axis=(1, 2), dtype=np.int64)))
    motion = run.vibration_sound.motion
    times = run.position_time[slow.positions]
    return int(np.argmax(np.interp(times, motion.time_s, motion.force_n)))


def _power(run: Run, slow: SlowMotion) -> Array:
    """Return the mean release power [W] since the map before; 0 at the first map."""
    energy = np.concatenate([[0.0], np.cumsum(run.result.series["release_energy"])])
    steps = np.diff(run.position_time[slow.positions])
    return np.concatenate([[0.0], np.diff(energy[slow.positions]) / steps])


def _descriptions(run: Run, slow: SlowMotion, flight_times: Sequence[float]) -> list[str]:
    """Describe each map: time, release power and, where it is known, the motion of the ball."""
    times = run.position_time[slow.positions]
    texts = [
        f"{time * 1e3:.3f} ms, {_quantity(power, 'W')}"
        for time, power in zip(times, _power(run, slow), strict=True)
    ]
    if run.vibration_sound is None:
        return texts
    motion = run.vibration_sound.motion
    heights = np.interp(times, motion.time_s, motion.displacement_m.mean() - motion.displacement_m)
    forces = np.interp(times, motion.time_s, motion.force_n)
    for k, flight_time in enumerate(flight_times):
        verb = "flies" if flight_time > 0 else f"presses with {_quantity(forces[k], 'N')}"
        texts[k] += f"; the ball is {_quantity(heights[k], 'm')} high and {verb}"
    return texts


def _quantity(value: float, unit: str) -> str:
    """Write a value with three digits and the prefix of its unit."""
    factor, prefix = unit_prefix(abs(value))
    return f"{rounded(value / factor, 3)} {prefix}{unit}".replace("-", "\N{MINUS SIGN}")


@own_settings()
def curves(run: Run) -> list[Chart]:
    """Draw the release power of a film and, with dynamics, the motion of the ball as charts."""
    slow = slow_motion(run)
    if slow is None:
        return []
    charts = [_power_chart(run, slow)]
    if run.vibration_sound is not None:
        charts.append(_motion_chart(run, slow, run.vibration_sound))
    return charts


def _power_chart(run: Run, slow: SlowMotion) -> Chart:
    """Draw the release power of a film."""
    times = run.position_time[slow.positions]
    ax = _axes_over_time(times)
    ax.plot(1e3 * times[1:], 1e6 * _power(run, slow)[1:], color=COLOURS[0], linewidth=1)
    ax.set_ylabel("released power [µW]")
    return _chart("film_power", ax, Caption("Released power in slow motion", run.label))


def _motion_chart(run: Run, slow: SlowMotion, vibration: Vibration) -> Chart:
    """Draw height and contact force of the ball in a film, and its flights."""
    times = run.position_time[slow.positions]
    motion = vibration.motion
    first, last = np.searchsorted(motion.time_s, times[[0, -1]])
    shown = slice(max(0, first - 1), last + 1)
    time_ms = 1e3 * motion.time_s[shown]
    height_nm = 1e9 * (motion.displacement_m.mean() - motion.displacement_m[shown])
    ax = _axes_over_time(times)
    right = ax.twinx()
    for k, (start, end) in enumerate(flights(run, times)):
        label = "flight" if k == 0 else "_flight"  # one of them is in the legend
        ax.axvspan(1e3 * start, 1e3 * end, color="0.93", label=label)
    ax.plot(time_ms, height_nm, color=COLOURS[0], linewidth=1, label="height")
    right.plot(time_ms, motion.force_n[shown], color=COLOURS[1], linewidth=1)
    right.axhline(vibration.load, color=COLOURS[1])
    ax.plot([], [], color=COLOURS[1], label="contact force; straight line: load")
    ax.set_ylabel("height [nm]")
    right.set_ylabel("contact force [N]")
    return _chart("film_motion", ax, Caption("Motion of the ball", run.label))


def _axes_over_time(times: Array) -> Axes:
    """Return axes over the time of a film [ms], in a figure of their own."""
    return Figure().add_subplot(xlim=(1e3 * times[0], 1e3 * times[-1]), xlabel="time [ms]")


def _chart(name: str, ax: Axes, caption: Caption) -> Chart:
    """Return axes as a chart beside a film."""
    figure = ax.figure
    assert isinstance(figure, Figure)
    chart = chart_of(Picture(name, figure, table=None, caption=caption))
    return chart | {"second": 1e-3, "high": CURVES_PX}


def _flight_times(run: Run, times: Array) -> list[float]:
    """Return the duration [s] of the flight in which each time of a film lies, or 0."""
    durations = []
    spans = flights(run, times)
    for time in times:
        inside = [end - start for start, end in spans if start <= time <= end]
        durations.append(inside[0] if inside else 0.0)
    return durations


def flights(run: Run, times: Array) -> list[tuple[float, float]]:
    """Return begin and end [s] of the flights within the times of a film; none without dynamics."""
    if run.vibration_sound is None:
        return []
    motion = run.vibration_sound.motion
    edges = np.append(motion.time_s, motion.time_s[-1] + motion.time_step_s)
    edges = np.clip(edges - motion.time_step_s / 2, times[0], times[-1])
    is_free = np.concatenate([[False], motion.force_n == 0, [False]])
    changes = np.flatnonzero(is_free[1:] != is_free[:-1])
    return [(start, end) for start, end in edges[changes].reshape(-1, 2).tolist() if start < end]
