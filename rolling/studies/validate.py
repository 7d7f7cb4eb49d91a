"""Results of the program beside published ones, case by case, and their page.

The table scenarios/validation/cases.toml describes the cases, the rules of their rows, the kinds of
truth and the origins of bounds. `CASES` has the function of each case.
"""

import math
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import soundfile
from jinja2 import Template

from acoustics import BAND_NAMES, MID_HZ, a_weighting_db, sound_levels
from acoustics.arrays import Array
from acoustics.loudness import loudness
from acoustics.radiation import AIR_KG_M3, SOUND_M_S
from acoustics.rectangular_plate import own_resistance
from acoustics.wav import SAMPLE_RATE_HZ as RATE_HZ
from rolling.contact.half_space import HalfSpace
from rolling.contact.single_contact import solve_contact
from rolling.contact.solver import ContactError
from rolling.dynamics import drop
from rolling.in_si.measured import HeightArray
from rolling.in_si.physics_of_scene import bodies_of, plate_of
from rolling.in_si.scene_surface import heights
from rolling.recordings.record_levels import TOTALS
from rolling.recordings.recording_comparison import THIRD_OCTAVE, compare
from rolling.report import synthetic_bench
from rolling.report.bench import compare_all, read_bench
from rolling.results.run_result import Run
from rolling.run.solving import Values, simulate_runs
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.file import read_as
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.messages import nearest
from rolling.scene.scene import Scene
from rolling.sound.wavelengths import wavelength_bands
from rolling.studies import bearing_truths, printed_truths, recording_truths, slope_truths
from rolling.studies.output import markdown_table
from rolling.surface.heights import statistics
from rolling.terminal import progress
from rolling.terminal.program import identity
from rolling.terminal.whole_files import FolderError, read_regular, write_bytes

PAGE = Path("validation.md")
ALL = "all"
TITLE = "# Validation\n"
MAX_PAGE = 10_000_000  # bytes of a page that is replaced
FOLDER = library.folder() / "validation"
Case = dict[str, Any]  # a table of cases.toml


class PublishedValue(NamedTuple):
    """Published number and ours; several numbers of ours are of independent surfaces or records.

    `rule` names the rule of the row, `item` the condition; `bound` replaces the bound of the rule.
    """

    rule: str
    item: str
    published: float
    ours: float | Array | pd.Series
    bound: float | None = None


PublishedValues = Iterator[PublishedValue]


def validate(cases: Sequence[str], out: Path | None, benches: Sequence[Path] = ()) -> int:
    """Run cases, write their page, and return 1 if a difference is not allowed, else 0.

    Parameters
    ----------
    cases : sequence of str. Names of cases; "all" among them: every case. Empty: every case, or
        only the bench where benches are given.
    out : Path or None. Page to write; an earlier page of validation is replaced. Default:
        validation.md.
    benches : sequence of Path. Folders of benches, in place of the synthetic one of the case bench.

    Raises
    ------
    FolderError : a bench lacks something, there is no such case, `out` is another file, or its
        folder cannot be written.
    """
    content = tomllib.loads((FOLDER / "cases.toml").read_text(encoding="utf-8"))
    known = content["cases"]
    out = out or PAGE
    names = list(cases)
    if benches and BENCH not in names:
        names.append(BENCH)
    if ALL in names or not names:
        names = list(known)
    for name in names:
        if name not in known:
            near = nearest(name, [*known])
            listed = ", ".join([ALL, *known])
            raise FolderError(f"CASE: got {name}{near}, allowed: {listed}")
    if out.is_dir() or not os.access(out.parent, os.W_OK):
        raise FolderError(f"--out: got {out}, allowed: a file in a folder that can be written")
    if out.exists() and not _is_page(out):
        raise FolderError(f"{out}: exists and is no page of validation; take another --out")
    tables = {}
    for name in names:
        values = bench_rows(benches) if name == BENCH and benches else CASES[name]()
        with progress.step(f"validating {name}"):
            rows = rows_of(known[name], values)
        tables[name] = rows
        summary = f"{name}: {len(rows)} rows"
        beyond = list(rows["quantity"][~rows["holds"]])
        if beyond:
            summary += f", {len(beyond)} beyond their bounds: {'; '.join(beyond)}"
        progress.line(summary)
    write_bytes(out, page(tables, content).encode())
    print(out)
    return int(not all(rows["holds"].all() for rows in tables.values()))


