"""The study of an article: readings as folders of scene files, solved case by case.

A reading settles the article's open points in one way. A variation changes one of its statements.
A twin is the scene of a reading without hardness.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from acoustics import level, uncertainty
from acoustics import plots as sound_plots
from acoustics.bands import third_octave_mean_square
from acoustics.level import I_REF_W_M2
from acoustics.spectrum import article_line_level_db, line_spectrum
from acoustics.weighting import a_weighting_db
from rolling._typing import Array
from rolling.contact import closed_forms
from rolling.folders import files as run_folder
from rolling.folders import run_record
from rolling.scene import file as scene_file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.scene.sweep import run_name
from rolling.simulation import batch
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.terminal import defaults


@dataclass(frozen=True)
class Part:
    """The solved part of a study: all of it, or fewer cases on a shorter track with longer steps.

    Parameters
    ----------
    seeds : int or None. Number of surfaces. Default: None, for all.
    loads : tuple of float or None, N. Loads of readings with several loads. Default: None, for all.
    duration_s : float or None, s. Duration of rolling. Default: None, as in the scene files.
    strides : int. Factor on the length of a step. Default: 1.
    finer : bool. True if verdicts near their limit are checked at half the spacing. Default: False.
    """

    seeds: int | None = None
    loads: tuple[float, ...] | None = None
    duration_s: float | None = None
    strides: int = 1
    finer: bool = False


WHOLE = Part(finer=True)
QUICK = Part(
    seeds=defaults.QUICK_SEEDS,
    loads=defaults.QUICK_LOADS_N,
    duration_s=defaults.QUICK_SECONDS,
    strides=defaults.QUICK_STRIDES,
)

# The bodies of the article (section 3): a rigid sphere of 10 mm diameter on steel.
STATED_RADIUS_MM, STATED_MODULUS_GPA, STATED_POISSON = 5.0, 210.0, 0.3


@dataclass(frozen=True)
class Case:
    """A surface under a load in a reading, in numbers.

    Parameters
    ----------
    hardness_gpa : float or None, GPa. None for a purely elastic plate, as in a twin.
    bodies : str. The settings that a case shares with its twin, in words.
    plastic_ratio, contact_ratio : float. Mean plastic and contact area over the Hertz area.
    max_pressure : float, Pa. Maximum along the track.
    deflection : float, m. Mean over the track of the maximum deflection at each position. NaN in
        results of earlier versions.
    laeq_db : float or None, dB re 20 uPa. LAeq of the sound, energy-true.
    laeq_uncertainty_db, weighted_uncertainty_db : float, dB. Standard uncertainty of laeq_db and of
        20 lg of a_weighted_w, from the length of the record. NaN without sound.
    line_hz, line_db : arrays, Hz and dB re 1e-12 W/m2. The article's A-weighted line spectrum,
        means over 1/12 octave.
    maximum_db : float, dB. Its maximum.
    maximum_20_db : float, dB. Its maximum with 20 lg of the release, which doubles levels but not
        their weighting.
    band_w : array (31,), W. Rms of the release power's fluctuation in each third octave. NaN where
        there is none.
    a_weighted_w : float, W. A-weighted rms of the fluctuation within hearing.
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
    """Read the scenes of a reading from all its files, in the order of roughness, load and seed.

    Raises
    ------
    FolderError : the folder holds no scene files.
    SceneError : a scene cannot be used.
    """
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise run_folder.FolderError(f"{folder}: no scene files of a reading")
    swept = [scene for file in files for _, scene in _load(file, part).runs()]
    loads = {scene.load for scene in swept}
    if part.loads is not None and len(loads) > 1:
        loads &= {*part.loads}
    seeds = part.seeds or math.inf
    return sorted(
        (scene for scene in swept if scene.load in loads and varied(scene)[2] <= seeds), key=varied
    )


def description(folder: Path) -> str:
    """Return the assumptions of a reading.

    They stand in the first line of its first scene file, if that line is a comment.
    """
    with sorted(folder.glob("*.yaml"))[0].open(encoding="utf-8") as file:
        line = file.readline()
    return line.strip("# \n") if line.startswith("#") else ""


