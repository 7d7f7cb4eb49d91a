"""Slow motion of a run for the page: maps that the page cuts up, powers, and the ball's motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from acoustics.arrays import Array
from rolling.dynamics.smooth_contact import semi_axes
from rolling.marches.observers import SlowMotion
from rolling.report import maps
from rolling.report.maps import Pixels
from rolling.results.run_result import Run
from rolling.sound.wavelengths import weighted_lines
from rolling.surface.scene_surface import scene_surface

LIT = np.tile(np.array((0, 225, 255), np.uint8), (256, 1))  # colour of releases, by their opacity
BRIGHTEST = 0.999  # share of the releases that are less than fully lit
DIMMED, VEIL = 0.7, 225  # brightness of pressures, and their opacity above the surface, of 255
SPREAD = 4.0  # standard deviations of the heights from grey to black and to white
MOST_VALUES = 1500  # of a curve, more than the page has pixels
RATES = (20, 50, 100, 200, 1000, 2000)  # by which the film is slowed
AUDIBLE_RATES = RATES[:3]  # of which one is the first choice
AUDIBLE_HZ = 100.0  # that common loudspeakers play
MOSTLY = 0.5  # share of the sound that is still heard at the first choice


def film_of(run: Run, max_gpa: float) -> dict[str, Any] | None:
    """Return the film of a run for the script of the page; None without a slow motion.

    Parameters
    ----------
    run : Run.
    max_gpa : float, GPa. Pressure of the last colour.

    Returns
    -------
    film : dict. `ground` is a PNG of the surface; `pressure` and `release` hold a PNG with the
        tiles of its maps and their places in a map [cells]; `times` [s], `centres` [cells] and
        `power_uw` belong to the maps, the power is the mean since the map before. `heard` is the
        share of the sound that lies above `AUDIBLE_HZ` by the rate at which the record is slowed,
        and `rate` the first choice.
    """
    slow = run.result.slow_motion
    if slow is None or not slow.pressure.size:
        return None
    times = run.position_time[slow.positions]
    energy = np.concatenate([[0.0], np.cumsum(run.result.series["release_energy"])])
    power = np.concatenate([[0.0], np.diff(energy[slow.positions]) / np.diff(times)])
    pressed = maps.shades(slow.pressure * slow.pressure_unit, max_gpa * 1e9)
    veil = bytes([0]) + bytes([VEIL]) * maps.SHADES
    heard = heard_shares(run)
    return {
        "ground": maps.png(_ground(run, slow)),
        "pressure": _sheet(pressed, _dimmed(), veil),
        "release": _sheet(glow(slow.release), LIT, bytes(range(256))),
        "size": slow.pressure.shape[1:],
        "most_cells": int(np.count_nonzero(slow.pressure, axis=(1, 2)).max()),
        "cell_um": slow.cell * 1e6,
        "hertz_um": [1e6 * axis for axis in semi_axes(run.scene)],
        "centres": _centres(run, slow),
        "times": np.round(times, 8).tolist(),
        "power_uw": _short(power * 1e6),
        "heard": {rate: round(share, 3) for rate, share in heard.items()},
        "rate": max((x for x in AUDIBLE_RATES if heard[x] >= MOSTLY), default=AUDIBLE_RATES[0]),
        "motion": motion_between(run, float(times[0]), float(times[-1])),
    }


def heard_shares(run: Run) -> dict[int, float]:
    """Return the share of the A-weighted power above `AUDIBLE_HZ` by the rate of slowing."""
    if run.sound.levels.laeq_db is None:
        return dict.fromkeys(RATES, 0.0)
    frequency, _, power = weighted_lines(run.sound)
    total = float(power.sum())
    return {rate: float(power[frequency > AUDIBLE_HZ * rate].sum()) / total for rate in RATES}


def _dimmed() -> Pixels:
    """Return the colours of pressures above a surface."""
    return np.asarray(np.rint(DIMMED * maps.palette()), dtype=np.uint8)


def glow(release: NDArray[np.uint16]) -> Pixels:
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


def _ground(run: Run, slow: SlowMotion) -> Pixels:
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

    Without a slow motion it is the map in the middle of the record; None without maps.
    """
    slow = run.result.slow_motion
    if slow is None or not slow.pressure.size:
        return maps.middle_map(run)
    if run.vibration is None:
        loudest = int(np.argmax(slow.release.sum(axis=(1, 2), dtype=np.int64)))
    else:
        motion, times = run.vibration.motion, run.position_time[slow.positions]
        loudest = int(np.argmax(np.interp(times, motion.time_s, motion.force_n)))
    picture = Image.fromarray(_ground(run, slow)).convert("RGB")
    shade = maps.shades(slow.pressure[loudest], float(slow.pressure.max()) or 1.0)
    lit = glow(slow.release)[loudest]
    layers = (_dimmed()[shade], VEIL * (shade > 0)), (LIT[lit], lit)
    for colours, opacity in layers:
        layer, mask = (
            Image.fromarray(maps.upright(x.astype(np.uint8))).resize(
                picture.size, Image.Resampling.NEAREST
            )
            for x in (colours, opacity)
        )
        picture.paste(layer, mask=mask)
    at = 100 * _centres(run, slow)[loudest][0] / slow.pressure.shape[1]
    return {"png": maps.png(np.asarray(picture)), "at": round(at)}


def _sheet(shown: Pixels, colours: Pixels, opacity: bytes) -> dict[str, Any]:
    """Cut each map to its part that is not empty, and arrange the parts in a picture."""
    parts, places = [], []
    for layer in shown:
        picture = maps.upright(layer)
        box = Image.fromarray(picture).getbbox() or (0, 0, 1, 1)  # left, top, right, bottom
        parts.append(picture[box[1] : box[3], box[0] : box[2]])
        places.append(box[:2])
    return {**maps.packed(parts, colours, opacity), "places": places}


def motion_between(run: Run, begin: float, end: float) -> dict[str, Any] | None:
    """Return height [nm] and contact force [N] between two times [s]; None without dynamics.

    The height is that over its mean in the record; `flights` are the times without contact.
    """
    if run.vibration is None:
        return None
    motion = run.vibration.motion
    first, last = np.searchsorted(motion.time_s, (begin, end))
    within = slice(max(0, first - 1), last + 1)
    times, step, force = motion.time_s[within], motion.time_step_s, motion.force_n[within]
    if len(times) < 2:
        return None
    stride = -(-len(times) // MOST_VALUES)
    height = (motion.displacement_m.mean() - motion.displacement_m[within]) * 1e9
    edges = np.clip(np.append(times, times[-1] + step) - step / 2, begin, end)
    turns = np.flatnonzero(np.diff(np.concatenate([[0], force == 0, [0]])))
    flights = edges[turns].round(9).reshape(-1, 2).tolist()
    return {
        "begin": round(float(times[0]), 9),
        "step": stride * step,
        "height_nm": _short(height[::stride]),
        "force_n": _short(force[::stride]),
        "load_n": run.vibration.load,
        "flights": [(start, landing) for start, landing in flights if start < landing],
    }


def _short(values: Array) -> list[float]:
    """Return values with four digits."""
    return [float(f"{value:.4g}") for value in values]
