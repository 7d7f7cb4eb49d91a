"""Results of the program beside published ones, case by case, and their page."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from acoustics.baffled_modes import own_resistance
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.level import sound_levels
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, ThinPlate
from acoustics.rectangular_plate import RectangularPlate
from acoustics.weighting import a_weighting_db
from rolling.contact.half_space import HalfSpace
from rolling.contact.solver import solve_contact
from rolling.dynamics import drop, of_scene
from rolling.results.run_result import Run
from rolling.scene import library
from rolling.scene.file import read_scene
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.messages import nearest
from rolling.scene.scene import Scene
from rolling.sound.wavelengths import wavelength_bands
from rolling.surface.heights import statistics
from rolling.surface.scene_surface import heights
from rolling.terminal import progress
from rolling.terminal.files import FolderError, write_bytes
from rolling.terminal.program import identity

PAGE = Path("validation.md")
COMMAND = "rolling validate --out docs/validation.md"
UNBOUND = math.inf  # bound of a difference that is shown only
MEASUREMENT, NORM, CLOSED_FORM = "measurement", "norm", "closed form"
EQUATION, PROGRAM, LIMIT = "equation, solved", "other program", "limit of a theory"
NO_ANCHOR = "no anchor"

Simulate = Callable[..., Any]


@dataclass(frozen=True)
class Simulators:
    """The functions `rolling.simulate` and `rolling.simulate_sweep`."""

    single: Simulate
    sweep: Simulate


@dataclass(frozen=True)
class ValidationRow:
    """A published number beside that of the program, and the differences that are allowed."""

    quantity: str
    unit: str
    published: float
    ours: float
    truth: str
    bound: float  # maximum of the difference
    least: float | None = None  # minimum of the difference; None: minus the bound

    @property
    def difference(self) -> float:
        """Difference ours - published."""
        return self.ours - self.published

    @property
    def holds(self) -> bool:
        """Whether the difference lies within its bounds."""
        least = -self.bound if self.least is None else self.least
        return bool(least <= self.difference <= self.bound)

    def cells(self) -> list[str]:
        """Write the row in cells of a table."""
        allowed = "shown only" if math.isinf(self.bound) else f"±{self.bound:.3g}"
        if self.least is not None:
            allowed = f"{self.least:.3g} to {self.bound:.3g}"
        numbers = [f"{value:.4g}" for value in (self.published, self.ours)]
        difference = f"{self.difference:+.2g}" + ("" if self.holds else " **exceeded**")
        return [self.quantity, self.unit, *numbers, difference, allowed, self.truth]


Rows = Iterator[ValidationRow]


def validate(names: Sequence[str], out: Path | None, simulators: Simulators) -> int:
    """Run cases, write their page, and return 1 if a difference exceeds its bound, else 0.

    Parameters
    ----------
    names : sequence of str. Names of cases; all if empty.
    out : Path or None. Page to write. Default: validation.md.
    simulators : Simulators. Functions that simulate a scene and a sweep.

    Raises
    ------
    FolderError : there is no such case.
    """
    cases = tomllib.loads((_folder() / "cases.toml").read_text(encoding="utf-8"))
    for name in names:
        if name not in cases:
            near = nearest(name, [*cases])
            raise FolderError(f"CASE: got {name}, allowed: {', '.join(cases)}{near}")
    tables: dict[str, list[ValidationRow]] = {}
    for name in names or cases:
        with progress.step(f"validating {name}"):
            tables[name] = list(CASES[name](simulators))
        for row in tables[name]:
            if not row.holds:
                progress.line(f"{name}: {' | '.join(row.cells())}")
        kept = sum(row.holds for row in tables[name])
        progress.line(f"{name}: {kept} of {len(tables[name])} differences within their bounds")
    path = out or PAGE
    write_bytes(path, page(tables, cases).encode())
    print(path)
    return int(not all(row.holds for rows in tables.values() for row in rows))


def page(tables: Mapping[str, Sequence[ValidationRow]], cases: Mapping[str, Any]) -> str:
    """Write the page of the rows of cases in Markdown."""
    rows = [row for table in tables.values() for row in table]
    bound = [row for row in rows if not math.isinf(row.bound)]
    parts = [
        "# Validation",
        f"The command `{COMMAND}` wrote this page with {identity()}.",
        f"{sum(row.holds for row in bound)} of {len(bound)} differences (ours - published) lie"
        f" within their stated bounds; {len(rows) - len(bound)} more are shown only. Kinds of"
        f" truth: {', '.join(dict.fromkeys(row.truth for row in rows))}.",
    ]
    head = ["quantity", "unit", "published", "ours", "difference", "allowed", "truth"]
    for name, table in tables.items():
        case = cases[name]
        scenes = ", ".join(f"`scenarios/validation/{scene}.yaml`" for scene in case["scenes"])
        lines = [head, ["---"] * len(head), *(row.cells() for row in table)]
        parts += [
            f"## {case['title']}",
            f"Case `{name}`. Source: {case['source']}." + (f" Scene: {scenes}." if scenes else ""),
            case["text"],
            "\n".join(f"| {' | '.join(cells)} |" for cells in lines),
        ]
    return "\n\n".join(parts) + "\n"


def _folder() -> Path:
    return library.folder() / "validation"


def _scene(name: str) -> Scene:
    return read_scene(_folder() / f"{name}.yaml")


def _stored(name: str) -> pd.DataFrame:
    """Read a table of published figures."""
    return pd.read_csv(_folder() / f"{name}.csv", comment="#")


# ---- impact of balls


def impact(simulators: Simulators) -> Rows:
    """Compare contact time, force and pulse with Hertz, and restitution with Zener's equation."""
    run = simulators.single(_scene("ball-impact"), progress=False)
    scene, motion = run.scene, run.vibration.motion
    first = int(np.argmax(motion.force_n > 0))
    pulse = motion.force_n[first : first + int(np.argmin(motion.force_n[first:] > 0))]
    step, lasts, largest = motion.time_step_s, drop.impact_s(scene), drop.largest_force_n(scene)
    # The steps at both ends of the pulse are in contact for a part of their length.
    time, steps = 1e6 * len(pulse) * step, 2e6 * step
    yield ValidationRow("contact time", "us", 5.0, time, MEASUREMENT, 0.8)
    yield ValidationRow("contact time, Hertz", "us", 1e6 * lasts, time, CLOSED_FORM, steps)
    force = 0.01 * largest
    yield ValidationRow("largest force", "N", largest, float(pulse.max()), CLOSED_FORM, force)
    impulse, both = 1e6 * float(pulse.sum()) * step, 2e6 * scene.mass * drop.speed_m_s(scene)
    yield ValidationRow("impulse, 2 M v", "uN s", both, impulse, CLOSED_FORM, 0.01 * both)
    middles = np.arange(len(pulse)) + 0.5
    phase = np.pi * (middles - middles @ pulse / pulse.sum()) * step / lasts
    error = np.abs(pulse / largest - np.maximum(np.cos(phase), 0.0) ** 1.5).max()
    form = "pulse less F sin^1.5, largest over F"
    yield ValidationRow(form, "1", 0.0, float(error), CLOSED_FORM, 0.03)
    for run in simulators.sweep(_scene("restitution"), progress=False).values():
        scene = run.scene
        hertz = 4 / 3 * scene.contact_modulus * scene.radius**0.5
        mobility = of_scene.smooth_chain(scene).mobility_s_kg
        inelasticity = mobility * scene.mass**0.6 * hertz**0.4 * drop.speed_m_s(scene) ** 0.2
        quantity = f"restitution, plate of {scene.plate.thickness_mm:g} mm"
        ours = float(run.summary["restitution"])
        yield ValidationRow(quantity, "1", restitution(inelasticity), ours, EQUATION, 0.003)