def _is_page(path: Path) -> bool:
    """Tell whether a path is a page of validation."""
    try:
        return TITLE.encode() in read_regular(path, MAX_PAGE)
    except OSError:  # of a pipe, a device or a larger file, too
        return False


def rows_of(case: Case, values: PublishedValues) -> pd.DataFrame:
    """Return the rows of a case, their differences, and the bounds by its rules."""
    rows = []
    for value in values:
        rule = case["rows"][value.rule]
        samples = np.atleast_1d(value.ours)
        published = float(rule.get("published", value.published))
        least = -math.inf
        largest = math.inf
        if value.bound is not None:
            least = -value.bound
            largest = value.bound
        elif "allowed" in rule:
            least, largest = rule["allowed"]
        elif "relative" in rule:
            largest = abs(published) * rule["relative"]
            least = -largest
        row = {
            "quantity": f"{value.rule}, {value.item}" if value.item else value.rule,
            "unit": rule["unit"],
            "published": published,
            "ours": samples.mean(),
            "spread": samples.std(ddof=1) if len(samples) > 1 else math.nan,
            "least": least,
            "largest": largest,
            "origin": rule.get("origin", "-"),
            "truth": rule["truth"],
        }
        rows.append(row)
    columns = ["quantity", "unit", "published", "ours", "spread"]
    columns += ["least", "largest", "origin", "truth"]
    frame = pd.DataFrame(rows, columns=columns)
    frame["difference"] = frame["ours"] - frame["published"]
    side = frame["largest"].where(frame["difference"] > 0, -frame["least"])
    frame["share"] = frame["difference"].abs() / side
    # A number without a published one, such as a fitted value, is shown only.
    is_alone = frame["published"].isna() & np.isinf(frame["largest"])
    is_within = frame["difference"].between(frame["least"], frame["largest"])
    return frame.assign(holds=is_within | is_alone)


def page(tables: Mapping[str, pd.DataFrame], content: Mapping[str, Any]) -> str:
    """Write the rows of cases, and a table of the kinds of truth, as a page in Markdown."""
    template = Template((FOLDER / "page.md.jinja").read_text(encoding="utf-8"))
    rows = pd.concat(tables.values(), ignore_index=True)
    bounded = np.isfinite(rows["largest"])
    rows_of_kinds = []
    for kind, text in content["kinds"].items():
        of_kind = rows[rows["truth"] == kind]
        if len(of_kind):
            rows_of_kinds.append([kind, text, *_kind_cells(of_kind)])
    return str(
        template.render(
            cases=content["cases"],
            origins=content["origins"],
            bounded=int(bounded.sum()),
            within=int(rows["holds"][bounded].sum()),
            kinds=markdown_table(KIND_COLUMNS, rows_of_kinds),
            tables={name: case_table(rows) for name, rows in tables.items()},
            program=identity(),
        )
    )


COLUMNS = ("quantity", "unit", "published", "ours", "difference", "bound", "origin", "truth")
KIND_COLUMNS = (
    "truth",
    "meaning",
    "rows",
    "with a bound",
    "largest share of a bound",
    "all within",
)


def case_table(rows: pd.DataFrame) -> str:
    """Write the rows of a case as a table in Markdown."""
    return markdown_table(COLUMNS, [_cells(row) for _, row in rows.iterrows()])


def _cells(row: pd.Series) -> list[str]:
    """Write the cells of a row."""
    ours = f"{row['ours']:.4g}"
    if not math.isnan(row["spread"]):
        ours += f"±{row['spread']:.2g}"
    has_published = not math.isnan(row["published"])
    difference = f"{row['difference']:+.2g}" if has_published else "-"
    if not row["holds"]:
        difference += " **beyond**"
    if math.isinf(row["largest"]):
        bound = "-"
    elif row["least"] == -row["largest"]:
        bound = f"±{row['largest']:.2g}"
    else:
        bound = f"{row['least']:.2g} to {row['largest']:.2g}"
    return [
        row["quantity"],
        row["unit"],
        f"{row['published']:.4g}" if has_published else "-",
        ours,
        difference,
        bound,
        row["origin"],
        row["truth"],
    ]


