"""Results of the program beside published ones, case by case, and their page.

The table scenarios/validation/cases.toml describes the cases and the rules of their rows.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Template

from acoustics import BAND_NAMES, MID_HZ, a_weighting_db, sound_levels
from acoustics.arrays import Array
from acoustics.baffled_modes import own_resistance
from acoustics.loudness import loudness
from acoustics.radiation import AIR_KG_M3, SOUND_M_S
from rolling.contact.half_space import HalfSpace
from rolling.contact.solver import ContactError, solve_contact
from rolling.dynamics import drop, of_scene
from rolling.results.run_result import Run
from rolling.run.in_memory import Values, simulated
from rolling.scene import library
from rolling.scene.file import read_scene
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.sound.wavelengths import wavelength_bands
from rolling.surface.heights import statistics
from rolling.surface.measured import HeightArray
from rolling.surface.scene_surface import heights
from rolling.terminal import progress
from rolling.terminal.files import FolderError, write_bytes
from rolling.terminal.program import identity

PAGE, ALL, TITLE = Path("validation.md"), "all", "# Validation\n"
FOLDER = library.folder() / "validation"
Figures = Iterator[tuple[str, str, float, float]]  # rule, item, published number, ours
Case = dict[str, Any]  # a table of cases.toml


def validate(names: Sequence[str], out: Path | None) -> int:
    """Run cases, write their page, and return 1 if a difference is not allowed, else 0.

    Parameters
    ----------
    names : sequence of str. Names of cases; "all" among them: every case.
    out : Path or None. Page to write; an earlier page of validation is replaced. Default:
        validation.md.

    Raises
    ------
    FolderError : `out` is another file.
    """
    cases = tomllib.loads((FOLDER / "cases.toml").read_text(encoding="utf-8"))
    out = out or PAGE
    if out.exists() and TITLE not in out.read_text(encoding="utf-8", errors="replace"):
        raise FolderError(f"{out}: exists and is no page of validation; take another --out")
    tables = {}
    for name in cases if ALL in names else names:
        with progress.step(f"validating {name}"):
            tables[name] = rows = rows_of(cases[name], CASES[name]())
        beyond = [*rows["quantity"][~rows["holds"]]]
        words = f", {len(beyond)} beyond their bounds: {'; '.join(beyond)}" if beyond else ""
        progress.line(f"{name}: {len(rows)} rows{words}")
    write_bytes(out, page(tables, cases).encode())
    print(out)
    return int(not all(rows["holds"].all() for rows in tables.values()))


def rows_of(case: Case, figures: Figures) -> pd.DataFrame:
    """Return the rows of a case, their differences, and the bounds by its rules."""
    rows = []
    for quantity, item, number, ours in figures:
        rule = case["rows"][quantity]
        published = float(rule.get("published", number))
        bound = abs(published) * rule["relative"] if "relative" in rule else math.inf
        bounds = rule.get("allowed", (-bound, bound))
        words = f"{quantity}, {item}" if item else quantity
        rows.append((words, rule["unit"], published, float(ours), *bounds, rule["truth"]))
    names = ["quantity", "unit", "published", "ours", "least", "largest", "truth"]
    frame = pd.DataFrame(rows, columns=names)
    frame["difference"] = frame["ours"] - frame["published"]
    return frame.assign(holds=frame["difference"].between(frame["least"], frame["largest"]))


def page(tables: Mapping[str, pd.DataFrame], cases: Mapping[str, Case]) -> str:
    """Write the rows of cases as a page in Markdown."""
    template = Template((FOLDER / "page.md.jinja").read_text(encoding="utf-8"))
    return str(template.render(tables=tables, cases=cases, program=identity(), inf=math.inf))


def _scene(name: str) -> Scene:
    return read_scene(FOLDER / f"{name}.yaml")


def _runs(scene: Scene) -> dict[Values, Run]:
    """Simulate all runs of a scene in memory."""
    runs, failures = simulated(scene, 0, False)
    if failures:
        raise ContactError("; ".join(failures.values()))
    return runs


def _run(scene: Scene, heights: Array | None = None) -> Run:
    """Simulate a scene without a sweep in memory, on given heights [m] in place of its own."""
    if heights is not None:
        scene = scene.with_(surface=HeightArray(heights, spacing_um=scene.spacing_um))
    (run,) = _runs(scene).values()
    return run


# ---- impact of balls


def impact() -> Figures:
    """Compare time, force and pulse of an impact with Hertz, and restitution with Zener."""
    run = _run(_scene("ball-impact"))
    assert run.vibration is not None  # it has dynamics
    scene, motion = run.scene, run.vibration.motion
    first = int(np.argmax(motion.force_n > 0))
    pulse = motion.force_n[first : first + int(np.argmin(motion.force_n[first:] > 0))]
    step, lasts, largest = motion.time_step_s, drop.impact_s(scene), drop.largest_force_n(scene)
    yield "contact time, measured", "", math.nan, 1e6 * len(pulse) * step
    yield "contact time, Hertz", "", 1e6 * lasts, 1e6 * len(pulse) * step
    yield "largest force", "", largest, float(pulse.max())
    impulse = 2e6 * scene.mass * drop.speed_m_s(scene)
    yield "impulse 2 M v", "", impulse, 1e6 * float(pulse.sum()) * step
    middles = np.arange(len(pulse)) + 0.5
    phase = np.pi * (middles - middles @ pulse / pulse.sum()) * step / lasts
    error = np.abs(pulse / largest - np.maximum(np.cos(phase), 0.0) ** 1.5).max()
    yield "pulse less F sin^1.5, maximum over F", "", math.nan, float(error)
    for run in _runs(_scene("restitution")).values():
        scene = run.scene
        hertz = 4 / 3 * scene.contact_modulus * scene.radius**0.5
        mobility = of_scene.smooth_chain(scene).mobility_s_kg
        inelasticity = mobility * scene.mass**0.6 * hertz**0.4 * drop.speed_m_s(scene) ** 0.2
        plate = f"plate of {scene.plate.thickness_mm:g} mm"
        yield "restitution", plate, restitution(inelasticity), run.summary["restitution"]


def restitution(inelasticity: float) -> float:
    """Return the restitution of Zener's equation s'' + (1 + l d/dt) s^(3/2) = 0."""
    from scipy.integrate import solve_ivp  # slow to import

    def rate(_: float, state: Array) -> list[float]:
        root, speed = math.sqrt(max(state[0], 0.0)), state[1]  # no force once they are apart
        return [speed, -(root**3) - 1.5 * inelasticity * root * speed]

    return -float(solve_ivp(rate, (0, 100), [0.0, 1.0], rtol=1e-8, atol=1e-10).y[1, -1])


