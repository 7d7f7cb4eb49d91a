"""Case of `rolling validate`: slopes of level and contact, as papers print them.

A slope is in decibels per decade, or the exponent of a power. Each law is compared within the range
that its source names. Slopes beyond it, and those of other processes, are shown beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.in_si.scene_surface import heights
from rolling.results.labels import value_at
from rolling.results.run_result import Run
from rolling.sound.radiators import vibration_estimate

SeedSlopes = Array  # a slope for each surface
SlopeRow = tuple[str, str, float, "float | SeedSlopes"]

SEED = "surface.seed"
RA = "surface.roughness_ra_um"
SPEED = "rolling.speed_m_s"


def slope_rows(
    gentle: Sequence[Run], rough: Sequence[Run], smooth: Sequence[Run]
) -> Iterator[SlopeRow]:
    """Yield rule, item, published and own slope.

    Parameters
    ----------
    gentle : sequence of Run
        Runs of an elastic ball over seeds, two small roughnesses and speeds.
    rough : sequence of Run
        Runs of a ball on a yielding plate over seeds and roughnesses, up to a large one.
    smooth : sequence of Run
        Runs of a smooth elastic ball over two loads.
    """
    yield from _over_roughness(_levels(gentle, (SEED, RA, SPEED)), rough)
    yield from _over_speed(gentle)
    yield from _over_load(smooth)


def _levels(runs: Sequence[Run], keys: Sequence[str]) -> pd.Series:
    """Return the levels of runs [dB(A)] by the values of keys."""
    values = [tuple(_value(run, key) for key in keys) for run in runs]
    index = pd.MultiIndex.from_tuples(values, names=keys)
    return pd.Series([run.sound.levels.laeq_db for run in runs], index).astype(float)


def _value(run: Run, key: str) -> float:
    """Return the value of a key in the scene of a run."""
    return float(value_at(run.scene, key))


def db_per_decade(by_value: pd.DataFrame) -> Array:
    """Return the slopes [dB/decade] of levels [dB], of each column over the index."""
    slopes: Array = np.polyfit(np.log10(by_value.index.to_numpy(float)), by_value, 1)[0]
    return slopes


# ---- roughness


def _over_roughness(levels: pd.Series, rough: Sequence[Run]) -> Iterator[SlopeRow]:
    """Yield slopes over the roughness, within the linear range and beyond it."""
    for speed, at_speed in levels.groupby(level=SPEED):
        by_ra = at_speed.droplevel(SPEED).unstack(SEED)
        slopes = db_per_decade(by_ra)
        yield "roughness, rolling", f"{speed:g} m/s, {_ends(by_ra)}", math.nan, slopes
    by_ra = _levels(rough, (SEED, RA)).unstack(SEED)
    for first in range(len(by_ra) - 1):
        decade = by_ra.iloc[first : first + 2]
        yield "roughness, beyond the range", _ends(decade), math.nan, db_per_decade(decade)


def _ends(by_value: pd.DataFrame) -> str:
    """Write the ends of a range of roughness."""
    return f"Ra {by_value.index.min():g} to {by_value.index.max():g} um"


# ---- speed


def _over_speed(gentle: Sequence[Run]) -> Iterator[SlopeRow]:
    """Yield slopes over the speed, with the parts of contact filter and A-weighting."""
    smallest = min(_value(run, RA) for run in gentle)
    runs = [run for run in gentle if _value(run, RA) == smallest]
    table = pd.DataFrame([_levels_of_run(run) for run in runs]).set_index([SPEED, SEED])
    marched = table["marched"].unstack(SEED)
    yield "speed, wheels on rails", _speeds(marched), math.nan, db_per_decade(marched)
    yield "speed, sliding", _speeds(marched), math.nan, db_per_decade(marched)
    for first in range(len(marched) - 1):
        part = marched.iloc[first : first + 2]
        yield "speed, part of the range", _speeds(part), math.nan, db_per_decade(part)
    of_chain = db_per_decade(table["chain"].unstack(SEED))
    of_profile = db_per_decade(table["chain over the profile"].unstack(SEED))
    yield "speed, linear chain", _speeds(marched), math.nan, of_chain
    yield "speed, part of the contact filter", "", math.nan, of_chain - of_profile
    of_force = db_per_decade(table["force"].unstack(SEED))
    yield "speed, contact force", "", math.nan, of_force
    yield "speed, off a line over log v", "", math.nan, _off_a_line_db(marched)


def _levels_of_run(run: Run) -> dict[str, float]:
    """Return levels of a run: as marched, of its linear chain, and of its contact force.

    The chain is moved by the approach, and by the profile under the centre of the contact, which
    has no contact filter.
    """
    scene = run.scene
    assert run.vibration_sound is not None and run.sound.levels.laeq_db is not None
    chain = run.vibration_sound.chain
    approach = run.series["approach"]
    profile = heights(scene)
    across = profile.shape[1]
    centre = profile[:, (across - 1) // 2 : across // 2 + 1].mean(axis=1)
    # To first order a hill lowers the approach by its height.
    along = -np.append(centre, centre[0])
    levels = {SPEED: _value(run, SPEED), SEED: _value(run, SEED)}
    levels["marched"] = run.sound.levels.laeq_db
    for name, moved, step in (
        ("chain", approach, scene.step),
        ("chain over the profile", along, scene.spacing),
    ):
        estimate = vibration_estimate(
            bodies_of(scene),
            listener_of(scene),
            scene.motion,
            approach=moved,
            step=step,
            closed=True,
            stiffness_n_m=chain.stiffness_n_m,
        )
        levels[name] = estimate.laeq_db if estimate.laeq_db is not None else math.nan
    levels["force"] = 10 * math.log10(float(np.mean(np.square(run.vibration_sound.force))))
    return levels


def _speeds(by_speed: pd.DataFrame) -> str:
    """Write the ends of a range of speeds."""
    return f"{by_speed.index.min():g} to {by_speed.index.max():g} m/s"


def _off_a_line_db(by_speed: pd.DataFrame) -> Array:
    """Return the rms distance [dB] of levels from a line over log v, for each seed."""
    log_speeds = np.log10(by_speed.index.to_numpy(float))
    fits = np.polyfit(log_speeds, by_speed, 1)
    lines = log_speeds[:, None] * fits[0] + fits[1]
    return np.asarray(np.sqrt(np.mean(np.square(by_speed.to_numpy() - lines), axis=0)))


# ---- load


def _over_load(smooth: Sequence[Run]) -> Iterator[SlopeRow]:
    """Yield exponents over the load of a smooth elastic ball, by the closed forms of Hertz."""
    runs = sorted(smooth, key=lambda run: run.scene.load)
    loads = np.array([run.scene.load for run in runs])
    item = f"{loads.min():g} to {loads.max():g} N"

    def exponent(values: Sequence[float]) -> float:
        """Return the exponent of values over the load."""
        return float(np.polyfit(np.log(loads), np.log(values), 1)[0])

    release = [float(run.release_power.mean()) for run in runs]
    yield "release over load, smooth", item, math.nan, 10 * exponent(release)
    area = [float(run.series["contact_area"].mean()) for run in runs]
    yield "contact area over load", item, math.nan, exponent(area)
    approach = [float(run.series["approach"].mean()) for run in runs]
    yield "approach over load", item, math.nan, exponent(approach)
    pressure = [float(run.series["max_pressure"].mean()) for run in runs]
    yield "maximum pressure over load", item, math.nan, exponent(pressure)
