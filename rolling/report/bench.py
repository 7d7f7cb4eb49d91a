"""The folder of a bench: scene, scan, recordings and calibration.txt, and what it lacks.

A recording begins with its quantity, such as acceleration.wav or acceleration-2.wav, and the
recording of a background with `background-` before it. Each line of calibration.txt is a quantity
and what `--calibration` takes: `acceleration: tone.wav=10`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from acoustics.texts import printable
from rolling.kinds.run_folder import RESULT
from rolling.recordings.ball_records import lacking_channels
from rolling.recordings.recorded import FORMATS, PRESSURE, QUANTITIES, MeasuredQuantity
from rolling.recordings.recording_comparison import RecordingComparison, compare
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.solving import open_runs, solve_folder
from rolling.scene.file import read_as
from rolling.scene.messages import SceneError, nearest
from rolling.scene.scene import Scene
from rolling.scene.yaml_text import parse, read_text
from rolling.terminal.whole_files import FolderError, read_regular

CALIBRATION = "calibration.txt"
RUN = "run"  # folder of the run in the folder of a bench
BACKGROUND = "background"
SOUND_ENDINGS = (".wav", ".flac", ".ogg", ".mp3", ".aiff", ".aif")
SCENE_ENDINGS = (".yaml", ".yml")
HEIGHT_ENDINGS = (".npy", ".csv", ".xyz", ".x3p", ".sdf", ".sur", ".plu", ".al3d", ".vk4", ".vk6")
MAX_CALIBRATION = 100_000  # bytes of calibration.txt


class BenchRecording(NamedTuple):
    """Recording of a bench, its quantity, calibration and background."""

    path: Path
    quantity: MeasuredQuantity
    calibration: list[str]
    background: Path | None


class Bench(NamedTuple):
    """Scene and recordings of a bench."""

    folder: Path
    scene: Scene
    recordings: list[BenchRecording]


def read_bench(folder: Path) -> Bench:
    """Read the folder of a bench.

    Raises
    ------
    FolderError : something is missing; the message has a line for each thing, with what to do.
    """
    if not folder.is_dir():
        raise FolderError(f"{folder}: no folder; a bench is a folder with scene, scan, recordings")
    if (folder / RESULT).is_file():
        raise FolderError(f"{folder}: a run folder; name a RECORDING to compare it with")
    missing: list[str] = []
    lacking_of_recordings: list[str] = []
    recordings = _recordings(folder, lacking_of_recordings)
    # A contact force may be measured on a block, which has no bending waves.
    is_plate = not recordings or any(item.quantity.name != "force" for item in recordings)
    scene = _scene_of(folder, is_plate, missing)
    missing += lacking_of_recordings
    if scene is not None:
        missing += _lacking_scans(scene)
        missing += _lacking_channels(scene, recordings)
    if missing or scene is None:
        raise FolderError("\n".join(f"{folder}: {text}" for text in missing))
    return Bench(folder=folder, scene=scene, recordings=recordings)


def run_folder(bench: Bench) -> Path:
    """Return the folder of the run of a bench: the first that is new, or holds its scene."""
    number = 1
    while True:
        place = bench.folder / (RUN if number == 1 else f"{RUN}-{number}")
        try:
            folders.refuse_other(place, bench.scene)
        except FolderError:
            number += 1
        else:
            return place


def compare_recording(run: Run, item: BenchRecording) -> RecordingComparison:
    """Compare the run of a bench with one of its recordings."""
    return compare(
        run=run,
        path=item.path,
        calibration=item.calibration,
        background=item.background,
        quantity=item.quantity.name,
    )


class BenchResult(NamedTuple):
    """Name of a recording of a bench, and its comparison with the run."""

    name: str
    comparison: RecordingComparison


def compare_all(bench: Bench) -> list[BenchResult]:
    """Solve the run of a bench unless it is done, and compare it with each of its recordings.

    Raises
    ------
    FolderError : the run failed, or a recording cannot be compared.
    """
    place = run_folder(bench)
    failures = solve_folder(bench.scene, place)
    if failures:
        raise FolderError("; ".join(f"{place}: {reason}" for reason in failures.values()))
    (run,) = open_runs([folders.done_run(place, "compare")])
    return [
        BenchResult(name=item.path.name, comparison=compare_recording(run, item))
        for item in bench.recordings
    ]


def _files(folder: Path, endings: Sequence[str]) -> list[Path]:
    """Return the files of a folder with one of some endings."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in endings)


