"""Slow motion of a run for the page: maps that the page cuts up, powers, and the ball's motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from acoustics.arrays import Array
from rolling.figures.vibration import hertz_radius
from rolling.marches.observers import SlowMotion
from rolling.report import maps
from rolling.report.maps import Pixels
from rolling.results.run_result import Run
from rolling.sound.wavelengths import weighted_lines
from rolling.surface.scene_surface import scene_surface

GLOW = (0, 225, 255)  # colour of cells that release energy
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
    dimmed = np.rint(DIMMED * maps.palette()).astype(np.uint8)
    veil = bytes([0]) + bytes([VEIL]) * maps.SHADES
    lit = np.tile(np.array(GLOW, np.uint8), (256, 1))
    heard = heard_shares(run)
    return {
        "ground": maps.png(_ground(run, slow)),
        "pressure": _sheet(pressed, dimmed, veil),
        "release": _sheet(glow(slow.release), lit, bytes(range(256))),
        "size": slow.pressure.shape[1:],
        "most_cells": int(np.count_nonzero(slow.pressure, axis=(1, 2)).max()),
        "cell_um": slow.cell * 1e6,
        "hertz_um": 1e6 * hertz_radius(run),
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
    heights, spacing = scene_surface(run.scene).heights, run.scene.spacing
    nodes = round(slow.cell / spacing)  # along the side of a cell
    corner, cells = (slow.along, slow.across), slow.pressure.shape[1:]
    places = [
        (round(begin / spacing + 0.5) + np.arange(count * nodes)) % period
        for begin, count, period in zip(corner, cells, heights.shape, strict=True)
    ]
    part = np.asarray(heights[np.ix_(*places)])
    spread = SPREAD * float(part.std()) or 1.0
    share = np.clip(0.5 + 0.5 * (part - part.mean()) / spread, 0.0, 1.0)
    return np.asarray(np.rint(255 * share).astype(np.uint8).T[::-1])


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
    ground = np.repeat(_ground(run, slow)[:, :, None].astype(float), 3, axis=2)
    nodes = ground.shape[0] // slow.pressure.shape[2]
    shade = maps.shades(slow.pressure[loudest], float(slow.pressure.max()) or 1.0)
    lit = glow(slow.release)[loudest]
    layers = (
        (DIMMED * maps.palette()[shade], np.where(shade > 0, VEIL, 0)),
        (np.broadcast_to(GLOW, (*lit.shape, 3)), lit),
    )
    for colour, opacity in layers:
        share = opacity[:, :, None] / 255
        above, share = (
            np.repeat(np.repeat(x.swapaxes(0, 1)[::-1], nodes, 0), nodes, 1)
            for x in (colour, share)
        )
        ground += share * (above - ground)
    at = 100 * _centres(run, slow)[loudest][0] / slow.pressure.shape[1]
    return {"png": maps.png(np.rint(ground).astype(np.uint8)), "at": round(at)}


def _sheet(shown: Pixels, colours: Pixels, opacity: bytes) -> dict[str, Any]:
    """Cut each map to its part that is not empty, and arrange the parts in a picture."""
    parts, places = [], []
    for layer in shown:
        turned = layer.T[::-1]  # rows of a picture go down, the plate's second axis goes up
        box = Image.fromarray(turned).getbbox() or (0, 0, 1, 1)  # left, top, right, bottom
        parts.append(turned[box[1] : box[3], box[0] : box[2]])
        places.append(box[:2])
    pixels, tiles = maps.packed(parts)
    return {"png": maps.png(pixels, colours, opacity), "tiles": tiles, "places": places}


def motion_between(run: Run, begin: float, end: float) -> dict[str, Any] | None:
    """Return height [nm] and contact force [N] between two times [s]; None without dynamics.

    The height is that over its mean in the record; `flights` are the times without contact.
    """
    if run.vibration is None:
        return None
    motion = run.vibration.motion
    first, last = np.searchsorted(motion.time_s, (begin, end))
    first, last = max(0, int(first) - 1), min(len(motion.time_s), int(last) + 1)
    if last - first < 2:
        return None
    stride = -(-(last - first) // MOST_VALUES)
    height = (motion.displacement_m.mean() - motion.displacement_m[first:last:stride]) * 1e9
    force = motion.force_n[first:last]
    edges = motion.time_s[first] + (np.arange(last - first + 1) - 0.5) * motion.time_step_s
    turns = np.flatnonzero(np.diff(np.concatenate([[0], (force == 0).astype(int), [0]])))
    return {
        "begin": round(float(motion.time_s[first]), 9),
        "step": stride * motion.time_step_s,
        "height_nm": _short(height),
        "force_n": _short(force[::stride]),
        "load_n": run.vibration.load,
        "flights": [
            (round(max(begin, float(edges[a])), 9), round(min(end, float(edges[b])), 9))
            for a, b in zip(turns[::2], turns[1::2], strict=True)
            if edges[b] > begin and edges[a] < end
        ],
    }


def _short(values: Array) -> list[float]:
    """Return values with four digits."""
    return [float(f"{value:.4g}") for value in values]
