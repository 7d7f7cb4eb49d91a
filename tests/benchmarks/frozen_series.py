"""Digests of all series and the values of all numbers, to see what a change of the program changes.

`python tests/benchmarks/frozen_series.py write FILE --short` computes the scenes of
frozen_scenes.toml, one of each kind and law: runs of balls and bearings, their checks, choices,
runs that are killed and go on, and recordings that are compared with runs. Without `--short` it
also computes every run of all scenes of the library, those of balls shortened to at most
SHORTENED_S seconds of rolling. FILE gets a digest of each series, each value without rounding, and
the words of verdicts.

`... compare FILE` does so again and prints what differs. Series, values and verdicts are counted
apart, and it exits with 1 if a series or a value differs. `--only WORD...` takes the labels that
hold one of the words.

frozen_numbers.toml tells where a number stands, so that every version of the program gives the same
names. With PYTHONPATH=CHECKOUT the program of another checkout is frozen. Digests are equal on the
same machine with the same packages only.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from frozen_numbers import Frozen, unread
from scipy.io import wavfile

import acoustics.wav
import rolling as rc
from rolling.kinds.registry import name_of_file
from rolling.scene import library

SCENES = Path(__file__).with_name("frozen_scenes.toml")
SHORTENED_S = 0.03
SKIPPED = {"measured-surface"}  # its heights are made by a command that the scene names
RATE_HZ = acoustics.wav.SAMPLE_RATE_HZ
RECORDING_S = 1.0
NOISE = 0.1  # rms of the noise in a recording over that of the run
KEPT_PIECES = 2  # and marches of a bearing, with which a run is killed
POLL_S = 0.005
KINDS = ("series", "values", "verdicts")
NUMBERS = {"ball": "run", "bearing": "bearing"}  # tables of frozen_numbers.toml by kind of scene
CHOICES = {"ball": "choice", "bearing": "bearing_choice"}
Table = dict[str, dict[str, Any]]  # by label: what is frozen, by kind and name


class Job(NamedTuple):
    """Something to freeze: its kind, its name, and its scene with all that it needs."""

    kind: str
    name: str
    entry: Mapping[str, Any]

    @property
    def label(self) -> str:
        """Name of the job in the file."""
        return f"{self.kind}/{self.name}"

    @property
    def scene_kind(self) -> str:
        """Name of the kind of its scene."""
        return name_of_file(self.entry["scene"])


# ---- what is computed


def short_jobs() -> list[Job]:
    """Return the jobs of the short set; runs come last, because they are short and fill gaps."""
    table = tomllib.loads(SCENES.read_text(encoding="utf-8"))
    jobs = [
        Job(kind, name, entry) for kind, entries in table.items() for name, entry in entries.items()
    ]
    return sorted(jobs, key=lambda job: job.kind in ("runs", "recordings"))


def library_jobs() -> list[Job]:
    """Return a job for every run of the scenes of the library."""
    jobs = []
    for name in sorted(library.scenes()):
        # The other readings of the article differ in numbers of the plate only.
        is_repeated = name.startswith("lee2025") and "as-stated" not in name
        if name in SKIPPED or is_repeated:
            continue
        entry = {"scene": name, "words": []}
        for number, _ in enumerate(whole_scene(Job("library", name, entry)).runs()):
            jobs.append(Job("library", f"{name}/{number}", entry | {"run": number}))
    return jobs


def whole_scene(job: Job) -> Any:
    """Return the scene of a job, of whatever kind."""
    return rc.read_scene(job.entry["scene"], job.entry["words"])


def scene_of(job: Job) -> Any:
    """Return the scene of a job, or one run of a scene of the library, shortened."""
    scene = whole_scene(job)
    if "run" not in job.entry:
        return scene
    _, scene = scene.runs()[job.entry["run"]]
    duration_s = scene.rolling.duration_s if isinstance(scene, rc.Scene) else None
    if duration_s is not None and duration_s > SHORTENED_S:
        return scene.with_({"rolling.duration_s": SHORTENED_S})
    return scene


def frozen_job(job: Job) -> Table:
    """Compute a job, and return what is frozen of it by label."""
    began = time.process_time()
    try:
        found = dict(FREEZE[job.kind](job))
    except (rc.ContactError, rc.SceneError) as error:
        found = {job.label: Frozen({}, {"error": type(error).__name__}, {})}
        print(f"{job.label}: {error}", file=sys.stderr)
    seconds = time.process_time() - began
    print(f"{job.label}: {seconds:.1f} s of this process", file=sys.stderr, flush=True)
    return {label: frozen._asdict() for label, frozen in found.items()}


# ---- runs and their checks


def freeze_run(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield a run, and what a check of its scene foresees."""
    scene = scene_of(job)
    yield f"{job.label}: check", check(scene)
    run = rc.simulate(scene, workers=1, progress=False)
    yield job.label, of_run(run, NUMBERS[job.scene_kind])