def restitution(inelasticity: float) -> float:
    """Return the restitution of Zener's equation s'' + (1 + l d/dt) s^(3/2) = 0."""
    from scipy.integrate import solve_ivp  # slow to import

    def rate(_: float, state: Array) -> list[float]:
        root, speed = math.sqrt(max(state[0], 0.0)), state[1]
        return [speed, -(root**3) - 1.5 * inelasticity * root * speed]

    def apart(_: float, state: Array) -> float:
        return float(state[0])

    apart.terminal, apart.direction = True, -1  # type: ignore[attr-defined]
    solution = solve_ivp(rate, (0, 100), [0.0, 1.0], events=apart, rtol=1e-8, atol=1e-10)
    return -float(solution.y[1, -1])


# ---- plates, weighting, third octaves and loudness

RATE_HZ = 48000
STEEL, GLASS = (210e9, 0.3, 7850.0), (71e9, 0.23, 2500.0)  # Pa, 1, kg/m3
PLATES = {"steel 1 mm": (STEEL, 1e-3), "steel 10 mm": (STEEL, 1e-2), "glass 8 mm": (GLASS, 8e-3)}
RADIATOR, EDGES_M = (STEEL, 5e-3), (1.2, 0.8)
BOUNDS = {  # shares of the published number in these units, and differences in dB
    "mobility": 1e-4,
    "critical frequency": 1e-4,
    "loudness": 0.01,
    "sharpness": 0.03,
    "radiation efficiency": 3.0,
    "A-weighting": 0.1,
    "LAeq": 0.2,  # no limit holds a filter above 16 kHz
    "third octave": 0.3,
}


