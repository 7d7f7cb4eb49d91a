"""Scene to run folder: the only place that knows contact, sound and files.

A run is simulated, kept as it goes, and finished: sound, levels, plots, then a mark. Several runs of one scene (a sweep) share a
folder, their plots and a table.
"""

from __future__ import annotations

import platform
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib import metadata
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from acoustics import wav
from rolling import check, reference, scene_file, simulate, store, surface
from rolling.scenario import Scene, expand, run_name, track
from rolling.sound import ContactSound, contact_sound, middle_speeds
from rolling.store import Keeper, Result

PACKAGES = ("numpy", "scipy", "numba", "pyfftw", "soundfile", "matplotlib", "h5py", "pydantic")


@dataclass(frozen=True)
class Run:
    """One run of a scene: the values its sweep gave it, the scene they make, its folder."""

    values: dict[str, float]
    scene: Scene
    folder: Path

    @property
    def label(self) -> str:
        """What tells it from its neighbours in a plot: the swept values, or the load."""
        return ", ".join(_worded(key, value) for key, value in (self.values or {"rolling.load_n": self.load}).items())

    @property
    def load(self) -> float:
        return self.scene.rolling.load_n


@dataclass(frozen=True)
class Report:
    """What a command did: its folder, the runs with their summaries, the failures by run, and whether it was interrupted."""

    folder: Path
    runs: list[tuple[Run, dict[str, Any] | None]]
    failures: dict[str, str]
    interrupted: bool

    @property
    def exit_code(self) -> int:
        return 130 if self.interrupted else 1 if self.failures else 0


