"""Cases of `rolling validate`: parameters of surfaces by other programs, and colliding spheres."""

import math

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, Ball, axis_transfer
from rolling.in_si.scene_surface import scene_surface
from rolling.scene import library
from rolling.scene.file import read_as
from rolling.scene.scene import Scene
from rolling.surface.parameters import parameters, without_plane

FOLDER = library.folder() / "validation"
SKEWNESS = "surface.skewness"
LENGTHS = ("Sa", "Sq", "Sp", "Sv", "Sz", "Sk", "Spk", "Svk")  # in um; the others have no unit
OWN_NAMES = {"Smr1": "Smrk1", "Smr2": "Smrk2"}  # of the present norm, by the former ones
STEEL_KG_M3 = 7850.0
RADII_MM = (5.0, 15.0)  # of spheres that collide
CONTACT_S = 1e-4  # duration of their contact
PEAK_N = 100.0  # largest force
DISTANCE_M = 0.5  # of the listener, on the line through both centres
STEP_S = 2e-7
STEPS = 2**16
LEAD = 2000  # steps before the force begins


def surfaces() -> dict[str, tuple[Array, float]]:
    """Return heights [m] without their plane and their spacing [m], by item of the rows."""
    by_item = {}
    for values, scene in read_as(FOLDER / "surfaces.yaml", Scene).runs():
        surface = scene_surface(scene)
        item = f"skewness {values[SKEWNESS]:g}"
        by_item[item] = without_plane(surface.heights), surface.spacing
    return by_item


def surface_rows() -> list[tuple[str, str, float, float]]:
    """Return rule, item, published and own number of each parameter that a program computed.

    SurfaceTopography takes the surfaces as periodic, surfalize as ending at their edges.
    """
    own = {}
    for item, (heights, spacing) in surfaces().items():
        for wrap in (False, True):
            own[item, wrap] = parameters(heights, spacing, wrap)
    rows = []
    for row in pd.read_csv(FOLDER / "surfaces.csv", comment="#").itertuples():
        wrap = row.program.startswith("SurfaceTopography")
        name = OWN_NAMES.get(row.quantity, row.quantity)
        value = own[row.item, wrap][name]
        if row.quantity in LENGTHS:
            value *= 1e6
        program = row.program.partition(" ")[0]
        rows.append((row.quantity, f"{row.item}, {program}", float(row.value), value))
    return rows


def collision_rows() -> list[tuple[str, str, float, float]]:
    """Return rule, item, closed form and own number of the sound of two spheres that collide."""
    times: Array = STEP_S * (np.arange(STEPS) - LEAD).astype(float)
    inside = (times >= 0) & (times < CONTACT_S)
    force = PEAK_N * np.sin(np.pi * times / CONTACT_S) * inside
    frequency = np.fft.rfftfreq(STEPS, STEP_S)
    rows = []
    for radius_mm in RADII_MM:
        ball = Ball(1e-3 * radius_mm, STEEL_KG_M3)
        own = np.fft.irfft(np.fft.rfft(force) * axis_transfer(frequency, ball, DISTANCE_M), STEPS)
        wanted = colliding_spheres(times, 1e-3 * radius_mm)
        item = f"radius {radius_mm:g} mm"
        rows.append(("largest pressure", item, float(wanted.max()), float(own.max())))
        rows.append(("smallest pressure", item, float(wanted.min()), float(own.min())))
        difference = float(np.sqrt(np.mean((own - wanted) ** 2) / np.mean(wanted**2)))
        rows.append(("rms of the difference", item, 0.0, difference))
    return rows


def colliding_spheres(times: Array, radius_m: float) -> Array:
    """Return the pressure [Pa] of two equal rigid spheres on the line through their centres.

    Each is a dipole that the same half sine of force accelerates, one away from the listener and
    the other, one diameter farther, towards the listener: the model of L. L. Koss, J. Sound Vib. 36
    (1974) 541, solved here in closed form. The force begins at the time 0 [s], and
    times of travel count from the point of contact.
    """
    delay = 2 * radius_m / SOUND_M_S
    strength = 3 * AIR_KG_M3 * PEAK_N / (8 * DISTANCE_M * STEEL_KG_M3 * SOUND_M_S * CONTACT_S)
    nearer = _dipole(times + delay, radius_m) + _dipole(times + delay - CONTACT_S, radius_m)
    farther = _dipole(times, radius_m) + _dipole(times - CONTACT_S, radius_m)
    return np.asarray(strength * (nearer - farther))


def _dipole(times: Array, radius_m: float) -> Array:
    """Return the answer of a sphere to the force's rate cos(pi t / T) from the time 0 on.

    In times of a/c it solves y'' + 2 y' + 2 y = 2 cos(rate t) from rest.
    """
    t = np.maximum(times, 0.0) * SOUND_M_S / radius_m
    rate = math.pi * radius_m / (SOUND_M_S * CONTACT_S)
    stiff = 2 - rate**2
    size = stiff**2 + 4 * rate**2
    in_phase = 2 * stiff / size
    behind = 4 * rate / size
    steady = in_phase * np.cos(rate * t) + behind * np.sin(rate * t)
    fading = np.exp(-t) * (in_phase * np.cos(t) + (in_phase + rate * behind) * np.sin(t))
    return np.asarray(np.where(times > 0, steady - fading, 0.0))