# ---- the scene


def _scene_of(folder: Path, is_plate: bool, missing: list[str]) -> Scene | None:
    """Return the scene of a folder; add what it lacks to the list, and return None, otherwise.

    The dimensions of a plate are asked for where it `is_plate`, whose bending is recorded.
    """
    files = _files(folder, SCENE_ENDINGS)
    if len(files) > 1:
        names = ", ".join(path.name for path in files)
        missing.append(f"{len(files)} scenes ({names}); keep one of them in the folder")
        return None
    if not files:
        missing.append(
            "no scene; `rolling init synthetic-bench` copies one to change: ball, plate, scan, load"
            " and speed"
        )
        missing += _no_scan(folder)
        return None
    try:
        data = parse(read_text(files[0]), str(files[0])).value
    except SceneError as error:
        missing += error.mistakes
        return None
    lacking: dict[str, str] = {}
    if isinstance(data, Mapping):
        lacking = _lacking_keys(data, folder, is_plate)
        missing += [f"{files[0].name}: {text}" for text in lacking.values()]
    try:
        scene = read_as(files[0], Scene)
    except SceneError as error:
        missing += [line for line in error.mistakes if not any(key in line for key in lacking)]
        return None
    if scene.sweep:
        missing.append(f"{files[0].name}: it has a sweep; a bench is one run, so take it out")
        return None
    return scene


def _lacking_scans(scene: Scene) -> list[str]:
    """Say which scans a scene names that are not there."""
    return [
        f"no scan at {printable(str(path))}, which the scene names; put the file there"
        for path in scene.height_paths.values()
        if not path.is_file()
    ]


def _lacking_keys(data: Mapping[str, Any], folder: Path, is_plate: bool) -> dict[str, str]:
    """Return what a scene lacks of a bench by its key, each with what to do."""

    def section(name: str) -> Mapping[str, Any]:
        value = data.get(name)
        return value if isinstance(value, Mapping) else {}

    sphere = section("sphere")
    plate = section("plate")
    lacking = {}
    if "radius_mm" not in sphere:
        lacking["sphere.radius_mm"] = "no dimension of the ball; measure it: sphere.radius_mm"
    if not {"density_kg_m3", "material"} & sphere.keys():
        lacking["sphere.density_kg_m3"] = (
            "no mass of the ball; weigh it, and give mass over volume: sphere.density_kg_m3, or its"
            " sphere.material"
        )
    if not {"density_kg_m3", "material"} & plate.keys():
        lacking["plate.density_kg_m3"] = (
            "no mass of the plate; weigh it, and give mass over volume: plate.density_kg_m3, or its"
            " plate.material"
        )
    sides = [name for name in ("length_mm", "width_mm", "thickness_mm") if plate.get(name) is None]
    if sides and is_plate:
        keys = ", ".join(f"plate.{name}" for name in sides)
        lacking["plate.thickness_mm"] = f"no dimensions of the plate; measure them: {keys}"
    if "dynamics" not in data:
        lacking["dynamics"] = "no motion; ball and plate move with the line: dynamics: {}"
    if section("surface").get("kind") != "file":
        lacking["surface.path"] = "; ".join(_no_scan(folder))
    return lacking


def _no_scan(folder: Path) -> list[str]:
    """Say that a folder has no scan, or that its scene does not name it."""
    scans = _files(folder, HEIGHT_ENDINGS)
    if scans:
        return [
            f"the scene does not take the scan; write surface: {{kind: file, path:"
            f" {printable(scans[0].name)}}}, with spacing_um where the file has none"
        ]
    return [
        "no scan of the surface; put its file (CSV, SUR, X3P, SDF, ...) into the folder, and write"
        " surface: {kind: file, path: NAME}"
    ]


