"""Effect of each key of a scene file on the level and the spectral centroid, on one base scene.

`python tests/benchmarks/key_effects.py` measures the changes of key_effects.toml with several seeds
of the surface, the same before and after, and writes the tables of docs/key-effects.md.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from recognition_study import centroid_hz
from scipy import stats

from rolling.ball_kinds.balls import KIND
from rolling.in_si.scene_surface import scene_surface
from rolling.kinds.run_folder import RunFolder
from rolling.results.run_result import Run, make_run
from rolling.run.executor import RunLoop
from rolling.run.pools import local_pool
from rolling.scene.file import dump, loads
from rolling.scene.scene import Scene
from rolling.terminal import progress

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "key-effects.md"
COMMAND = "python tests/benchmarks/key_effects.py"
STUDY = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
MEASURES = {"level": ("laeq_db", 1), "release": ("release_laeq_db", 1), "centroid": ("centroid", 0)}
MIN = {"level": 0.05, "release": 0.05, "centroid": 0.5}  # dB, dB, %: effects that round to 0
NAMED = 10  # largest effects in the first table
PROBABILITY = 0.95  # that an effect of zero stays within the bounds of the table
Overrides = Sequence[str]


class Effect(NamedTuple):
    """Change of a key, with the settings before and after it."""

    title: str  # of the section
    name: str
    change: str
    on: str  # name of the settings that the key needs
    before: Overrides
    after: Overrides

    @property
    def key(self) -> str:
        """Dotted key."""
        return _dotted(self.title, self.name)


def _dotted(title: str, name: str) -> str:
    section = title.partition(":")[0]
    return name if section == "Keys" else f"{section}.{name}"


def scene(overrides: Overrides, seed: int = 1, folder: Path = Path()) -> Scene:
    """Return the base scene with a seed and other settings."""

    def filled(text: str) -> str:
        return text.replace("SEED", str(seed)).replace("FOLDER", folder.as_posix())

    return loads(filled(STUDY["base"]), [*map(filled, overrides)])


def effects() -> list[Effect]:
    """List the effects of the study, section by section."""
    return [
        _effect(title, name, row)
        for title, names in STUDY["keys"].items()
        for name, rows in names.items()
        for row in (rows if isinstance(rows, list) else [rows])
        if "same" not in row
    ]


def unmeasured() -> dict[str, str]:
    """Return the reasons why keys are not measured, by dotted key."""
    return {
        _dotted(title, name): row["same"]
        for title, names in STUDY["keys"].items()
        for name, row in names.items()
        if "same" in row
    }


def _effect(title: str, name: str, row: Mapping[str, Any]) -> Effect:
    """Read an effect from its row."""
    on = row.get("on", "")
    before = STUDY["on"].get(on, [])
    key = _dotted(title, name)
    data: Any = scene(before).to_dict()
    setting = f"{key}={row['to']}"
    if title == "faults":
        (fault,) = data["surface"]["faults"]
        data = {"faults": fault}
        seeded = {"seed": "SEED"} if "seed" in fault else {}
        setting = f"surface.faults=[{_flow(fault | seeded | {name: row['to']})}]"
    for part in key.split("."):
        data = data.get(part, "absent") if isinstance(data, dict) else data
    values = row.get("from", data), row.get("shown", row["to"] or "absent")
    change = "→".join(_flow(value).replace(" ", "") for value in values)
    settings = [] if name == "kind" and "with" in row else [setting]
    return Effect(title, name, change, on, before, [*before, *row.get("with", []), *settings])


def _flow(value: Any) -> str:
    """Write a value as YAML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


# ---- files of heights