def _kind_cells(rows: pd.DataFrame) -> list[str]:
    """Write the numbers of rows, and how far they lie within their bounds."""
    bounded = int(np.isfinite(rows["largest"]).sum())
    if not bounded:
        return [f"{len(rows)}", "0", "-", "-"]
    verdict = "yes" if rows["holds"].all() else "**no**"
    return [f"{len(rows)}", f"{bounded}", f"{rows['share'].max():.2f}", verdict]


def _scene(name: str) -> Scene:
    """Read a scene of the validation."""
    return read_as(FOLDER / f"{name}.yaml", Scene)


def _runs(scene: Scene) -> dict[Values, Run]:
    """Simulate all runs of a scene in memory."""
    runs, failures = simulate_runs(scene, 0, False)
    if failures:
        raise ContactError("; ".join(failures.values()))
    return runs


def _run(scene: Scene, heights: Array | None = None) -> Run:
    """Simulate a scene without a sweep in memory, on given heights [m] in place of its own."""
    if heights is not None:
        scene = scene.with_(surface=HeightArray(heights, spacing_um=scene.spacing_um))
    runs = list(_runs(scene).values())
    assert len(runs) == 1  # the scene has no sweep
    return runs[0]


# ---- impact of balls


def impact() -> PublishedValues:
    """Compare time, force and pulse of an impact with Hertz, and restitution with Zener."""
    run = _run(_scene("ball-impact"))
    assert run.vibration_sound is not None  # it has dynamics
    scene = run.scene
    motion = run.vibration_sound.motion
    first = int(np.argmax(motion.force_n > 0))
    pulse = motion.force_n[first : first + int(np.argmin(motion.force_n[first:] > 0))]
    step = motion.time_step_s
    impact_s = drop.impact_s(bodies_of(scene))
    largest = drop.largest_force_n(bodies_of(scene))
    time_us = 1e6 * len(pulse) * step
    two_us = 2e6 * step
    yield PublishedValue(
        "contact time, measured", "", math.nan, time_us, 0.5 + two_us
    )  # rounded to 1 us
    yield PublishedValue("contact time, Hertz", "", 1e6 * impact_s, time_us, two_us)
    yield PublishedValue("largest force", "", largest, float(pulse.max()))
    impulse = 2e6 * scene.mass * drop.speed_m_s(bodies_of(scene))
    yield PublishedValue("impulse 2 M v", "", impulse, 1e6 * float(pulse.sum()) * step)
    middles = np.arange(len(pulse)) + 0.5
    phase = np.pi * (middles - middles @ pulse / pulse.sum()) * step / impact_s
    error = np.abs(pulse / largest - np.maximum(np.cos(phase), 0.0) ** 1.5).max()
    yield PublishedValue("pulse less F sin^1.5, over F", "", math.nan, float(error))
    for run in _runs(_scene("restitution")).values():
        scene = run.scene
        hertz = 4 / 3 * scene.contact_modulus * scene.radius**0.5
        mobility = bodies_of(scene).smooth_chain.mobility_s_kg
        inelasticity = (
            mobility * scene.mass**0.6 * hertz**0.4 * drop.speed_m_s(bodies_of(scene)) ** 0.2
        )
        plate = f"{scene.plate.thickness_mm:g} mm"
        zener = restitution(inelasticity)
        fallen = run.numbers.motion
        assert fallen is not None and fallen.restitution is not None  # the ball falls
        yield PublishedValue("restitution", plate, zener, fallen.restitution)


def restitution(inelasticity: float) -> float:
    """Return the restitution of Zener's equation s'' + (1 + l d/dt) s^(3/2) = 0."""
    from scipy.integrate import solve_ivp  # slow to import

    def rate(_: float, state: Array) -> list[float]:
        """Return the rates of s and s'."""
        root = math.sqrt(max(state[0], 0.0))  # no force once they are apart
        speed = state[1]
        return [speed, -(root**3) - 1.5 * inelasticity * root * speed]

    return -float(solve_ivp(rate, (0, 100), [0.0, 1.0], rtol=1e-8, atol=1e-10).y[1, -1])


# ---- plates, weighting, third octaves and loudness