def run(
    scene_path: Path, overrides: Sequence[str] = (), out: Path | None = None, force: bool = False, workers: int = 0
) -> Report:
    """Run a scene file: every combination of its sweep, each into a run folder.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = scene_file.load(scene_path, overrides)
    for _, single in expand(scene):
        simulate.rolling_contact(single)  # a surface that cannot be had shows before anything is written
    folder = store.new_folder(Path("outputs") / scene.name, out, force)
    store.write_bytes(folder / "scene.yaml", scene_path.read_bytes())
    runs = _make_folders(folder, scene)
    results = [Result.empty(track(one.scene), one.scene.start) for one in runs]
    return _work(folder, runs, results, workers)


def resume(folder: Path, workers: int = 0) -> Report:
    """Go on with a run folder that was interrupted or killed; what is solved is not solved again.

    Raises
    ------
    FolderError : no run folder, or results that do not fit its scene.
    """
    runs = read_runs(folder)
    results = []
    for one in runs:
        result = Result.empty(track(one.scene), one.scene.start)
        if (one.folder / "result.h5").is_file():
            kept = store.load(one.folder / "result.h5")
            if (kept.steps, kept.solved_steps) != (result.steps, result.solved_steps):
                raise store.FolderError(f"{one.folder}: result.h5 has {kept.steps} steps, its scene {result.steps}")
            result = kept
        results.append(result)
    return _work(folder, runs, results, workers)


def resound(folder: Path, overrides: Sequence[str], out: Path | None = None, force: bool = False) -> Report:
    """New sound from stored runs, without solving: other speed, distance, q or gain.

    Raises
    ------
    FolderError : no run folder. SceneError : overrides that need a new solve or are not allowed.
    """
    stored = read_runs(folder)
    # All is read and checked before the new folder is made.
    scene = scene_file.resound(scene_file.load(folder / "resolved.yaml"), overrides)
    singles = expand(scene)
    if [values for values, _ in singles] != [one.values for one in stored]:
        raise store.FolderError(f"{folder}: its sweep varies a key of --set; resound the runs in it one by one")
    results = [store.load(one.folder / "result.h5") for one in stored]
    target = store.new_folder(Path("outputs") / scene.name, out, force)
    store.write_bytes(target / "scene.yaml", (folder / "scene.yaml").read_bytes())
    runs = _make_folders(target, scene)
    return _finish(target, runs, results, {}, False)


def read_runs(folder: Path) -> list[Run]:
    """The runs of a run folder.

    Raises
    ------
    FolderError : it is none.
    """
    if not (folder / "resolved.yaml").is_file():
        raise store.FolderError(f"{folder}: not a run folder (no resolved.yaml in it)")
    scene = scene_file.load(folder / "resolved.yaml")
    return [Run(values, single, folder / run_name(values)) for values, single in expand(scene)]


def _make_folders(folder: Path, scene: Scene) -> list[Run]:
    """The runs of a scene, each in a folder of its own with its resolved scene (the folder itself where there is one run)."""
    runs = [Run(values, single, folder / run_name(values)) for values, single in expand(scene)]
    for one in runs:
        one.folder.mkdir(exist_ok=True)
        # A single run can be resumed and resounded on its own: it says what it was given, too.
        if one.folder != folder:
            store.write_bytes(one.folder / "scene.yaml", (folder / "scene.yaml").read_bytes())
        store.write_bytes(one.folder / "resolved.yaml", scene_file.dump(one.scene).encode())
    store.write_bytes(folder / "resolved.yaml", scene_file.dump(scene).encode())
    return runs


def _work(folder: Path, runs: list[Run], results: list[Result], workers: int) -> Report:
    todo = [
        (number, first, last)
        for number, result in enumerate(results)
        for first, last in simulate.missing(result.solved_steps, result.series["release_energy"])
    ]
    keepers = [Keeper() for _ in runs]
    for one, result in zip(runs, results, strict=True):
        _keep(one, result)

    def finished(number: int, piece: simulate.Piece) -> None:
        results[number].add(piece)
        if keepers[number].due() or results[number].complete:
            began = time.monotonic()
            _keep(runs[number], results[number])
            keepers[number].wrote(time.monotonic() - began)

    total = sum(last - first for _, first, last in todo)
    with tqdm(total=total, unit="step", disable=None, desc=runs[0].scene.name) as bar:
        outcome = simulate.simulate([one.scene for one in runs], todo, workers or check.cores(), finished, bar.update)
    for one, result in zip(runs, results, strict=True):
        _keep(one, result)
    failures = {runs[number].label: reason for number, reason in outcome.failures.items()}
    return _finish(folder, runs, results, failures, outcome.interrupted)


def _keep(one: Run, result: Result) -> None:
    _, speeds = middle_speeds(one.scene, result.steps, result.step)
    store.save(one.folder / "result.h5", result, speeds, one.scene.name)


def _finish(
    folder: Path, runs: list[Run], results: list[Result], failures: dict[str, str], interrupted: bool
) -> Report:
    """Sound, numbers and plots of every run that has enough steps; of all together when there are several."""
    heard: list[tuple[Run, ContactSound]] = []
    done: list[tuple[Run, dict[str, Any] | None]] = []
    for one, result in zip(runs, results, strict=True):
        if result.done_steps < 2:
            done.append((one, None))
            continue
        began = time.perf_counter()
        steps = result.done_steps
        energy = result.whole("release_energy")[:steps]
        closed = result.complete and steps % result.solved_steps == 0 and track(one.scene).closed
        sound = contact_sound(one.scene, energy, result.step, closed)
        summary = summarize(one.scene, result, sound, time.perf_counter() - began)
        if not (one.folder / "result.h5").exists():  # new sound of a stored run
            _keep(one, result)
        _write_sound(one, sound)
        store.write_json(one.folder / "summary.json", summary)
        store.write_json(one.folder / "provenance.json", provenance(one.scene))
        heard.append((one, sound))
        done.append((one, summary))
    _write_plots(folder, runs, results, heard)
    if len(runs) > 1:
        store.write_json(
            folder / "sweep.json",
            [{"values": one.values, "folder": one.folder.name, "summary": summary} for one, summary in done],
        )
    if not failures and not interrupted and all(result.complete for result in results):
        for finished in {one.folder for one in runs} | {folder}:
            store.write_bytes(
                finished / store.FINISHED, (datetime.now(UTC).isoformat(timespec="seconds") + "\n").encode()
            )
    return Report(folder, done, failures, interrupted)


def summarize(scene: Scene, result: Result, sound: ContactSound, sound_seconds: float) -> dict[str, Any]:
    """Plain numbers of a run, by name; what has no sound is None. Of a partial run: of what is solved."""
    steps = result.done_steps
    series = {name: result.whole(name)[:steps] for name in simulate.STEP_SERIES}
    state = {name: result.whole(name)[: steps + 1] for name in simulate.STATE_SERIES}
    hertz_area = np.pi * reference.hertz_radius(scene.load, scene.radius, scene.contact_modulus) ** 2
    plastic = float(state["plastic_area"].mean())
    solved_time = series["step_time"][: result.solved_steps]
    return {
        "name": scene.name,
        "load_n": scene.load,
        "complete": result.complete,
        "steps": steps,
        "laeq_db": sound.levels.laeq_db,
        "level_db": sound.levels.level_db,
        "steady_level_db": sound.steady_level,
        "third_octave_db": sound.levels.third_octave_db,
        "third_octave_a_db": sound.levels.third_octave_a_db,
        "duration_s": sound.duration,
        "loops": sound.closed,
        "highest_frequency_hz": sound.highest,
        "factor_pa_per_w_m2": sound.factor,
        "release_power_mean_w": float(sound.power.mean()),
        "release_power_rms_w": float(sound.power.std()),
        "hertz_area_m2": float(hertz_area),
        "contact_area_mean_m2": float(state["contact_area"].mean()),
        "plastic_area_mean_m2": plastic,
        "plastic_ratio": plastic / float(hertz_area),
        "max_pressure_pa": float(state["max_pressure"].max()),
        "energy_balance_error": float(np.abs(series["energy_defect"]).max() / state["stored_energy"].max()),
        "residual_max": float(state["residual"].max()),
        "iterations_mean": float(state["iterations"].mean()),
        "convolutions_mean": float(state["convolutions"].mean()),
        "step_ms": float(np.median(solved_time) * 1e3),
        "seconds": float(solved_time.sum()),
        "sound_seconds": sound_seconds,
        "warnings": [f"{found.what}: {found.warning}" for found in check.findings(scene) if found.warning],
        "surface": asdict(surface.statistics(simulate.heights(scene), scene.spacing)),
    }


def provenance(scene: Scene) -> dict[str, Any]:
    """What made the numbers: versions, the state of the source, machine, seed."""
    source = Path(__file__).parent
    state: str | None = None
    if (source.parent / ".git").exists():
        git = ["git", "-C", str(source), "describe", "--always", "--dirty", "--abbrev=12"]
        try:
            state = subprocess.run(git, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            state = None
    return {
        "program": metadata.version("rolling-contact-noise"),
        "source": state,
        "python": platform.python_version(),
        "packages": {name: metadata.version(name) for name in PACKAGES},
        "machine": f"{platform.system()} {platform.machine()}, {check.cores()} processors",
        "seed": getattr(scene.surface, "seed", None),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _write_sound(one: Run, sound: ContactSound) -> None:
    s = one.scene.sound
    facts = (
        f"{one.scene.name}, {one.label}; distance {s.distance_m:g} m, q {s.q:g},"
        f" {sound.factor:.6g} Pa per W/m2 of fluctuation; {'loops' if sound.closed else 'faded at both ends'}"
    )
    wav.write_calibrated(one.folder / "signal.wav", sound.pressure, f"1.0 = 1 Pa; {facts}")
    gain = wav.listening_gain(sound.pressure)
    wav.write_listening(
        one.folder / "listen.wav", sound.pressure, gain, f"{gain:.6g} full scale per Pa, equal loudness; {facts}"
    )


def _write_plots(folder: Path, runs: list[Run], results: list[Result], heard: list[tuple[Run, ContactSound]]) -> None:
    from rolling import figures

    for one, sound in heard:
        result = results[runs.index(one)]
        figures.write_run(one.folder, one.scene, one.label, sound, result.snapshot)
    if len(heard) > 1:
        figures.write_comparison(folder, [(one.label, one.scene, sound) for one, sound in heard])
        swept = [key for key in runs[0].values if len({one.values[key] for one in runs}) > 1]
        if swept:
            _write_level_plot(folder, swept[0], heard)


def _write_level_plot(folder: Path, key: str, heard: list[tuple[Run, ContactSound]]) -> None:
    from rolling import figures

    def rest(item: tuple[Run, ContactSound]) -> str:
        return ", ".join(_worded(k, v) for k, v in item[0].values.items() if k != key)

    curves = {}
    for others, group in groupby(sorted(heard, key=rest), key=rest):
        members = sorted(group, key=lambda item: item[0].values[key])
        curves[others] = [(one.values[key], sound.levels.laeq_db, sound.levels.level_db) for one, sound in members]
    word, unit = _named(key)
    figures.write_levels(folder, heard[0][0].scene.name, f"{word} [{unit}]" if unit else word, curves)


_UNITS = {"m_s": "m/s", "um": "µm", "mm": "mm", "gpa": "GPa", "n": "N", "s": "s", "m": "m"}


def _named(key: str) -> tuple[str, str]:
    """Word and unit of a dotted key: rolling.load_n is load in N."""
    name = key.rpartition(".")[2]
    for suffix, unit in _UNITS.items():
        if name.endswith("_" + suffix):
            return name.removesuffix("_" + suffix).replace("_", " "), unit
    return name.replace("_", " "), ""


def _worded(key: str, value: float) -> str:
    word, unit = _named(key)
    return f"{word} {value:g} {unit}".rstrip()


def table(report: Report) -> str:
    """Levels and cost of every run, for the terminal."""
    head = ("run", "LAeq dB(A)", "level dB", "steady dB", "plastic ratio", "steps", "ms/step", "files")
    rows: list[tuple[str, ...]] = [head]
    for one, summary in report.runs:
        if summary is None:
            rows.append((one.label, *["-"] * 6, str(one.folder)))
            continue

        def db(name: str, summary: dict[str, Any] = summary) -> str:
            return "silent" if summary[name] is None else f"{summary[name]:.1f}"

        steps = f"{summary['steps']}" + ("" if summary["complete"] else " (partial)")
        rows.append(
            (
                one.label,
                db("laeq_db"),
                db("level_db"),
                db("steady_level_db"),
                f"{summary['plastic_ratio']:.3f}",
                steps,
                f"{summary['step_ms']:.1f}",
                str(one.folder),
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join(lines + _remarks([summary for _, summary in report.runs if summary is not None]))


def _remarks(summaries: list[dict[str, Any]]) -> list[str]:
    """The surfaces, and of each kind of warning the first."""
    surfaces = dict.fromkeys(
        f"surface: Ra {s['ra'] * 1e6:.4g} µm, Rq {s['rq'] * 1e6:.4g} µm, skewness {s['skewness']:.2f},"
        f" kurtosis {s['kurtosis']:.2f}, rms slope {s['rms_slope']:.3g}"
        for s in (summary["surface"] for summary in summaries)
    )
    warnings: dict[str, str] = {}
    for summary in summaries:
        for warning in summary["warnings"]:
            warnings.setdefault(warning.partition(":")[0], f"warning: {warning}")
    return ["", *surfaces, *warnings.values()]