def departures(scenes: Sequence[Scene]) -> list[str]:
    """List the differences of some scenes from the bodies that the article states.

    The list is empty for a reading. A twin differs in its missing hardness.
    """
    differences = []
    for scene in scenes:
        sphere, plate = scene.sphere, scene.plate
        if sphere.radius_mm != STATED_RADIUS_MM:
            differences.append(
                f"a radius of {sphere.radius_mm:g} mm (stated: "
                f"a diameter of {2 * STATED_RADIUS_MM:g} mm)"
            )
        if sphere.youngs_modulus_gpa is not None:
            differences.append("an elastic sphere (stated: a rigid one)")
        if (plate.youngs_modulus_gpa, plate.poissons_ratio) != (STATED_MODULUS_GPA, STATED_POISSON):
            differences.append(
                f"a plate of {plate.youngs_modulus_gpa:g} GPa (stated: {STATED_MODULUS_GPA:g} GPa)"
            )
        if plate.hardness_gpa is None:
            differences.append("no hardness (stated: 2.1 GPa)")
    return list(dict.fromkeys(differences))


def _bodies(scene: Scene) -> str:
    """Name all settings that a case shares with its twin, except the varied settings."""
    surface, numerics = scene.surface, scene.numerics
    assert isinstance(surface, Gaussian)
    return (
        f"R {scene.sphere.radius_mm:g} mm, contact modulus {scene.contact_modulus / 1e9:.4g} GPa, "
        f"{surface.autocorrelation},"
        f" {surface.width_um:g} um across, nodes of {surface.spacing_um:g} um, "
        f"steps of {numerics.step_nodes:g}"
    )


def _load(file: Path, part: Part) -> Scene:
    """Load a scene file with the shorter track and the longer steps of a part."""
    scene = scene_file.read_scene(file)
    overrides = [] if part.duration_s is None else [f"rolling.duration_s={part.duration_s}"]
    if part.strides > 1:
        overrides.append(f"numerics.step_nodes={part.strides * scene.numerics.step_nodes:g}")
    return scene_file.read_scene(file, overrides) if overrides else scene


def varied(scene: Scene) -> tuple[float, float, int, float]:
    """Return the values that a study varies: Ra [um], load [N], seed, correlation length [um]."""
    surface = scene.surface
    assert isinstance(surface, Gaussian)
    return surface.roughness_ra_um, scene.load, surface.seed, surface.correlation_length_um


def runs(folder: Path, scenes: Sequence[Scene]) -> list[Run]:
    """Make a run of each scene, in a folder below `folder` with the varied values in its name."""
    swept = []
    for scene in scenes:
        roughness, load, seed, length = varied(scene)
        values = {
            "surface.roughness_ra_um": roughness,
            "rolling.load_n": load,
            "surface.seed": seed,
        }
        values["surface.correlation_length_um"] = length
        swept.append((values, scene))
    names = [run_name(values) for values, _ in swept]
    return [
        Run(values, scene, folder / name)
        for (values, scene), name in zip(swept, names, strict=True)
    ]


def open_results(runs: Sequence[Run]) -> list[Result]:
    """Open the stored results of all runs, and make a folder for each.

    Raises
    ------
    FolderError : a folder holds the result of another scene, which would be lost.
    """
    texts = [scene_file.dump(run.scene) for run in runs]
    for run, text in zip(runs, texts, strict=True):
        resolved = run.folder / "resolved.yaml"
        if (
            resolved.is_file()
            and resolved.read_text(encoding="utf-8") != text
            and not _same(resolved, run.scene)
        ):
            raise run_folder.FolderError(
                f"{run.folder}: holds a case that was made with other settings; take another --out"
            )
    results = []
    for run, text in zip(runs, texts, strict=True):
        run.folder.mkdir(parents=True, exist_ok=True)
        if run_record.read(run.folder) is None:
            run_record.write(
                run.folder, run_record.new("run", adopted=(run.folder / batch.RESULT).is_file())
            )
        run_folder.write_bytes(run.folder / "resolved.yaml", text.encode())
        results.append(batch.stored(run) or Result.empty(run.scene.track, run.scene.start))
    return results


