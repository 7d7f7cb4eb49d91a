"""A study of an article: its readings, each a folder of scene files, solved case by case and put into numbers.

A reading is one way to understand what the article leaves open; a variation changes what it states; a twin is the scene of a
reading without hardness. Depends on solve and sound; knows nothing of claims or figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics import level, uncertainty
from acoustics import plots as sound_plots
from acoustics.bands import third_octave_mean_square
from acoustics.level import I_REF_W_M2
from acoustics.spectrum import article_line_level_db, line_spectrum
from acoustics.weighting import a_weighting_db
from rolling.contact import closed_forms
from rolling.folders import files as run_folder
from rolling.folders import run_record
from rolling.scene import file as scene_file
from rolling.scene.run_names import run_names
from rolling.scene.scene import Gaussian, Scene, SceneError, expand, track
from rolling.simulation import batch
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.sound import ContactSound, contact_sound

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Part:
    """What of a study is solved: all of it, or so many surfaces, these of its loads, a shorter track in longer steps.

    strides : steps are so many times as long.
    """

    seeds: int | None = None
    loads: tuple[float, ...] | None = None
    duration_s: float | None = None
    strides: int = 1


WHOLE = Part()
# The widest contact, of two bodies at Ra 5 um and 100 N, reaches over 1.29 mm: the track must be longer.
QUICK = Part(seeds=1, loads=(5, 20, 100), duration_s=0.015, strides=3)

# What the article states of the bodies (section 3): a rigid sphere of 10 mm diameter on steel.
STATED_RADIUS_MM, STATED_MODULUS_GPA, STATED_POISSON = 5.0, 210.0, 0.3


@dataclass(frozen=True)
class Case:
    """One surface under one load in one reading, in numbers.

    hardness_gpa : None: purely elastic, a twin.  bodies : what a case and its twin have in common, in words.
    plastic_ratio, contact_ratio : mean plastic and contact area over the Hertz area.
    max_pressure : greatest along the track [Pa].
    deflection : mean over the track of the greatest deflection at each position [m]; NaN in results of earlier versions.
    laeq_db : of the sound, energy-true [dB re 20 uPa].
    laeq_uncertainty_db, weighted_uncertainty_db : standard uncertainty from the length of the record [dB] of laeq_db and of
    20 lg of a_weighted_w; NaN without sound.
    line_hz, line_db : the article's A-weighted line spectrum [dB re 1e-12 W/m2], means over 1/12 octave.
    maximum_db : its greatest line.  maximum_20_db : with 20 lg of the release, which doubles the levels but not their weighting.
    band_w : rms of the release power's fluctuation in each third octave [W] (31,), NaN where there is none.
    a_weighted_w : A-weighted rms of the fluctuation within hearing [W].
    """

    reading: str
    roughness_um: float
    load_n: float
    seed: int
    correlation_um: float
    hardness_gpa: float | None
    bodies: str
    nodes_across: int
    duration_s: float
    plastic_ratio: float
    contact_ratio: float
    max_pressure: float
    deflection: float
    laeq_db: float | None
    laeq_uncertainty_db: float
    weighted_uncertainty_db: float
    maximum_db: float
    maximum_20_db: float
    line_hz: Array
    line_db: Array
    band_w: Array
    a_weighted_w: float


def scenes(folder: Path, part: Part = WHOLE) -> list[Scene]:
    """The scenes of a reading: of all its files, in the order of roughness, load and seed, as much as the part takes.

    Raises
    ------
    FolderError : no scene files there. SceneError : one that cannot be used.
    """
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise run_folder.FolderError(f"{folder}: no scene files of a reading")
    found = [scene for file in files for _, scene in expand(_load(file, part))]
    loads = {scene.load for scene in found}
    if part.loads is not None and len(loads) > 1:
        loads &= {*part.loads}
    seeds = part.seeds or math.inf
    return sorted((one for one in found if one.load in loads and varied(one)[2] <= seeds), key=varied)


def description(folder: Path) -> str:
    """What a reading takes for granted: the comment that its first scene file begins with; empty without one."""
    with sorted(folder.glob("*.yaml"))[0].open(encoding="utf-8") as file:
        line = file.readline()
    return line.strip("# \n") if line.startswith("#") else ""


def departures(scenes: Sequence[Scene]) -> list[str]:
    """List the differences of some scenes from the bodies that the article states; empty for a reading.

    A twin, which has no hardness, differs by that.
    """
    found = []
    for scene in scenes:
        sphere, plate = scene.sphere, scene.plate
        if sphere.radius_mm != STATED_RADIUS_MM:
            found.append(f"a radius of {sphere.radius_mm:g} mm (stated: a diameter of {2 * STATED_RADIUS_MM:g} mm)")
        if sphere.youngs_modulus_gpa is not None:
            found.append("an elastic sphere (stated: a rigid one)")
        if (plate.youngs_modulus_gpa, plate.poissons_ratio) != (STATED_MODULUS_GPA, STATED_POISSON):
            found.append(f"a plate of {plate.youngs_modulus_gpa:g} GPa (stated: {STATED_MODULUS_GPA:g} GPa)")
        if plate.hardness_gpa is None:
            found.append("no hardness (stated: 2.1 GPa)")
    return list(dict.fromkeys(found))


def _bodies(scene: Scene) -> str:
    """Name everything that a case has in common with its twin without hardness, apart from what a study varies."""
    surface, numerics = scene.surface, scene.numerics
    assert isinstance(surface, Gaussian)
    return (
        f"R {scene.sphere.radius_mm:g} mm, contact modulus {scene.contact_modulus / 1e9:.4g} GPa, {surface.autocorrelation},"
        f" {surface.width_um:g} um across, nodes of {surface.spacing_um:g} um, steps of {numerics.step_nodes:g}"
    )


def _load(file: Path, part: Part) -> Scene:
    scene = scene_file.load(file)
    overrides = [] if part.duration_s is None else [f"rolling.duration_s={part.duration_s}"]
    if part.strides > 1:
        overrides.append(f"numerics.step_nodes={part.strides * scene.numerics.step_nodes:g}")
    return scene_file.load(file, overrides) if overrides else scene


def varied(scene: Scene) -> tuple[float, float, int, float]:
    """What a study varies: Ra [um], load [N], seed, correlation length [um]."""
    s = scene.surface
    assert isinstance(s, Gaussian)
    return s.roughness_ra_um, scene.load, s.seed, s.correlation_length_um


def runs(folder: Path, scenes: Sequence[Scene]) -> list[Run]:
    """The scenes as runs, each with a folder of its own below `folder`, named after what the study varies."""
    found = []
    for scene in scenes:
        roughness, load, seed, length = varied(scene)
        values = {"surface.roughness_ra_um": roughness, "rolling.load_n": load, "surface.seed": seed}
        values["surface.correlation_length_um"] = length
        found.append((values, scene))
    names = run_names([values for values, _ in found])
    return [Run(values, scene, folder / name) for (values, scene), name in zip(found, names, strict=True)]


def open_results(runs: Sequence[Run]) -> list[Result]:
    """What is there of the runs already; a folder is made for each.

    Raises
    ------
    FolderError : a folder holds another scene's result, which would be lost.
    """
    texts = [scene_file.dump(one.scene) for one in runs]
    for one, text in zip(runs, texts, strict=True):
        said = one.folder / "resolved.yaml"
        if said.is_file() and said.read_text(encoding="utf-8") != text and not _same(said, one.scene):
            raise run_folder.FolderError(
                f"{one.folder}: holds a case that was made with other settings; take another --out"
            )
    results = []
    for one, text in zip(runs, texts, strict=True):
        one.folder.mkdir(parents=True, exist_ok=True)
        if run_record.read(one.folder) is None:
            run_record.write(one.folder, run_record.new("run", adopted=(one.folder / batch.RESULT).is_file()))
        run_folder.write_bytes(one.folder / "resolved.yaml", text.encode())
        results.append(batch.stored(one) or Result.empty(track(one.scene), one.scene.start))
    return results


def _same(said: Path, scene: Scene) -> bool:
    """Whether a resolved scene file of an earlier version says the same: keys that it lacks count with their defaults."""
    try:
        before = scene_file.load(said)
    except SceneError:
        return False

    def physics(one: Scene) -> dict[str, Any]:
        return {key: value for key, value in one.to_dict().items() if key not in ("name", "title", "description")}

    return physics(before) == physics(scene)


def solve_all(
    runs: Sequence[Run],
    results: Sequence[Result],
    workers: int,
    name: str,
    begun: Callable[[Run], object] = lambda run: None,
) -> Outcome:
    """Solve what is missing, on all cores; nobody looks at the maps of hundreds of cases."""
    return batch.solve(runs, results, workers, name, mapped=False, begun=begun)


def case(reading: str, one: Run, result: Result) -> Case:
    """A solved run in numbers."""
    scene, way = one.scene, track(one.scene)
    roughness, load, seed, length = varied(scene)
    energy = result.whole("release_energy")
    sound = contact_sound(scene, energy, result.step, way.closed, result.solved_steps)
    hertz = math.pi * closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus) ** 2
    rate = len(sound.power) / sound.duration
    line_hz, line_db = article_line_level_db(sound.power, rate, scene.sound.distance_m, scene.sound.q)
    lines = sound_plots.Lines.audible(line_hz, line_db)
    mean_hz, mean_db = lines.mean
    weighting = a_weighting_db(lines.frequency_hz)
    band_w, a_weighted_w = _fluctuation(scene, sound)
    unfactored = uncertainty.level_uncertainty(
        sound.pressure, sound.sample_rate, sound.levels, own_factor=False, laps=result.steps / result.solved_steps
    )
    return Case(
        reading=reading,
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=length,
        hardness_gpa=scene.plate.hardness_gpa,
        bodies=_bodies(scene),
        nodes_across=way.n_across,
        duration_s=sound.duration,
        plastic_ratio=float(result.whole("plastic_area").mean()) / hertz,
        contact_ratio=float(result.whole("contact_area").mean()) / hertz,
        max_pressure=float(result.whole("max_pressure").max()),
        deflection=float(result.whole("max_deflection").mean()),
        laeq_db=sound.levels.laeq_db,
        laeq_uncertainty_db=_number(sound.uncertainty.laeq_db),
        weighted_uncertainty_db=_number(unfactored.laeq_db),
        maximum_db=float(lines.level_db.max()),
        maximum_20_db=float((2 * (lines.level_db - weighting) + weighting).max()),
        line_hz=mean_hz,
        line_db=mean_db,
        band_w=band_w,
        a_weighted_w=a_weighted_w,
    )


def _fluctuation(scene: Scene, sound: ContactSound) -> tuple[Array, float]:
    """Compute the rms [W] of the release power's fluctuation in each third octave (31,) and A-weighted within hearing.

    Sound pressure is linear in the fluctuation of the intensity, and so of the power. The result is NaN wherever the
    sound has no level.
    """
    levels = sound.levels
    if not sound.factor or levels.laeq_db is None:
        return np.full(len(levels.third_octave_db), np.nan), math.nan
    watts = sound.pressure / sound.factor * (4 * math.pi * scene.sound.distance_m**2 / scene.sound.q)
    band_rms = np.sqrt(third_octave_mean_square(*line_spectrum(watts, sound.sample_rate)))
    known = [level_db is not None for level_db in levels.third_octave_db.values()]
    return np.where(known, band_rms, np.nan), level.a_weighted_rms(watts, sound.sample_rate)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def power_level_db(power: Array | float, factor: int, distance_m: float = 1.0) -> Array:
    """Level of a release power [W] at a distance: factor lg(P / (4 pi r^2 I_ref)), factor 10 as the article's equation, or 20.

    20 lg takes the power for an amplitude: its differences between cases are twice those
    of 10 lg, its absolute value means nothing.
    """
    ratio = np.asarray(power, dtype=float) / (4 * math.pi * distance_m**2 * I_REF_W_M2)
    with np.errstate(divide="ignore"):
        return factor * np.log10(ratio)