def phonometry() -> PublishedValues:
    """Compare plates, levels and loudness with stored figures of phonometry and of norms."""
    ours = _plate_figures() | _sound_figures()
    for file in ("phonometry", "norms"):
        stored = pd.read_csv(FOLDER / f"{file}.csv", comment="#", index_col=["quantity", "item"])
        for (quantity, item), value in stored["value"].items():
            yield PublishedValue(quantity, item, value, ours[quantity, item])


def _plate_figures() -> dict[tuple[str, str], float]:
    """Return mobility, critical frequency and radiation efficiency of plates."""
    figures: dict[tuple[str, str], float] = {}
    for _, scene in _scene("plates").runs():
        plate = plate_of(scene.plate).with_edges
        item = f"{scene.plate.thickness_mm:g} mm"
        assert plate is not None  # it has edges
        figures["mobility", item] = 1e3 * plate.mobility_s_kg
        figures["critical frequency", item] = plate.critical_hz
        modes_hz = plate.angular_frequency / (2 * np.pi)
        edges = (plate.length_m, plate.width_m)
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
    for (name, level), middle in zip(levels.third_octave_db.items(), MID_HZ, strict=True):
        figures["third octave", f"{name} Hz"] = level
        figures["A-weighting", f"{name} Hz"] = float(a_weighting_db(float(name)))
        figures["A-weighting of bands", f"{name} Hz"] = float(a_weighting_db(middle))
    for name, signal in (("tone of 1 kHz", tone), ("noise", noise)):
        values = loudness(signal, RATE_HZ, closed=True)
        figures["loudness", name] = values.sone
        figures["sharpness", name] = values.acum
    return figures


# ---- area of a rough contact

LOADS_N = (10.0, 20.0, 50.0)
LARGE_N = (200.0, 500.0, 2000.0)
COARSE = 2


def rough_contact() -> PublishedValues:
    """Compare the area of contact with two theories, and contacts with other solvers."""
    from scipy.special import erf  # slow to import

    scenes = [scene for _, scene in _scene("rough-contact").runs()]
    modulus = scenes[0].contact_modulus
    slopes = np.array([statistics(heights(scene), scene.spacing).rms_slope for scene in scenes])
    for load in LOADS_N:
        kappa = np.array([_area(scene, load) for scene in scenes]) * modulus * slopes / load
        for theory in ("Persson", "Bush"):
            yield PublishedValue(f"kappa, {theory}", f"{load:g} N", math.nan, kappa)
    gap, spacing = rough_gap(scenes[0], COARSE)
    contacts = pd.read_csv(FOLDER / "contact_solvers.csv", comment="#", index_col=[0, 1, 2])
    for (solver, hardness, load), stored in contacts.iterrows():
        solved = solve_contact(HalfSpace(spacing, modulus), gap, load, hardness=1e9 * hardness)
        plastic = np.count_nonzero(solved.pressure >= 1e9 * hardness) * spacing**2
        ours = {
            "area": 1e12 * solved.contact_area,
            "plastic area": 1e12 * float(plastic),
            "pressure": 1e-9 * float(solved.pressure.max()),
            "approach": 1e6 * solved.approach,
        }
        kind = f"{hardness:g} GPa" if math.isfinite(hardness) else "elastic"
        item = f"{load:g} N, {kind}, {solver.partition(' ')[0]}"
        for quantity, number in stored.dropna().items():
            yield PublishedValue(quantity, item, number, ours[quantity])
    scenes = [scene.with_({"sphere.radius_mm": scene.sphere.radius_mm / 10}) for scene in scenes]
    for load in LARGE_N:
        disc = math.pi * (0.75 * load * scenes[0].radius / modulus) ** (2 / 3)
        # Persson's law of a flat contact, erf(c) with the pressure, averaged over that of Hertz
        c = math.sqrt(2) * 1.5 * load / disc / (modulus * slopes)
        share = erf(c) * (1 - 0.5 / c**2) + np.exp(-(c**2)) / (math.sqrt(math.pi) * c)
        ratio = np.array([_area(scene, load) for scene in scenes]) / disc / share
        yield PublishedValue("area over Persson's", f"{share.mean():.0%}", math.nan, ratio)


def _area(scene: Scene, load: float) -> float:
    """Return the area of elastic contact [m2], extrapolated from two grids to zero spacing."""
    areas = []
    for stride in (1, COARSE):
        gap, spacing = rough_gap(scene, stride)
        areas.append(
            solve_contact(HalfSpace(spacing, scene.contact_modulus), gap, load).contact_area
        )
    fine, coarse = areas
    return (COARSE * fine - coarse) / (COARSE - 1)