# ---- plates, weighting, third octaves and loudness

RATE_HZ = 48000


def against_phonometry() -> Figures:
    """Compare plates, levels and loudness with the stored figures of phonometry."""
    ours = _plate_figures() | _sound_figures()
    stored = pd.read_csv(FOLDER / "phonometry.csv", comment="#", index_col=["quantity", "item"])
    known = {quantity for quantity, _ in ours}  # without mosqito no loudness
    for (quantity, item), value in stored["value"].items():
        if quantity in known:
            yield quantity, item, value, ours[quantity, item]


def _plate_figures() -> dict[tuple[str, str], float]:
    """Return mobility, critical frequency and radiation efficiency of plates."""
    figures: dict[tuple[str, str], float] = {}
    for _, scene in _scene("plates").runs():
        plate, item = of_scene.rectangular_plate(scene), f"{scene.plate.thickness_mm:g} mm"
        assert plate is not None  # it has edges
        figures["mobility", item] = 1e3 * plate.mobility_s_kg
        figures["critical frequency", item] = plate.critical_hz
        modes_hz, edges = plate.angular_frequency / (2 * np.pi), (plate.length_m, plate.width_m)
        resistance = own_resistance(edges, plate.orders, modes_hz)
        efficiency = resistance / (AIR_KG_M3 * SOUND_M_S * math.prod(edges) / 4)
        for name, middle in zip(BAND_NAMES, MID_HZ, strict=True):
            inside = np.abs(np.log10(modes_hz / middle)) < 0.05
            if inside.any():
                level = 10 * np.log10(efficiency[inside].mean())
                figures["radiation efficiency", f"{item}, {name} Hz"] = level
    return figures