# ---- recordings and calibration


def _recordings(folder: Path, missing: list[str]) -> list[BenchRecording]:
    """Return the recordings of a folder; add what they lack to the list."""
    sounds = _files(folder, SOUND_ENDINGS)
    calibration = _calibration(folder, missing)
    recordings = []
    for path in sounds:
        quantity = _quantity_in(path.name)
        if quantity is None:
            continue
        backgrounds = [
            other for other in sounds if other.stem.startswith(f"{BACKGROUND}-{quantity.name}")
        ]
        recordings.append(
            BenchRecording(
                path=path,
                quantity=quantity,
                calibration=calibration.get(quantity.name, []),
                background=backgrounds[0] if backgrounds else None,
            )
        )
    if not recordings:
        missing.append(
            "no recording; name its file by the quantity, such as acceleration.wav, of"
            f" {', '.join(QUANTITIES)} ({FORMATS})"
        )
    for quantity in dict.fromkeys(item.quantity for item in recordings):
        if quantity.name not in calibration:
            missing.append(_no_calibration(quantity))
    return recordings


def _quantity_in(name: str) -> MeasuredQuantity | None:
    """Return the quantity with which the name of a file begins; None if there is none."""
    for key, quantity in QUANTITIES.items():
        if name.lower().startswith(key):
            return quantity
    return None


def _no_calibration(quantity: MeasuredQuantity) -> str:
    """Say that a quantity has no calibration, and what to do."""
    tone = f"{quantity.name}: tone.wav=10, with its rms in {quantity.unit}"
    if quantity is PRESSURE:
        tone = f"{quantity.name}: tone.wav=94, with its level in dB re {quantity.reference_text}"
    return (
        f"no calibration of {quantity.name}; record a tone with the same chain, and write into"
        f" {CALIBRATION} the line {tone}; or {quantity.name}: 12.5, with the {quantity.unit} of"
        " full scale"
    )


def _calibration(folder: Path, missing: list[str]) -> dict[str, list[str]]:
    """Return the calibrations by quantity, a text for all channels or for each channel.

    A line that has a mistake counts as a calibration, and its mistake is added to the list.
    """
    path = folder / CALIBRATION
    try:
        content = read_regular(path, MAX_CALIBRATION)
    except FileNotFoundError:
        return {}
    except OSError as error:
        missing.append(f"{CALIBRATION}: not readable ({error.strerror or error})")
        return {}
    calibration: dict[str, list[str]] = {}
    for number, line in enumerate(content.decode("utf-8", "replace").splitlines(), start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        name, colon, value = text.partition(":")
        name = name.strip().lower()
        place = f"{CALIBRATION}:{number}"
        if name not in QUANTITIES or not colon or not value.strip():
            near = nearest(name, [*QUANTITIES])
            missing.append(
                f"{place}: got {printable(text)}{near}, allowed: a quantity and its calibration, as"
                " in acceleration: tone.wav=10"
            )
            continue
        if name in calibration:
            missing.append(f"{place}: {name} has a line already; keep one of them")
            continue
        calibration[name] = []
        for part in value.split(","):
            tone, equals, level = part.strip().rpartition("=")
            if not equals:
                calibration[name].append(part.strip())
                continue
            if not (folder / tone.strip()).is_file():
                missing.append(
                    f"{place}: no tone {printable(tone.strip())}; record it with the same chain,"
                    " and put its file into the folder"
                )
            calibration[name].append(f"{folder / tone.strip()}={level.strip()}")
    return calibration


def _lacking_channels(scene: Scene, recordings: Sequence[BenchRecording]) -> list[str]:
    """Say which quantities of recordings a scene has no channels of."""
    asked = [(channel.quantity, channel.of) for channel in scene.sound.channels or ()]
    lacking = []
    for quantity in dict.fromkeys(item.quantity for item in recordings):
        if quantity is PRESSURE or quantity.name in [name for name, _ in asked]:
            continue
        lacking.append(lacking_channels(quantity, [f"{name} of {of}" for name, of in asked]))
    return lacking