def rough_gap(scene: Scene, stride: int) -> tuple[Array, float]:
    """Return the gap [m] of ball and surface at every `stride`-th node, and the spacing [m]."""
    surface = heights(scene)
    spacing = stride * scene.spacing
    side = min(surface.shape)
    surface = surface[:side:stride, :side:stride]
    x = (np.arange(len(surface)) - len(surface) // 2) * spacing
    return (x[:, None] ** 2 + x**2) / (2 * scene.radius) - surface, spacing


# ---- surfaces and colliding spheres


def surfaces() -> PublishedValues:
    """Compare parameters of two surfaces with those of other programs."""
    for rule, item, published, ours in printed_truths.surface_rows():
        yield PublishedValue(rule, item, published, ours)


def colliding_spheres() -> PublishedValues:
    """Compare the sound of two spheres that collide with its closed form."""
    for rule, item, published, ours in printed_truths.collision_rows():
        yield PublishedValue(rule, item, published, ours)


def bearings() -> PublishedValues:
    """Compare speeds, loads and vibration of bearings with printed numbers and linear theory."""
    for rule, item, published, ours in bearing_truths.bearing_rows():
        yield PublishedValue(rule, item, published, ours)


def recordings() -> PublishedValues:
    """Compare a bearing in a motor, healthy and with pits, with figures of public recordings."""
    scene = read_as(FOLDER / "recorded-6205.yaml", BearingScene)
    figures = pd.read_csv(FOLDER / "recorded-6205.csv", comment="#")
    for rule, item, published, ours in recording_truths.recording_rows(scene, figures):
        yield PublishedValue(rule, item, published, ours)


def laws() -> PublishedValues:
    """Compare slopes of level and contact with those that papers print."""
    gentle, rough, smooth = (
        [*_runs(_scene(name)).values()]
        for name in ("speed-and-roughness", "rough-slopes", "smooth-slopes")
    )
    for rule, item, published, ours in slope_truths.slope_rows(gentle, rough, smooth):
        yield PublishedValue(rule, item, published, ours)


# ---- contact filter of wheel and rail

SHOWN_KN = 50
SHOWN_MM = (10, 20, 40)
LONGEST_MM = 100.0  # wavelength whose difference counts
MIN_MM = 7.9  # wavelength whose difference counts


def wheel_on_rail(scene: Scene, published: pd.DataFrame) -> pd.DataFrame:
    """Compare the contact filter on isotropic and on ridged surfaces with a table.

    The filter is the level of the approach under a constant load over the level of the heights
    under the centre of the contact, in third octaves of wavelength. Nothing is fitted. Another load
    or wheel is another column, without a published filter one of NaN. Another rail, roughness or
    set of surfaces is another scene.

    Parameters
    ----------
    scene : Scene
        Rail of radius `sphere.radius_across_mm` [mm] and a self-affine surface whose track closes,
        swept over its seeds. Ridges repeat the heights under the centre of the first.
    published : DataFrame
        Published filters [dB] by nominal wavelength [mm]; the columns are pairs of load [kN] and
        diameter of the wheel [mm], as `published_filters` reads them.

    Returns
    -------
    DataFrame
        A row for each load, wheel, run of the sweep, surface and third octave: load_kn, wheel_mm,
        sample, surface, wavelength_mm, published_db, ours_db and difference_db.

    Examples
    --------
    `rows = wheel_on_rail(read_scene("wheel-rail.yaml"), published_filters("mine.csv"))`, then
    `differences(rows)`
    """
    rows = []
    for (load, wheel), table in published.items():
        loaded = scene.with_({"rolling.load_n": 1e3 * load, "sphere.radius_mm": wheel / 2})
        for sample, (_, single) in enumerate(loaded.runs()):
            profile = centre_lines(heights(single))[:, :1]
            ridges = np.repeat(profile, single.track.n_across, axis=1)
            surfaces: dict[str, Array | None] = {"isotropic": None}
            if sample == 0:
                surfaces["ridges"] = ridges
            for surface, given in surfaces.items():
                case = {"load_kn": load, "wheel_mm": wheel, "surface": surface, "sample": sample}
                rows.append(_beside(table, filter_db(_run(single, given))).assign(**case))
    return pd.concat(rows, ignore_index=True)


def differences(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rms and mean difference [dB] by load, wheel and surface, from 7.9 to 100 mm.

    They are of the filter in dB averaged over runs, which leaves out their scatter.
    """
    within = rows[rows["wavelength_mm"].between(MIN_MM, LONGEST_MM)]
    keys = ["load_kn", "wheel_mm", "surface"]
    mean = within.groupby([*keys, "wavelength_mm"])["difference_db"].mean().groupby(level=keys)
    return mean.agg(rms_db=_rms, mean_db="mean")


def _rms(values: pd.Series) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def published_filters(path: str) -> pd.DataFrame:
    """Read filters [dB] by wavelength [mm]; the first two lines hold loads [kN] and wheels [mm]."""
    table = pd.read_csv(path, comment="#", index_col=0, header=[0, 1])
    table.columns = pd.MultiIndex.from_tuples(
        [(float(load), float(wheel)) for load, wheel in table.columns]
    )
    return table


def centre_lines(surface: Array) -> Array:
    """Return the one or two lines of heights under the centre of the contact."""
    across = surface.shape[1]
    return surface[:, (across - 1) // 2 : across // 2 + 1]


def filter_db(run: Run) -> pd.Series:
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
    bands = [part.set_axis(np.round(10 * np.log10(part.index))) for part in (published, ours)]
    rows = pd.concat(bands, axis=1, join="inner", keys=["published_db", "ours_db"])
    rows["difference_db"] = rows["ours_db"] - rows["published_db"]
    rows = rows.sort_index()
    rows["wavelength_mm"] = 10 ** (rows.index / 10)
    return rows


def contact_filter() -> PublishedValues:
    """Compare the contact filter of wheel and rail with the table of CNOSSOS-EU."""
    table = published_filters(str(FOLDER / "contact_filter.csv"))
    rows = wheel_on_rail(_scene("wheel-rail"), table)
    summary = differences(rows)
    for load, wheel in table:
        item = f"{load:g}/{wheel:g}"
        column = table[load, wheel].loc[LONGEST_MM:MIN_MM]
        band = float(np.sqrt(np.mean(column.diff() ** 2)))  # between the table and its shift
        isotropic = summary.loc[load, wheel, "isotropic"]
        ridges = summary.loc[load, wheel, "ridges"]
        yield PublishedValue("rms", item, math.nan, isotropic["rms_db"], band)
        yield PublishedValue("mean", item, math.nan, isotropic["mean_db"])
        yield PublishedValue("rms, ridges", item, math.nan, ridges["rms_db"])
    shown = rows[(rows["load_kn"] == SHOWN_KN) & (rows["surface"] == "isotropic")]
    for (wheel, length), part in shown.groupby(["wheel_mm", shown["wavelength_mm"].round()]):
        if length in SHOWN_MM:
            item = f"{SHOWN_KN:g}/{wheel:g}, {length:g} mm"
            yield PublishedValue("filter", item, part["published_db"].iloc[0], part["ours_db"])


# ---- synthetic recording

RECORDED_S = 6.0  # duration
NOISE_DB = -30.0  # background re the sound
SHOWN_HZ = (250, 500, 1000, 2000, 5000)


def synthetic_recording() -> PublishedValues:
    """Find a known filter by `rolling compare` in recordings that are made from other runs.

    The recording beside a run holds the sound of all other runs, so that its surface is another.
    All runs have the same bodies, so the lengths of the records alone make the difference.
    """
    runs = [*_runs(_scene("synthetic-recording")).values()]
    pieces = [run.listen(RECORDED_S / (len(runs) - 1), seed=1).pressure for run in runs]
    tables = []
    for number, run in enumerate(runs):
        others = np.concatenate(pieces[:number] + pieces[number + 1 :])
        table = _compared(run, _played(others), np.random.default_rng(number))
        is_band = table["quantity"] == "third octave"
        frequency = table["frequency_hz"]
        gain = _gain_db(frequency)
        power = 10 ** ((table["run_db"][is_band] + a_weighting_db(frequency[is_band])) / 10)
        change = 10 * np.log10((power * 10 ** (gain[is_band] / 10)).sum() / power.sum())  # of LAeq
        table = table.assign(run=number, gain=np.where(is_band, gain, change))
        tables.append(table[table["quantity"] != "modulation"].fillna({"frequency_hz": 0}))
    changes = pd.concat(tables, ignore_index=True)
    for hertz, part in changes.groupby("frequency_hz"):
        if hertz in (0, *SHOWN_HZ):
            item = f"{hertz:g} Hz" if hertz else "LAeq"
            known = part["gain"].mean()
            bound = 2 * part["records_uncertainty_db"].mean()
            yield PublishedValue("filter", item, known, -part["difference_db"], bound)
    bands = changes[changes["frequency_hz"] > 0]
    error = (bands["difference_db"] + bands["gain"]).abs()
    within = (error <= 2 * bands["records_uncertainty_db"]).groupby(bands["run"]).mean()
    yield PublishedValue("bands within 2 u", "", math.nan, within)


def _compared(run: Run, sound: Array, rng: np.random.Generator) -> pd.DataFrame:
    """Compare a run with a sound [Pa] in white noise, whose background was recorded alone."""
    noise = 10 ** (NOISE_DB / 20) * sound.std() * rng.standard_normal((2, len(sound)))
    full_scale = 2 * np.abs(sound).max()
    with TemporaryDirectory() as folder:
        recorded = Path(folder, "sound.wav")
        background = Path(folder, "background.wav")
        soundfile.write(recorded, (sound + noise[0]) / full_scale, RATE_HZ, "PCM_24")
        soundfile.write(background, noise[1] / full_scale, RATE_HZ, "PCM_24")
        return compare(run, recorded, f"{full_scale:.9g}", background).table


def _played(pressure: Array) -> Array:
    """Return a sound [Pa] behind the filter."""
    gain_db = _gain_db(np.fft.rfftfreq(len(pressure), 1 / RATE_HZ).astype(float))
    return np.fft.irfft(10 ** (gain_db / 20) * np.fft.rfft(pressure), len(pressure))


def _gain_db(frequency_hz: Array) -> Array:
    """Return the filter [dB]: -6 dB up to 800 Hz, then falling to -15 dB at 2500 Hz."""
    return np.interp(np.log(np.maximum(frequency_hz, 1.0)), np.log([800, 2500]), [-6, -15])


# ---- benches

BENCH = "bench"
LOUD_DB = 30.0  # below the loudest third octave, down to which differences count


def bench_rows(folders: Sequence[Path], kind: str = "measured") -> PublishedValues:
    """Compare the runs of benches with their recordings; solve those that have not run."""
    for folder in folders:
        for result in compare_all(read_bench(folder)):
            quantity = result.comparison.quantity
            for pair in result.comparison.pairs:
                table = result.comparison.table
                rows = table[table["channel"] == pair.name]
                name = pair.name or quantity.name
                item = f"{name}, re {quantity.reference_text} ({folder.name}/{result.name})"
                total = rows[rows["quantity"].isin(TOTALS)].iloc[0]
                yield PublishedValue(
                    rule=f"{kind} level",
                    item=item,
                    published=total["recording_db"],
                    ours=total["run_db"],
                    bound=2 * total["difference_uncertainty_db"] if kind == "measured" else None,
                )
                bands = rows[rows["quantity"] == THIRD_OCTAVE]
                loud = bands["recording_db"] >= bands["recording_db"].max() - LOUD_DB
                yield PublishedValue(
                    rule=f"{kind} third octaves, rms difference",
                    item=item,
                    published=0.0,
                    ours=_rms(bands["difference_db"][loud]),
                )


def bench() -> PublishedValues:
    """Make the synthetic bench, and compare its run with its recordings."""
    with TemporaryDirectory() as parent:
        folder = synthetic_bench.make(Path(parent, synthetic_bench.NAME))
        yield from bench_rows([folder], "synthetic")


# The cases of cases.toml, by name.
CASES: dict[str, Callable[[], PublishedValues]] = {
    "impact": impact,
    "phonometry": phonometry,
    "rough-contact": rough_contact,
    "surfaces": surfaces,
    "colliding-spheres": colliding_spheres,
    "bearings": bearings,
    "recordings": recordings,
    "laws": laws,
    "contact-filter": contact_filter,
    "synthetic-recording": synthetic_recording,
    BENCH: bench,
}