def against_phonometry(_: Simulators) -> Rows:
    """Compare plates, levels and loudness with the stored figures of phonometry."""
    ours = _acoustic_figures()
    for _, stored in _stored("phonometry").iterrows():
        quantity, item, unit = stored["quantity"], stored["item"], stored["unit"]
        if (quantity, item) in ours:
            bound = BOUNDS[quantity] * (1 if unit == "dB" else stored["value"])
            words = f"{quantity}, {item}" + (" Hz" if str(item).replace(".", "").isdigit() else "")
            value = ours[quantity, item]
            yield ValidationRow(words, unit, stored["value"], value, PROGRAM, bound)


def _acoustic_figures() -> dict[tuple[str, str], float]:
    """Return the program's figures by quantity and item."""
    figures: dict[tuple[str, str], float] = {}
    for name, (material, thickness) in PLATES.items():
        plate = ThinPlate(**_bending(material, thickness))
        figures["mobility", name] = 1e3 * plate.mobility_s_kg
        figures["critical frequency", name] = plate.critical_hz
    radiator = RectangularPlate(
        **_bending(*RADIATOR), loss_factor=0.01, length_m=EDGES_M[0], width_m=EDGES_M[1]
    )
    modes_hz = radiator.angular_frequency / (2 * np.pi)
    resistance = own_resistance(EDGES_M, radiator.orders, modes_hz)
    efficiency = resistance / (AIR_KG_M3 * SOUND_M_S * math.prod(EDGES_M) / 4)
    noise = 0.1 * np.random.default_rng(1).standard_normal(4 * RATE_HZ)
    levels = sound_levels(noise, RATE_HZ)
    figures["LAeq", "noise"] = levels.laeq_db or math.nan
    for name, middle in zip(BAND_NAMES, MID_HZ, strict=True):
        within = np.abs(np.log10(modes_hz / middle)) < 0.05
        if within.any():
            figures["radiation efficiency", name] = 10 * np.log10(efficiency[within].mean())
        figures["third octave", name] = levels.third_octave_db[name] or math.nan
        figures["A-weighting", name] = float(a_weighting_db(float(name)))
    try:
        from acoustics.loudness import loudness

        tone = 0.02 * math.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(4 * RATE_HZ) / RATE_HZ)
        for name, signal in (("tone of 1 kHz", tone), ("noise", noise)):
            heard = loudness(signal, RATE_HZ, closed=True)
            figures["loudness", name] = heard.sone or math.nan
            figures["sharpness", name] = heard.acum or math.nan
    except ModuleNotFoundError:
        progress.line("mosqito is not installed: no rows of loudness")
    return figures


def _bending(material: tuple[float, float, float], thickness: float) -> dict[str, float]:
    """Return mass per area [kg/m2] and bending stiffness [N m] of a plate."""
    young, poisson, density = material
    stiffness = young * thickness**3 / (12 * (1 - poisson**2))
    return {"mass_per_area_kg_m2": density * thickness, "bending_stiffness_n_m": stiffness}


# ---- area of a rough elastic contact

LOADS_N, COARSE = (10.0, 20.0, 50.0), 2
PERSSON, BUSH = math.sqrt(8 / math.pi), math.sqrt(2 * math.pi)


def rough_contact(_: Simulators) -> Rows:
    """Compare the area of contact at small loads with two theories and another solver."""
    scene, tamaas = _scene("rough-contact"), _stored("tamaas").set_index("load_n")
    over_load = scene.contact_modulus * statistics(heights(scene), scene.spacing).rms_slope
    between = BUSH - PERSSON
    for load in LOADS_N:
        fine, (coarse, largest) = _area(scene, 1, load)[0], _area(scene, COARSE, load)
        kappa = over_load / load * (COARSE * fine - coarse) / (COARSE - 1)
        at = f"{load:g} N"
        words = f"kappa at {at}, zero spacing, above Persson"
        yield ValidationRow(words, "1", PERSSON, kappa, LIMIT, between, 0.0)
        words = f"kappa at {at}, zero spacing, below Bush"
        yield ValidationRow(words, "1", BUSH, kappa, LIMIT, 0.0, -between)
        stored = tamaas.loc[load]
        area, pressure = 1e12 * coarse, 1e-9 * largest
        bounds = 0.005 * stored["area_um2"], 0.001 * stored["max_pressure_gpa"]
        words = f"area at {at}, {COARSE * scene.spacing_um:g} um"
        yield ValidationRow(words, "um2", stored["area_um2"], area, PROGRAM, bounds[0])
        words = f"maximum pressure at {at}"
        yield ValidationRow(words, "GPa", stored["max_pressure_gpa"], pressure, PROGRAM, bounds[1])


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