def write_files(folder: Path, seeds: Sequence[int]) -> None:
    """Write the height files of seeds [um]: a scan, a line of it, and a turn of the sphere."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        heights = 1e6 * _heights(1.0, 1000, seed)
        x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in heights.shape), indexing="ij")
        scan = heights + 1.0 * x + 0.5 * y + 0.5 * x**2  # tilt and form
        places = rng.choice(scan.size, 60, replace=False)
        scan.flat[places[:30]] += 2.0  # spikes
        scan.flat[places[30:]] = np.nan
        np.save(folder / f"scan-{seed}.npy", scan)
        np.save(folder / f"line-{seed}.npy", 1e6 * _heights(6.0, 256, seed)[:, 0])
        # Equal seeds would make its heights follow those of the plate.
        np.save(folder / f"turn-{seed}.npy", 0.5e6 * _heights(31.416, 256, 100 + seed))


def _heights(length_mm: float, width_um: float, seed: int) -> np.ndarray:
    """Return heights [m] of the surface of the base scene in another size."""
    size = [f"rolling.distance_mm={length_mm}", f"surface.width_um={width_um}"]
    return scene_surface(scene(size, seed)).heights


# ---- runs


def measured(scenes: Sequence[Scene], workers: int) -> list[dict[str, float]]:
    """Simulate scenes that share their marches, and return level and centroid of each."""
    numbers = dict[int, dict[str, float]]()
    with progress.begin(progress.Level.QUIET), progress.Bar(0.0, "", False) as bar:
        loop = RunLoop([KIND.marches(scene) for scene in scenes], KIND.march_store(), bar)
        with local_pool(workers, scenes) as pool:
            for number, (result,), _ in loop.finished_runs(pool):
                run = make_run(RunFolder({}, scenes[number], Path()), "", result)
                numbers[number] = _numbers(run)
                print(f"{len(numbers)} of {len(scenes)}", end="\r", file=sys.stderr, flush=True)
    for number, reason in loop.failures.items():
        print(f"{dump(scenes[number])}{reason}", file=sys.stderr)
    failed = dict.fromkeys(("laeq_db", "release_laeq_db", "centroid"), math.nan)
    return [numbers.get(number, failed) for number in range(len(scenes))]


def _numbers(run: Run) -> dict[str, float]:
    """Return levels [dB] and centroid [%] of a run; NaN where it is silent."""
    pressure = run.sound.pressure
    rate = run.sound.sample_rate
    numbers = {"centroid": math.nan}
    if pressure.any():
        numbers["centroid"] = 100 * math.log(centroid_hz(pressure, rate))
    own = run.numbers.of_record.laeq_db
    released = own
    if run.numbers.levels.vibration is not None:
        released = run.numbers.levels.released_power_at_listener_db
    for name, level in (("laeq_db", own), ("release_laeq_db", released)):
        numbers[name] = math.nan if level is None else level
    return numbers


def study(
    wanted: Sequence[Effect], seeds: Sequence[int], workers: int = 0, shorter: Overrides = ()
) -> pd.DataFrame:
    """Measure effects; return one row for each effect and seed, with the numbers of both scenes."""
    rows = []
    unique = dict[str, Scene]()
    with TemporaryDirectory() as name:
        folder = Path(name)
        if "FOLDER" in str(wanted):
            write_files(folder, [other for seed in seeds for other in (seed, int(f"1{seed}"))])
        for number, effect in enumerate(wanted):
            for seed in seeds:
                pair = []
                for settings in (effect.before, effect.after):
                    made = scene([*settings, *shorter], seed, folder)
                    pair.append(dump(made))
                    unique.setdefault(pair[-1], made)
                rows.append((number, seed, *pair))
        listed = dict(zip(unique, measured([*unique.values()], workers), strict=True))
    return pd.DataFrame(
        {
            "effect": number,
            "seed": seed,
            **{f"{name} before": value for name, value in listed[before].items()},
            **listed[after],
        }
        for number, seed, before, after in rows
    )


# ---- the page


class Change(NamedTuple):
    """Mean change of a measure over seeds, its standard error, and its largest magnitude."""

    mean: float
    error: float
    most: float
    bound: float  # of the magnitude of the mean, beyond which it is no scatter

    def text(self, digits: int) -> str:
        """Write a change, in bold where it is no scatter."""
        if math.isnan(self.mean):
            return "silent"
        if self.most == 0:
            return "0"
        mean = round(self.mean, digits)
        text = f"{mean:+.{digits}f}" if mean else f"{0:.{digits}f}"
        text += f"±{self.error:.{digits}f}" if math.isfinite(self.error) else ""
        return f"**{text}**" if abs(self.mean) > self.bound else text


def changes(frame: pd.DataFrame) -> Iterator[dict[str, Change]]:
    """Yield the changes of each effect by measure."""
    for _, rows in frame.groupby("effect", sort=True):
        number = len(rows)
        factor = stats.t.ppf((1 + PROBABILITY) / 2, number - 1) if number > 1 else math.nan
        result = {}
        for measure, (name, _) in MEASURES.items():
            difference = (rows[name] - rows[f"{name} before"]).to_numpy()
            if measure == "centroid":
                difference = 100 * np.expm1(difference / 100)
            error = difference.std(ddof=1) / math.sqrt(number) if number > 1 else math.nan
            bound = max(factor * error, MIN[measure])
            mean = difference.mean()
            most = np.abs(difference).max()
            result[measure] = Change(float(mean), float(error), float(most), float(bound))
        yield result


HEADS = "key", "change", "on", "level", "release", "centroid"


def tables(listed: Sequence[Effect], frame: pd.DataFrame) -> str:
    """Write the base scene, the largest effects, all effects, and the settings of their rows."""
    results = [*changes(frame)]
    rows = [_row(effect, result) for effect, result in zip(listed, results, strict=True)]
    numeric = [
        number
        for number, effect in enumerate(listed)
        if not effect.on and all(map(_is_number, effect.change.split("→")))
    ]
    numeric.sort(key=lambda number: -abs(results[number]["level"].mean))
    changing = [any(change.most != 0 for change in result.values()) for result in results]
    heard = {effect.key for effect, changes in zip(listed, changing, strict=True) if changes}
    none = dict.fromkeys(effect.key for effect in listed if effect.key not in heard)
    reasons = (f"`{key}`: {reason}" for key, reason in unmeasured().items())
    settings = [[name, _settings(listed)] for name, listed in STUDY["on"].items()]
    parts = [
        f"```yaml\n{STUDY['base'].strip().replace('SEED', '1')}\n```",
        _base_numbers(listed, frame),
        "## Largest effects",
        _table(HEADS, [rows[number] for number in numeric[:NAMED]]),
        "## All keys",
        _table(
            HEADS, [row for row, effect in zip(rows, listed, strict=True) if effect.key in heard]
        ),
        "## Keys without an effect",
        f"Measured, equal to the last bit: {', '.join(f'`{key}`' for key in none)}.",
        f"Not measured: {'; '.join(reasons)}.",
        "## Settings of rows",
        _table(("on", "settings"), settings),
    ]
    return "\n\n".join(parts)


def _row(effect: Effect, result: Mapping[str, Change]) -> list[str]:
    """Write the row of an effect."""
    texts = [result[measure].text(digits) for measure, (_, digits) in MEASURES.items()]
    return [f"`{effect.key}`", effect.change, effect.on, *texts]


def _base_numbers(listed: Sequence[Effect], frame: pd.DataFrame) -> str:
    """Write the numbers of the base scene with their standard deviation over seeds."""
    first = next(number for number, effect in enumerate(listed) if not effect.on)
    rows = frame[frame["effect"] == first]
    level = rows["laeq_db before"]
    release = rows["release_laeq_db before"]
    hertz = np.exp(rows["centroid before"] / 100)
    return (
        f"Over {len(rows)} seeds its level is {level.mean():.1f} ± {level.std():.1f} dB(A), its "
        f"release {release.mean():.1f} ± {release.std():.1f} dB(A), its centroid "
        f"{hertz.mean():.0f} ± {hertz.std():.0f} Hz (standard deviations)."
    )


def _settings(overrides: Overrides) -> str:
    """Write overrides without folders and seeds."""
    text = " ".join(overrides).replace("FOLDER/", "").replace("-SEED", "")
    return f"`{text.replace(', seed: SEED', '')}`"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Write a table in Markdown, without blanks."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"|{'|'.join(line)}|" for line in lines)


def write_page(text: str) -> None:
    """Replace the part of the page between its marks."""
    page = PAGE.read_text(encoding="utf-8")
    begin = f"<!-- effects: written by `{COMMAND}` -->"
    end = "<!-- end of effects -->"
    head, _, rest = page.partition(begin)
    tail = rest.partition(end)[2]
    PAGE.write_text(f"{head}{begin}\n\n{text}\n\n{end}{tail}", encoding="utf-8")


def main(argv: Sequence[str] | None = None) -> None:
    """Measure the effects, and write the page, or print the tables of some keys."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("keys", nargs="*", metavar="KEY", help="beginning of dotted keys")
    parser.add_argument("--seeds", type=int, default=STUDY["seeds"])
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--out", type=Path, help="CSV file of the numbers of every run")
    given = parser.parse_args(argv)
    begins = tuple(given.keys) or ("",)
    listed = [effect for effect in effects() if effect.key.startswith(begins)]
    began = time.perf_counter()
    frame = study(listed, range(1, given.seeds + 1), given.workers)
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)
    if given.out:
        frame.assign(effect=[listed[number].key for number in frame["effect"]]).to_csv(given.out)
    text = tables(listed, frame)
    if given.keys:
        print(text)
    else:
        write_page(text)


if __name__ == "__main__":
    main()
