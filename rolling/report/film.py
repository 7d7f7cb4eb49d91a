"""Slow motion of a run for the page: maps that the page cuts up, powers, and the ball's motion."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, unit_prefix
from rolling.dynamics.smooth_contact import semi_axes
from rolling.figures.picture import Picture
from rolling.figures.settings import own_settings
from rolling.marches.observers import SlowMotion
from rolling.report import charts, maps
from rolling.results.run_result import Run
from rolling.sound.wavelengths import weighted_lines
from rolling.surface.scene_surface import scene_surface

LIT = np.tile(np.array((0, 225, 255), np.uint8), (256, 1))  # colour of releases, by their opacity
BRIGHTEST = 0.999  # share of the releases that are less than fully lit
DIMMED, VEIL = 0.7, 225  # brightness of pressures, and their opacity above the surface, of 255
SPREAD = 4.0  # standard deviations of the heights from grey to black and to white
CURVES_PX = 130  # height of the curves, so that the picture stays in sight above them
RATES = (20, 50, 100, 200, 1000, 2000)  # by which the film is slowed
AUDIBLE_RATES = RATES[:3]  # of which one is the first choice
AUDIBLE_HZ = 100.0  # that common loudspeakers play
MOSTLY = 0.5  # share of the sound that is still heard at the first choice


def film_of(run: Run, max_gpa: float) -> dict[str, Any] | None:
    """Return the film of a run for the script of the page; None without a slow motion of it.

    Parameters
    ----------
    run : Run.
    max_gpa : float, GPa. Pressure of the last colour.

    Returns
    -------
    film : dict. `sheets` hold the surface, the pressures and the releases of its maps as PNG, with
        their places in it and from the centre of the sphere [um]; `times` [s], `said` and
        `flight_s`, the duration of the flight in which it lies, belong to the maps. `heard` is the
        share of the sound that lies above `AUDIBLE_HZ` by the rate at which the record is slowed,
        and `rate` the first choice.
    """
    slow = slow_motion(run)
    if slow is None:
        return None
    times, side = run.position_time[slow.positions], slow.cell * 1e6
    ends = flights(run, times)
    flown = [next((b - a for a, b in ends if a <= time <= b), 0.0) for time in times]
    pressed = maps.shades(slow.pressure * slow.pressure_unit, max_gpa * 1e9)
    centres, (along, across) = _centres(run, slow), slow.pressure.shape[1:]
    pixels = _ground(run, slow)
    cell = side * along / pixels.shape[1]  # the surface has finer ones
    ground = {
        "png": maps.png(pixels),
        "tiles": [(0, 0, *pixels.shape[::-1])] * len(times),
        "boxes": [maps.rounded_box(-x * side, y * side, cell) for x, y in centres],
    }
    veil = bytes([0]) + bytes([VEIL]) * maps.SHADES
    heard = heard_shares(run)
    return {
        "sheets": [
            ground,
            _sheet(pressed, _dimmed(), veil, centres, side),
            _sheet(glow(slow.release), LIT, bytes(range(256)), centres, side),
        ],
        "size_um": [along * side, across * side],
        "hertz_um": [1e6 * axis for axis in semi_axes(run.scene)],
        "times": np.round(times, 8).tolist(),
        "said": _said(run, slow, flown),
        "flight_s": np.round(flown, 9).tolist(),
        "loudest": loudest(run, slow),
        "heard": {rate: round(share, 3) for rate, share in heard.items()},
        "rate": max((x for x in AUDIBLE_RATES if heard[x] >= MOSTLY), default=AUDIBLE_RATES[0]),
    }


def slow_motion(run: Run) -> SlowMotion | None:
    """Return the slow motion of a run; None where none is kept, and for a ball that falls.

    Its maps show the ball as it rolls under its load, which a ball that falls and bounces does not.
    """
    slow = run.result.slow_motion
    if slow is None or not slow.pressure.size or run.scene.rolling.drop_mm is not None:
        return None
    return slow


def heard_shares(run: Run) -> dict[int, float]:
    """Return the share of the A-weighted power above `AUDIBLE_HZ` by the rate of slowing."""
    if run.sound.levels.laeq_db is None:
        return dict.fromkeys(RATES, 0.0)
    frequency, _, power = weighted_lines(run.sound)
    total = float(power.sum())
    return {rate: float(power[frequency > AUDIBLE_HZ * rate].sum()) / total for rate in RATES}


def _dimmed() -> maps.Pixels:
    """Return the colours of pressures above a surface."""
    return np.asarray(np.rint(DIMMED * maps.palette()), dtype=np.uint8)


def glow(release: NDArray[np.uint16]) -> maps.Pixels:
    """Return the opacity of cells that release energy, linear up to nearly the maximum."""
    lit = release[release > 0]
    most = float(np.quantile(lit, BRIGHTEST)) if lit.size else 1.0
    return np.asarray(np.rint(255 * np.minimum(release / most, 1.0)), dtype=np.uint8)


def _centres(run: Run, slow: SlowMotion) -> list[tuple[float, float]]:
    """Return the centre of the sphere in each map [cells]."""
    along = run.result.start + slow.positions * run.result.step
    middle = (run.scene.track.n_across - 1) / 2 * run.scene.spacing
    down = slow.pressure.shape[2] - (middle - slow.across) / slow.cell
    return [(round(float(x), 3), round(down, 3)) for x in (along - slow.along) / slow.cell]


def _ground(run: Run, slow: SlowMotion) -> maps.Pixels:
    """Draw the heights of the part of the plate that the slow motion shows, white is high."""
    spacing, part = run.scene.spacing, scene_surface(run.scene).heights
    nodes = round(slow.cell / spacing)  # along the side of a cell
    for axis, corner in enumerate((slow.along, slow.across)):
        shown = np.arange(slow.pressure.shape[1 + axis] * nodes)
        part = part.take(round(corner / spacing + 0.5) + shown, axis, mode="wrap")
    spread = SPREAD * float(part.std()) or 1.0
    share = np.clip(0.5 + 0.5 * (part - part.mean()) / spread, 0.0, 1.0)
    return maps.upright(np.rint(255 * share).astype(np.uint8))


def still(run: Run) -> dict[str, Any] | None:
    """Draw the loudest moment of a run as `png`, with the contact `at` [percent of the width].

    Without a slow motion it is the map in the middle of the record; None without maps, and for a
    ball that falls.
    """
    if run.scene.rolling.drop_mm is not None:
        return None
    slow = slow_motion(run)
    if slow is None:
        return maps.middle_map(run)
    at = loudest(run, slow)
    picture = Image.fromarray(_ground(run, slow)).convert("RGB")
    shade = maps.shades(slow.pressure[at], float(slow.pressure.max()) or 1.0)
    lit = glow(slow.release)[at]
    layers = (_dimmed()[shade], VEIL * (shade > 0)), (LIT[lit], lit)
    for colours, opacity in layers:
        cells = (Image.fromarray(maps.upright(x.astype(np.uint8))) for x in (colours, opacity))
        layer, mask = (image.resize(picture.size, Image.Resampling.NEAREST) for image in cells)
        picture.paste(layer, mask=mask)
    place = 100 * _centres(run, slow)[at][0] / slow.pressure.shape[1]
    return {"png": maps.png(np.asarray(picture)), "at": round(place)}


def _sheet(
    shown: maps.Pixels,
    colours: maps.Pixels,
    opacity: bytes,
    centres: Sequence[tuple[float, float]],
    side: float,
) -> dict[str, Any]:
    """Cut each map to its part that is not empty, and arrange the parts, cells of a side [um]."""
    parts, boxes = [], []
    for layer, (x, y) in zip(shown, centres, strict=True):
        picture = maps.upright(layer)
        left, top, right, bottom = Image.fromarray(picture).getbbox() or (0, 0, 1, 1)
        parts.append(picture[top:bottom, left:right])
        boxes.append(maps.rounded_box((left - x) * side, (y - top) * side, side))
    return maps.packed(parts, colours, opacity) | {"boxes": boxes}


# ---- power, and motion of the ball


def loudest(run: Run, slow: SlowMotion) -> int:
    """Return the map at which the ball presses hardest, or at which most energy is released."""
    if run.vibration is None:
        return int(np.argmax(slow.release.sum(axis=(1, 2), dtype=np.int64)))
    motion, times = run.vibration.motion, run.position_time[slow.positions]
    return int(np.argmax(np.interp(times, motion.time_s, motion.force_n)))


def _power(run: Run, slow: SlowMotion) -> Array:
    """Return the mean release power [W] since the map before; 0 at the first map."""
    energy = np.concatenate([[0.0], np.cumsum(run.result.series["release_energy"])])
    steps = np.diff(run.position_time[slow.positions])
    return np.concatenate([[0.0], np.diff(energy[slow.positions]) / steps])


def _said(run: Run, slow: SlowMotion, flown: Sequence[float]) -> list[str]:
    """Describe each map: time, release power and, where it is known, the motion of the ball."""
    times, power = run.position_time[slow.positions], _power(run, slow)
    texts = [f"{t * 1e3:.3f} ms, {_quantity(p, 'W')}" for t, p in zip(times, power, strict=True)]
    if run.vibration is None:
        return texts
    motion = run.vibration.motion
    heights = np.interp(times, motion.time_s, motion.displacement_m.mean() - motion.displacement_m)
    forces = np.interp(times, motion.time_s, motion.force_n)
    presses = [
        "flies" if flight > 0 else f"presses with {_quantity(force, 'N')}"
        for flight, force in zip(flown, forces, strict=True)
    ]
    return [
        f"{text}; the ball is {_quantity(height, 'm')} high and {does}"
        for text, height, does in zip(texts, heights, presses, strict=True)
    ]


def _quantity(value: float, unit: str) -> str:
    """Write a value with three digits and the prefix of its unit."""
    factor, prefix = unit_prefix(abs(value))
    return f"{rounded(value / factor, 3)} {prefix}{unit}".replace("-", "\N{MINUS SIGN}")


@own_settings()
def curves(run: Run) -> list[dict[str, Any]]:
    """Draw the release power of a film and, with dynamics, the motion of the ball as charts."""
    slow = slow_motion(run)
    if slow is None:
        return []
    times = run.position_time[slow.positions]
    figures = {"film_power": Figure(), "film_motion": Figure()}
    ax = _axes(figures["film_power"], "Release power", run, times)
    ax.plot(1e3 * times[1:], 1e6 * _power(run, slow)[1:], color=COLOURS[0], linewidth=1)
    ax.set_ylabel("release power [µW]")
    if vibration := run.vibration:
        ax = _axes(figures["film_motion"], "Motion of the ball", run, times)
        right, motion = ax.twinx(), vibration.motion
        first, last = np.searchsorted(motion.time_s, times[[0, -1]])
        shown, mean = slice(max(0, first - 1), last + 1), motion.displacement_m.mean()
        ms, height = 1e3 * motion.time_s[shown], 1e9 * (mean - motion.displacement_m[shown])
        for k, (start, end) in enumerate(flights(run, times)):
            ax.axvspan(1e3 * start, 1e3 * end, color="0.93", label=f"{'_' * (k > 0)}flight")
        ax.plot(ms, height, color=COLOURS[0], linewidth=1, label="height")
        right.plot(ms, motion.force_n[shown], color=COLOURS[1], linewidth=1)
        right.axhline(vibration.load, color=COLOURS[1])
        ax.plot([], [], color=COLOURS[1], label="contact force; dotted: load")
        ax.set_ylabel("height [nm]")
        right.set_ylabel("contact force [N]")
    return [
        charts.chart_of(Picture(name, figure, None)) | {"second": 1e-3, "high": CURVES_PX}
        for name, figure in figures.items()
        if figure.axes
    ]


def _axes(figure: Figure, title: str, run: Run, times: Array) -> Axes:
    """Return axes over the time of a film [ms]."""
    ax = figure.add_subplot(xlim=(1e3 * times[0], 1e3 * times[-1]), xlabel="time [ms]")
    ax.set_label(f"{title}\n{run.label}")
    return ax


def flights(run: Run, times: Array) -> list[tuple[float, float]]:
    """Return begin and end [s] of the flights within the times of a film; none without dynamics."""
    if run.vibration is None:
        return []
    motion = run.vibration.motion
    edges = np.append(motion.time_s, motion.time_s[-1] + motion.time_step_s)
    edges = np.clip(edges - motion.time_step_s / 2, times[0], times[-1])
    turns = np.flatnonzero(np.diff(np.concatenate([[0], motion.force_n == 0, [0]])))
    return [(start, end) for start, end in edges[turns].reshape(-1, 2).tolist() if start < end]