def speed_and_roughness(simulators: Simulators) -> Rows:
    """Return exponents of the sound pressure against roughness and speed."""
    runs = simulators.sweep(_scene("speed-and-roughness"), progress=False)
    levels = pd.Series({values: run.sound.levels.laeq_db for values, run in runs.items()}).unstack()
    lowest, highest = levels.index[[0, -1]]
    for speed in levels:
        n = _exponent(levels[speed], lowest, highest)
        words = f"exponent of Ra, {lowest:g} to {highest:g} um, {speed:g} m/s"
        yield ValidationRow(f"{words}, linear chain", "1", 1.0, n, CLOSED_FORM, 0.1)
    yield ValidationRow(f"{words}, sliding", "1", 0.75, n, NO_ANCHOR, UNBOUND)
    slow, fast = levels.columns[[0, -1]]
    n = _exponent(levels.loc[lowest], slow, fast)
    words = f"exponent of speed, {slow:g} to {fast:g} m/s, sliding"
    yield ValidationRow(words, "1", 0.75, n, NO_ANCHOR, UNBOUND)


def _exponent(levels: pd.Series, first: float, last: float) -> float:
    """Return the exponent of the sound pressure by levels [dB] at two values."""
    return float((levels[last] - levels[first]) / (20 * math.log10(last / first)))


# ---- contact filter of wheel and rail

SHOWN_MM = (10, 20, 40)
LONGEST_MM, LEAST_MM = 100.0, 7.9  # wavelengths whose differences are summed up


def wheel_on_rail(
    scene: Scene, published: Mapping[float, pd.Series], simulate: Simulate
) -> pd.DataFrame:
    """Compare the contact filter of an elliptic, a round and a ridged contact with a table.

    The filter is the level of the approach under a constant load over the level of the heights
    under the centre of the contact, in third octaves of wavelength. Nothing is fitted.

    Parameters
    ----------
    scene : Scene
        Wheel and rail, with a self-affine surface whose track closes.
    published : dict of Series
        Published filters [dB] by nominal wavelength [mm], by load [N].
    simulate : callable
        `rolling.simulate`.

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
            run = simulate(loaded.with_(changes), progress=False, heights=surface)
            rows.append(_beside(table, contact_filter(run)).assign(load_n=load, contact=contact))
    order = ["load_n", "contact", "wavelength_mm", "published_db", "ours_db", "difference_db"]
    return pd.concat(rows, ignore_index=True)[order]


def differences(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rms and maximum difference [dB] by load and contact, from 7.9 to 100 mm."""
    within = rows[rows["wavelength_mm"].between(LEAST_MM, LONGEST_MM)]
    grouped = within.groupby(["load_n", "contact"], sort=False)["difference_db"]
    return pd.DataFrame(
        {
            "rms_db": grouped.apply(lambda error: float(np.sqrt(np.mean(error**2)))),
            "worst_db": grouped.apply(lambda error: float(np.abs(error).max())),
        }
    ).reset_index()


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


def contact_filter_rows(simulators: Simulators) -> Rows:
    """Compare the contact filter of wheel and rail with the table of CNOSSOS-EU."""
    table = published_filters(str(_folder() / "contact_filter.csv"))
    rows = wheel_on_rail(_scene("wheel-rail"), table, simulators.single)
    near = rows[rows["contact"].eq("elliptic") & np.isin(rows["wavelength_mm"].round(1), SHOWN_MM)]
    for row in near.sort_values(["load_n", "wavelength_mm"]).itertuples():
        words = f"filter, {row.load_n / 1e3:g} kN, {row.wavelength_mm:.0f} mm"
        yield ValidationRow(words, "dB", row.published_db, row.ours_db, NORM, 3.0)
    for row in differences(rows).itertuples():
        words = f"rms over third octaves, {row.load_n / 1e3:g} kN, {row.contact}"
        bound = 1.5 if row.contact == "elliptic" else UNBOUND
        yield ValidationRow(words, "dB", 0.0, row.rms_db, NORM, bound)


CASES: dict[str, Callable[[Simulators], Rows]] = {
    "contact-filter": contact_filter_rows,
    "impact": impact,
    "phonometry": against_phonometry,
    "rough-contact": rough_contact,
    "speed-and-roughness": speed_and_roughness,
}