def _sound_figures() -> dict[tuple[str, str], float]:
    """Return weightings, and levels and loudness of white noise and of a tone."""
    noise = 0.1 * np.random.default_rng(1).standard_normal(4 * RATE_HZ)
    tone = 0.02 * math.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(4 * RATE_HZ) / RATE_HZ)
    levels = sound_levels(noise, RATE_HZ)
    figures: dict[tuple[str, str], Any] = {("LAeq", "noise"): levels.laeq_db}
    for name, level in levels.third_octave_db.items():
        figures["third octave", f"{name} Hz"] = level
        figures["A-weighting", f"{name} Hz"] = float(a_weighting_db(float(name)))
    with suppress(ModuleNotFoundError):  # loudness is an extra
        for name, signal in (("tone of 1 kHz", tone), ("noise", noise)):
            heard = loudness(signal, RATE_HZ, closed=True)
            figures |= {("loudness", name): heard.sone, ("sharpness", name): heard.acum}
    return figures


# ---- area of a rough elastic contact

LOADS_N, COARSE = (10.0, 20.0, 50.0), 2


def rough_contact() -> Figures:
    """Compare the area of contact at small loads with two theories and another solver."""
    scene = _scene("rough-contact")
    tamaas = pd.read_csv(FOLDER / "tamaas.csv", comment="#", index_col="load_n")
    rms_slope = statistics(heights(scene), scene.spacing).rms_slope
    for load in LOADS_N:
        (fine, _), (coarse, pressure) = (_area(scene, stride, load) for stride in (1, COARSE))
        area = (COARSE * fine - coarse) / (COARSE - 1)  # at zero spacing
        kappa = area * scene.contact_modulus * rms_slope / load
        for theory in ("Persson", "Bush"):
            yield f"kappa, {theory}", f"{load:g} N", math.nan, kappa
        stored = tamaas.loc[load]
        yield "area", f"{load:g} N", stored["area_um2"], 1e12 * coarse
        yield "maximum pressure", f"{load:g} N", stored["max_pressure_gpa"], 1e-9 * pressure


