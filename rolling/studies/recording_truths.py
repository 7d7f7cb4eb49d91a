"""Case of `rolling validate`: a 6205 in a motor beside public recordings, healthy and with pits.

Only figures of the recordings are here. Clearance, loads, housing and surfaces are fitted on the
healthy record alone, within bounds that stand below. Faults are then predicted.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from acoustics import (
    VELOCITY_BANDS_HZ,
    band_pulses,
    squared_envelope_spectrum,
    velocity_bands,
    velocity_of,
)
from acoustics.arrays import Array
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.contact.solver import ContactError
from rolling.run.solving import simulate_runs
from rolling.scene.bearing_scene import BearingScene

# What is tried: clearances of a normal bearing, 5 to 20 um by ISO 5753-1, of which usual fits have
# taken a part, and loads of the rotor of a small motor, its coupling and its spring.
CLEARANCES_UM = (2.0, 4.0, 8.0)
AXIAL_LOADS_N = (25.0, 50.0, 100.0)
RADIAL_LOADS_N = (100.0, 200.0, 400.0)
_RANDOM = {
    "kind": "gaussian",
    "roughness_ra_um": 0.02,
    "correlation_length_um": 60,
    "correlation_length_across_um": 10,
}
# Surfaces are not known either, so the healthy record chooses those of the scene or others.
SURFACES: dict[str, dict[str, Any]] = {
    "superfinished": {},
    "superfinished, isotropic": {
        "bearing.surfaces.inner.wave_crests": "isotropic",
        "bearing.surfaces.outer.wave_crests": "isotropic",
    },
    "without waves": {
        "bearing.surfaces.balls": {"kind": "graded", "grade": "G10", "seed": 1},
        "bearing.surfaces.inner": _RANDOM | {"seed": 2},
        "bearing.surfaces.outer": _RANDOM | {"seed": 3},
    },
}
FIT_S = 0.4  # of a motion in the fit
ANGLE_DEG = (7.2, 10.2)  # bounds of the angle at which balls roll, by the lines of the recordings
HOUSING_KG = (1.0, 30.0)  # bounds of the mass that moves with the outer ring
_MASSES = 30  # within these bounds that are tried
END_HZ = {"": VELOCITY_BANDS_HZ["high"][1], ", second record": 5500.0}  # of both kinds of records
PIT_DEPTH_UM = 280.0  # 0.011 inches, as the source prints it
PITS_UM = (180.0, 360.0, 530.0)
PIT_AT_MM = {"inner": [20.0, 0.0], "outer": [0.5, 0.0]}  # in the middle of the load zone, outer
LINES = {"inner": "ball_pass_inner_hz", "outer": "ball_pass_outer_hz"}
HEALTHY = "healthy"
_UM_S = 1e6


class Reading(NamedTuple):
    """What is read from an acceleration.

    um_s : dict, um/s. Velocity by band.
    kurtosis : float. Of the whole band.
    envelope : NarrowSpectrum. Of the high band.
    """

    um_s: dict[str, float]
    kurtosis: float
    envelope: Any


def recording_rows(
    scene: BearingScene, figures: pd.DataFrame
) -> Iterator[tuple[str, str, float, float]]:
    """Yield rule, item, published and own number.

    Parameters
    ----------
    scene : BearingScene
        The healthy bearing.
    figures : DataFrame
        Figures of the recordings: quantity, item and value.
    """
    published = {(row.quantity, row.item): float(row.value) for row in figures.itertuples()}
    bands_um_s = [published["healthy band", _item(band)] for band in VELOCITY_BANDS_HZ]
    fits = []
    for words, surfaces in SURFACES.items():
        fits.append(fitted(scene.with_(surfaces), bands_um_s))
        yield "rms miss of the healthy bands", words, math.nan, fits[-1].miss_db
    fit = min(fits, key=lambda fit: fit.miss_db)
    bearing = fit.scene.bearing
    yield "fitted radial clearance", "", math.nan, bearing.radial_clearance_um or 0.0
    yield "fitted axial load", "", math.nan, bearing.axial_load_n
    yield "fitted radial load", "", math.nan, bearing.radial_load_n
    yield "fitted mass of the housing", "", math.nan, fit.housing_kg
    own = dict(_own_figures(fit))
    for (quantity, item), value in published.items():
        if quantity == "healthy band":
            yield quantity, item, _decibels(value), _decibels(own[quantity, item])
        else:
            yield quantity, item, value, own[quantity, item]
    for item, ring_item in _both_rings(published):
        order = published["rise", item] - published["rise", ring_item]
        yield (
            "outer over inner",
            item.removeprefix("outer "),
            order,
            own["rise", item] - own["rise", ring_item],
        )


def _both_rings(published: Mapping[tuple[str, str], float]) -> Iterator[tuple[str, str]]:
    """Yield the rises of the high band by a pit of the outer ring, and of its like in the inner."""
    for quantity, item in published:
        if quantity == "rise" and item.startswith("outer") and "high" in item:
            yield item, item.replace("outer", "inner", 1)


def _item(band: str) -> str:
    """Return a band in words."""
    low, high = VELOCITY_BANDS_HZ[band]
    return f"{low:.0f} to {high:.0f} Hz"


def _decibels(um_s: float) -> float:
    """Return the level of a velocity [dB re 1 um/s]."""
    return 20 * math.log10(um_s)


# ---- the healthy record


class Fit(NamedTuple):
    """What the healthy record decides, and how far off it is.

    scene : BearingScene. With surfaces, clearance and loads.
    housing_kg : float. Mass of the housing.
    miss_db : float, dB. Root mean square over the three bands.
    """

    scene: BearingScene
    housing_kg: float
    miss_db: float


def fitted(scene: BearingScene, bands_um_s: list[float]) -> Fit:
    """Fit clearance, loads and housing by the least rms of the decibels in the three bands.

    Oil parts the surfaces of the scene, so that nothing is marched.
    """
    fits = []
    for loaded in _within_bounds(scene):
        (run,) = _runs(loaded.with_({"sound.duration_s": FIT_S, "sound.listen_s": FIT_S}))
        for mass in np.geomspace(*HOUSING_KG, _MASSES).tolist():
            own = _bands_um_s(in_seat(run, mass), run.record.rate_hz, VELOCITY_BANDS_HZ)
            misses = [
                _decibels(value) - _decibels(wanted)
                for value, wanted in zip(own.values(), bands_um_s, strict=True)
            ]
            miss = float(np.sqrt(np.mean(np.square(misses))))
            fits.append(Fit(scene=loaded, housing_kg=mass, miss_db=miss))
    return min(fits, key=lambda fit: fit.miss_db)


def _within_bounds(scene: BearingScene) -> Iterator[BearingScene]:
    """Yield the scene with the clearances and loads whose balls roll as the lines have it."""
    for clearance, axial, radial in itertools.product(CLEARANCES_UM, AXIAL_LOADS_N, RADIAL_LOADS_N):
        loaded = scene.with_(
            {
                "bearing.radial_clearance_um": clearance,
                "bearing.axial_load_n": axial,
                "bearing.radial_load_n": radial,
            }
        )
        if ANGLE_DEG[0] <= math.degrees(loaded.model.rolling_angle) <= ANGLE_DEG[1]:
            yield loaded


def _runs(scene: BearingScene) -> list[Any]:
    """Simulate all runs of a scene in memory."""
    runs, failures = simulate_runs(scene, 0, False)
    if failures:
        raise ContactError("; ".join(failures.values()))
    return list(runs.values())


# ---- what a sensor on the housing reads


def in_seat(run: Any, housing_kg: float) -> Array:
    """Return the acceleration along the radial load of a ring that shakes a rigid mass [m/s2].

    The free ring is a source with its velocity v and its mobility Y_r on its balls. A mass m takes
    it down to v / (1 + i omega m Y_r).
    """
    acceleration = run.record.seen_acceleration_m_s2[:, 0]
    count = len(acceleration)
    angular = 2 * np.pi * np.fft.rfftfreq(count, 1 / run.record.rate_hz)
    lines = np.fft.rfft(acceleration - acceleration.mean())
    lines[1:] /= 1 + 1j * angular[1:] * housing_kg * _mobility(run.model, angular[1:])
    return np.fft.irfft(lines, count)


def _mobility(model: BearingModel, angular: Array) -> Any:
    """Return the mobility of the free ring along the radial load [m/(N s)]."""
    return linear_ring(model).mobility(angular / (2 * np.pi))[:, 0, 0]


def read(acceleration_m_s2: Array, rate_hz: float, end_hz: float) -> Reading:
    """Read bands, kurtosis and envelope of an acceleration up to a frequency."""
    bands_hz = {name: (low, min(high, end_hz)) for name, (low, high) in VELOCITY_BANDS_HZ.items()}
    whole = {"all": (bands_hz["low"][0], end_hz)}
    kurtosis = band_pulses(acceleration_m_s2, rate_hz, whole)["all"].kurtosis
    return Reading(
        um_s=_bands_um_s(acceleration_m_s2, rate_hz, bands_hz),
        kurtosis=math.nan if kurtosis is None else kurtosis,
        envelope=squared_envelope_spectrum(acceleration_m_s2, rate_hz, bands_hz["high"]),
    )


def _bands_um_s(
    acceleration_m_s2: Array, rate_hz: float, bands_hz: Mapping[str, tuple[float, float]]
) -> dict[str, float]:
    """Return the velocities of an acceleration in bands [um/s]."""
    bands = velocity_bands(velocity_of(acceleration_m_s2, rate_hz), rate_hz, bands_hz)
    return {name: _UM_S * rms for name, rms in bands.rms_m_s.items()}


# ---- faults


def _with_pits(scene: BearingScene) -> dict[str, BearingScene]:
    """Return the scene with each pit, by ring and size in words."""
    scenes = {}
    for ring, size_um in itertools.product(LINES, PITS_UM):
        pit = {
            "kind": "pit",
            "at_mm": PIT_AT_MM[ring],
            "size_um": size_um,
            "depth_um": PIT_DEPTH_UM,
        }
        scenes[f"{ring} {size_um / 1000:g} mm"] = scene.with_(
            {f"bearing.surfaces.{ring}.faults": [pit]}
        )
    return scenes


def _own_figures(fit: Fit) -> Iterator[tuple[tuple[str, str], float]]:
    """Yield the figures of our runs by quantity and item."""
    (unharmed,) = _runs(fit.scene)
    rate_hz = unharmed.record.rate_hz
    healthy = {
        record: read(in_seat(unharmed, fit.housing_kg), rate_hz, end_hz)
        for record, end_hz in END_HZ.items()
    }
    for band, um_s in healthy[""].um_s.items():
        yield ("healthy band", _item(band)), um_s
    yield ("kurtosis", HEALTHY), healthy[""].kurtosis
    for ring, name in LINES.items():
        yield ("frequency of the line", ring), getattr(unharmed.kinematics, name)
    for words, scene in _with_pits(fit.scene).items():
        (run,) = _runs(scene)
        line_hz = getattr(run.kinematics, LINES[words.split()[0]])
        for record, end_hz in END_HZ.items():
            faulty = read(in_seat(run, fit.housing_kg), rate_hz, end_hz)
            for band, um_s in faulty.um_s.items():
                rise = _decibels(um_s) - _decibels(healthy[record].um_s[band])
                yield ("rise", f"{words}, {band}{record}"), rise
            yield ("kurtosis", f"{words}{record}"), faulty.kurtosis
            height = faulty.envelope.read_line(line_hz).height
            yield ("height of the line", f"{words}{record}"), height or 0.0