def _same(resolved: Path, scene: Scene) -> bool:
    """Return whether a resolved scene file of an earlier version means the same scene.

    Keys that it lacks count with their defaults.
    """
    try:
        before = scene_file.read_scene(resolved)
    except SceneError:
        return False

    def physics(scene: Scene) -> dict[str, Any]:
        return {
            key: value
            for key, value in scene.to_dict().items()
            if key not in ("name", "title", "description")
        }

    return physics(before) == physics(scene)


def solve_all(
    runs: Sequence[Run],
    results: list[Result],
    workers: int,
    name: str,
    begun: Callable[[Run], object] = lambda run: None,
) -> Outcome:
    """Solve all missing cases on all cores, without pressure maps."""
    return batch.solve(runs, results, workers, name, mapped=False, begun=begun)


def case(reading: str, run: Run, result: Result, closed: bool | None = None) -> Case:
    """Compute the numbers of a solved run.

    Parameters
    ----------
    reading : str. Name of its reading.
    run : Run. The run.
    result : Result. Its result, of the whole track or of a part.
    closed : bool or None. Whether the steps are whole laps. Default: None, as the track is.
    """
    scene, rolled = run.scene, run.scene.track
    roughness, load, seed, length = varied(scene)
    energy = result.whole("release_energy")
    closed = rolled.closed if closed is None else closed
    sound = contact_sound(scene, energy, result.step, closed, result.solved_steps)
    hertz = (
        math.pi * closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus) ** 2
    )
    rate = len(sound.power) / sound.duration
    line_hz, line_db = article_line_level_db(
        sound.power, rate, scene.sound.distance_m, scene.sound.q
    )
    lines = sound_plots.Lines.audible(line_hz, line_db)
    mean_hz, mean_db = lines.mean
    weighting = a_weighting_db(lines.frequency_hz)
    band_w, a_weighted_w = _fluctuation(scene, sound)
    unfactored = uncertainty.level_uncertainty(
        sound.pressure,
        sound.sample_rate,
        sound.levels,
        own_factor=False,
        laps=result.steps / result.solved_steps,
    )
    return Case(
        reading=reading,
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=length,
        hardness_gpa=scene.plate.hardness_gpa,
        bodies=_bodies(scene),
        nodes_across=rolled.n_across,
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
    """Compute the rms [W] of the release power's fluctuation.

    The first result has the third octaves (31,), the second is A-weighted. Sound pressure is linear
    in the fluctuation of the intensity, and so in the fluctuation of the power. Both results are
    NaN if the sound has no level.
    """
    levels = sound.levels
    if not sound.factor or levels.laeq_db is None:
        return np.full(len(levels.third_octave_db), np.nan), math.nan
    watts = (
        sound.pressure / sound.factor * (4 * math.pi * scene.sound.distance_m**2 / scene.sound.q)
    )
    band_rms = np.sqrt(third_octave_mean_square(*line_spectrum(watts, sound.sample_rate)))
    known = [level_db is not None for level_db in levels.third_octave_db.values()]
    return np.where(known, band_rms, np.nan), level.a_weighted_rms(watts, sound.sample_rate)


def _number(value: float | None) -> float:
    """Replace None by NaN."""
    return math.nan if value is None else value


def power_level_db(power: Array | float, factor: int, distance_m: float = 1.0) -> Array:
    """Compute the level of a release power [W] at a distance: factor lg(P / (4 pi r^2 I_ref)).

    The factor is 10 as in the article's equation, or 20. 20 lg treats the power as an amplitude:
    its differences between cases are doubled, and its absolute value means nothing.
    """
    ratio = np.asarray(power, dtype=float) / (4 * math.pi * distance_m**2 * I_REF_W_M2)
    with np.errstate(divide="ignore"):
        return factor * np.log10(ratio)