def rough_gap(scene: Scene, stride: int) -> tuple[Array, float]:
    """Return the gap [m] of ball and surface at every `stride`-th node, and the spacing [m]."""
    surface = heights(scene)
    spacing, side = stride * scene.spacing, min(surface.shape)
    surface = surface[:side:stride, :side:stride]
    x = (np.arange(len(surface)) - len(surface) // 2) * spacing
    return (x[:, None] ** 2 + x**2) / (2 * scene.radius) - surface, spacing


def _area(scene: Scene, stride: int, load: float) -> tuple[float, float]:
    """Return area of contact [m2] and maximum pressure [Pa] of a window."""
    gap, spacing = rough_gap(scene, stride)
    contact = solve_contact(HalfSpace(spacing, scene.contact_modulus), gap, load)
    area = np.count_nonzero(contact.pressure) * spacing**2
    return float(area), float(contact.pressure.max())


# ---- slopes of level


def speed_and_roughness() -> Figures:
    """Return exponents of the sound pressure against roughness and speed."""
    runs = _runs(_scene("speed-and-roughness"))
    levels = pd.Series({values: run.sound.levels.laeq_db for values, run in runs.items()}).unstack()
    for speed in levels:
        yield "exponent of Ra, linear chain", f"{speed:g} m/s", math.nan, _exponent(levels[speed])
    yield "exponent of Ra, sliding", "", math.nan, _exponent(levels[levels.columns[-1]])
    yield "exponent of speed, sliding", "", math.nan, _exponent(levels.iloc[0])


def _exponent(levels: pd.Series) -> float:
    """Return the exponent of the sound pressure by the levels [dB] at two or more values."""
    return float(np.polyfit(20 * np.log10(levels.index.to_numpy(float)), levels, 1)[0])


# ---- contact filter of wheel and rail

SHOWN_MM = (10, 20, 40)
LONGEST_MM, LEAST_MM = 100.0, 7.9  # wavelengths whose differences are summed up


def wheel_on_rail(scene: Scene, published: Mapping[float, pd.Series]) -> pd.DataFrame:
    """Compare the contact filter of an elliptic, a round and a ridged contact with a table.

    The filter is the level of the approach under a constant load over the level of the heights
    under the centre of the contact, in third octaves of wavelength. Nothing is fitted.

    Parameters
    ----------
    scene : Scene
        Wheel and rail, with a self-affine surface whose track closes.
    published : dict of Series
        Published filters [dB] by nominal wavelength [mm], by load [N].

    Returns
    -------
    DataFrame
        A row for each load, contact and third octave: load_n, contact, wavelength_mm, published_db,
        ours_db and difference_db.
    """
    radius = 1e3 * np.sqrt(scene.radius * scene.radius_across)
    sphere = {"sphere.radius_mm": radius, "sphere.radius_across_mm": None}
    profile = centre_lines(heights(scene))[:, :1]
    ridges = np.repeat(profile, scene.track.n_across, axis=1)
    rows = []
    for load, table in published.items():
        loaded = scene.with_({"rolling.load_n": load})
        for contact, changes, surface in (
            ("elliptic", {}, None),
            ("round", sphere, None),
            ("elliptic, full-width ridges", {}, ridges),
        ):
            run = _run(loaded.with_(changes), surface)
            rows.append(_beside(table, contact_filter(run)).assign(load_n=load, contact=contact))
    order = ["load_n", "contact", "wavelength_mm", "published_db", "ours_db", "difference_db"]
    return pd.concat(rows, ignore_index=True)[order]


def differences(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rms difference [dB] by load and contact, from 7.9 to 100 mm."""
    within = rows[rows["wavelength_mm"].between(LEAST_MM, LONGEST_MM)]
    grouped = within.groupby(["load_n", "contact"], sort=False)["difference_db"]
    return grouped.agg(lambda error: np.sqrt(np.mean(error**2))).rename("rms_db").reset_index()


def published_filters(path: str) -> dict[float, pd.Series]:
    """Read filters [dB] by wavelength [mm] from a table with a column for each load [kN]."""
    table = pd.read_csv(path, comment="#", index_col="wavelength_mm")
    return {1e3 * float(load): table[load] for load in table}


def centre_lines(surface: Array) -> Array:
    """Return the one or two lines of heights under the centre of the contact."""
    across = surface.shape[1]
    return surface[:, (across - 1) // 2 : across // 2 + 1]


def contact_filter(run: Run) -> pd.Series:
    """Return the level of the approach re the heights under the centre [dB] by wavelength [mm]."""
    scene = run.scene
    wavelength, surface = wavelength_bands(centre_lines(heights(scene)), scene.spacing, True)
    own, level = wavelength_bands(run.series["approach"][:-1], scene.step, True)
    filtered = pd.Series(level, 1e3 * own) - pd.Series(surface, 1e3 * wavelength)
    law = scene.surface
    least = 1e-3 * law.shortest_um if isinstance(law, SelfAffineLaw) else 4e3 * scene.step
    return filtered[filtered.index >= least].dropna()


def _beside(published: pd.Series, ours: pd.Series) -> pd.DataFrame:
    """Return both filters [dB] in the bands that both have, and their difference."""
    bands = [
        pd.Series(part.to_numpy(), np.round(10 * np.log10(part.index)))
        for part in (published, ours)
    ]
    rows = pd.concat(bands, axis=1, join="inner", keys=["published_db", "ours_db"])
    rows["difference_db"] = rows["ours_db"] - rows["published_db"]
    return rows.sort_index().assign(wavelength_mm=lambda part: 10 ** (part.index / 10))


def wheel_figures() -> Figures:
    """Compare the contact filter of wheel and rail with the table of CNOSSOS-EU."""
    table = published_filters(str(FOLDER / "contact_filter.csv"))
    rows = wheel_on_rail(_scene("wheel-rail"), table)
    shown = rows["wavelength_mm"].round().isin(SHOWN_MM) & rows["contact"].eq("elliptic")
    for row in rows[shown].sort_values(["load_n", "wavelength_mm"]).itertuples():
        item = f"{row.load_n / 1e3:g} kN, {row.wavelength_mm:.0f} mm"
        yield "filter", item, row.published_db, row.ours_db
    for row in differences(rows).itertuples():
        yield f"rms difference, {row.contact}", f"{row.load_n / 1e3:g} kN", math.nan, row.rms_db


CASES: dict[str, Callable[[], Figures]] = {
    "contact-filter": wheel_figures,
    "impact": impact,
    "phonometry": against_phonometry,
    "rough-contact": rough_contact,
    "speed-and-roughness": speed_and_roughness,
}