def of_run(run: Any, kind: str) -> Frozen:
    """Return what is frozen of a run, and name its numbers that the table has not."""
    lacking = unread(run, kind)
    if lacking:
        print(f"not frozen, as frozen_numbers.toml has no place for them: {', '.join(lacking)}")
    return Frozen.of(run, kind)


def freeze_sweep(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield all runs of a sweep, which share marches."""
    runs = rc.simulate_sweep(scene_of(job), workers=1, progress=False)
    for values, run in runs.items():
        yield f"{job.label}: {values}", of_run(run, "run")


def check(scene: Any) -> Frozen:
    """Return the forecasts of a check."""
    findings = scene.check()
    verdicts = expected_words(scene, findings) if isinstance(scene, rc.Scene) else {}
    return Frozen.of_check(findings, verdicts)


def expected_words(scene: Any, findings: Any) -> dict[str, str]:
    """Return the verdict that a check of a scene of balls expects of each run, in a word."""
    if hasattr(findings, "quantities"):
        return {name: run.leading.judged.word for name, run in findings.quantities.items()}
    from rolling.check import level_doubts  # of version 0.8, which has a function for it

    runs = zip(scene.runs(), findings.doubts.items(), strict=True)
    return {
        name: level_doubts.expected(run.scene, doubts).severity.word for run, (name, doubts) in runs
    }


# ---- choices


def freeze_choice(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield the answer which of the runs of a scene is quieter."""
    scene = scene_of(job)
    pairs = job.entry.get("pairs")
    choice = rc.choose(scene, pairs=pairs, workers=1, progress=False)
    yield job.label, Frozen.of(choice, CHOICES[job.scene_kind])


def freeze_improvements(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield how much louder larger values of a drawing are."""
    found = rc.sensitivities(
        scene_of(job),
        keys=job.entry["keys"],
        pairs=job.entry["pairs"],
        workers=1,
        progress=False,
    )
    yield job.label, Frozen.of(found, "improvements")


def freeze_limit(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield the coarsest value with which a scene stays below a level."""
    low, high = job.entry["between"]
    found = rc.coarsest_below(
        scene_of(job),
        key=job.entry["key"],
        level_db=job.entry["level_db"],
        between=(low, high),
        seeds=job.entry["seeds"],
        workers=1,
        progress=False,
    )
    yield job.label, Frozen.of(found, "limit")


# ---- runs that go on


def freeze_resumed(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield a run that is killed midway and goes on, and whether it is as without that."""
    with tempfile.TemporaryDirectory() as parent:
        whole = Path(parent) / "whole"
        stopped = Path(parent) / "stopped"
        _command(job, whole).wait()
        _kill_midway(job, stopped)
        _command(job, stopped).wait()
        frozen, undisturbed = (_stored(job, folder) for folder in (stopped, whole))
    frozen.values["as without an interruption"] = frozen == undisturbed
    yield job.label, frozen


def _command(job: Job, out: Path) -> subprocess.Popen[bytes]:
    """Start the command that runs the scene of a job into a folder."""
    words = [job.entry["scene"], "--out", str(out), "--no-report", "-q", "--workers", "1"]
    for word in job.entry["words"]:
        words += ["--set", word]
    place = str(Path(rc.__file__).parents[1])
    return subprocess.Popen(
        [sys.executable, "-m", "rolling", "run", *words],
        env=os.environ | {"PYTHONPATH": place},
        stdout=subprocess.DEVNULL,
        start_new_session=True,  # so that its processes end with it
    )


def _kill_midway(job: Job, out: Path) -> None:
    """Run a scene until some pieces are kept, and kill the command and its processes."""
    process = _command(job, out)
    while process.poll() is None and len(list(out.rglob("*.npz"))) < KEPT_PIECES:
        time.sleep(POLL_S)
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    if (out / "summary.json").is_file():
        sys.exit(f"{job.label}: it was done before it was killed; choose a longer track")


def _stored(job: Job, folder: Path) -> Frozen:
    """Return what is frozen of the run of a folder."""
    return of_run(rc.open_run(folder), NUMBERS[job.scene_kind])


# ---- recordings


def freeze_recording(job: Job) -> Iterator[tuple[str, Frozen]]:
    """Yield the comparison of a run with a recording: the record of the run beside noise."""
    from rolling.recordings.recording_comparison import compare as compare_recording

    run = rc.simulate(scene_of(job), workers=1, progress=False)
    quantity = job.entry["quantity"]
    channels = [channel for channel in run.channels if channel.quantity == quantity]
    records = [channel.samples for channel in channels] or [run.sound.pressure]
    length = round(RECORDING_S * RATE_HZ)
    noise = np.random.default_rng(1)
    recorded = [
        np.resize(record, length) + NOISE * record.std() * noise.standard_normal(length)
        for record in records
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recording.wav"
        wavfile.write(path, RATE_HZ, np.stack(recorded, 1).astype(np.float32))
        comparison = compare_recording(
            run=run,
            path=path,
            calibration=job.entry.get("calibration"),
            quantity=quantity,
        )
    yield job.label, Frozen.of_comparison(comparison.table)


FREEZE = {
    "runs": freeze_run,
    "bearings": freeze_run,
    "sweeps": freeze_sweep,
    "library": freeze_run,
    "choices": freeze_choice,
    "improvements": freeze_improvements,
    "limits": freeze_limit,
    "resumed": freeze_resumed,
    "recordings": freeze_recording,
}


# ---- the file


def frozen_table(jobs: Sequence[Job], workers: int) -> Table:
    """Compute jobs, each in one process, and return what is frozen of them by label."""
    for name in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
        os.environ[f"{name}_NUM_THREADS"] = "1"  # of the processes, which begin anew
    table: Table = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for found in pool.map(frozen_job, jobs):
            table.update(found)
    return table


def machine() -> dict[str, str]:
    """Return what digests depend on beside the program: processor and numpy."""
    return {"machine": f"{platform.machine()} {platform.processor()}", "numpy": np.__version__}


def job_label(label: str) -> str:
    """Return the label of the job that an entry of a table is of."""
    return label.partition(":")[0]


class Changes(NamedTuple):
    """What differs between two tables: lines to print by kind."""

    series: list[str]
    values: list[str]
    verdicts: list[str]

    @property
    def counts(self) -> str:
        """How many series, values and verdicts differ, in words."""
        series, values, verdicts = map(len, self)
        return f"{series} series changed, {values} values changed, {verdicts} verdicts changed"

    @property
    def exit_code(self) -> int:
        """1 if a series or a value differs, otherwise 0; words of verdicts are listed only."""
        return int(bool(self.series or self.values))


def changes(before: Table, now: Table) -> Changes:
    """Return what differs between two tables."""
    found = Changes([], [], [])
    for label in sorted(before.keys() | now.keys()):
        for kind, lines in zip(KINDS, found, strict=True):
            old = before.get(label, {}).get(kind, {})
            new = now.get(label, {}).get(kind, {})
            for name in sorted(old.keys() | new.keys()):
                if old.get(name) != new.get(name):
                    lines.append(f"{label}: {name}: {old.get(name)} -> {new.get(name)}")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Write what is frozen, or compare it with that of a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("action", choices=["write", "compare"])
    parser.add_argument("file", type=Path)
    parser.add_argument("--short", action="store_true", help="the short set only")
    parser.add_argument("--only", nargs="+", metavar="WORD", default=[""], help="words of labels")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="number of processes")
    given = parser.parse_args(arguments)
    jobs = short_jobs() + ([] if given.short else library_jobs())
    jobs = [job for job in jobs if any(word in job.label for word in given.only)]
    now = frozen_table(jobs, given.workers)
    if given.action == "write":
        content = {"of": machine(), "frozen": now}
        given.file.write_text(json.dumps(content, indent=1), encoding="utf-8")
        print(f"{given.file}: {counted(now)}")
        return 0
    content = json.loads(given.file.read_text(encoding="utf-8"))
    if content["of"] != machine():
        print(f"Digests may differ: the file is of {content['of']}, and this is {machine()}.")
    labels = {job.label for job in jobs}
    before = {label: old for label, old in content["frozen"].items() if job_label(label) in labels}
    found = changes(before, json.loads(json.dumps(now)))
    for kind, lines in zip(KINDS, found, strict=True):
        for line in lines:
            print(f"{kind}: {line}")
    print(counted(now))
    print(found.counts)
    return found.exit_code


def counted(table: Table) -> str:
    """Say how much is frozen."""
    counts = {kind: sum(len(frozen[kind]) for frozen in table.values()) for kind in KINDS}
    numbers = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    return f"{len(table)} runs, checks, choices and comparisons with {numbers}"


if __name__ == "__main__":
    sys.exit(main())
