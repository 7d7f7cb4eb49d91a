"""Numbers in files are read as they were written, and what a stranger wrote is judged."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from finished import VIBRATING, marched

import rolling as rc
from rolling.numbers import views
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.number_files import DIGITS, from_bytes, summary_of, to_bytes
from rolling.numbers.run_file import StoredBearing, StoredNumbers
from rolling.results.level_words import level_rows
from rolling.results.run_result import Run
from rolling.results.stored_numbers import MAX_NUMBERS, read_stored
from rolling.terminal.whole_files import FolderError

FOLDERS = Path(__file__).parents[1] / "data" / "folders_0_8_0"
# Together they have every group: release, motion, fall, passes, instrument, channels, listeners.
BALLS = (
    *("ball", "dynamics", "fall", "numbers_only/measured", "numbers_only/quickstart/load_n=20"),
    *("numbers_only/release_of_motion", "numbers_only/running_in"),
    "numbers_only/with_error_estimate",
)
BEARINGS = ("bearing", "numbers_only/faulty_bearing")
MOVING = ["dynamics.release=true", "rolling.distance_mm=0.16", "sound.loudness=true"]


@cache
def stored(name: str) -> StoredNumbers | StoredBearing:
    """Return the numbers of a folder of the test data."""
    if name in BEARINGS:
        return read_stored(FOLDERS / name)
    return read_stored(FOLDERS / name)


@cache
def moving() -> Run:
    """Return a run whose release is that of the moving load."""
    return marched(VIBRATING, MOVING)


# ---- what is written is read back


@pytest.mark.parametrize("name", [*BALLS, *BEARINGS])
def test_numbers_are_read_as_they_were_written(name: str) -> None:
    numbers = stored(name)
    content = to_bytes(numbers)
    again = from_bytes(type(numbers), content)
    assert again == numbers
    assert to_bytes(again) == content


def test_numbers_of_a_new_run_are_read_as_they_were_written() -> None:
    numbers = moving().numbers
    assert numbers.energy.moving_law_error_m is not None and numbers.ears is not None
    assert from_bytes(RunNumbers, to_bytes(numbers)) == numbers


# ---- the view for people


def values(content: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Yield path and value of everything in a JSON content."""
    yield path, content
    if isinstance(content, dict):
        for name, inner in content.items():
            yield from values(inner, (*path, name))
    elif isinstance(content, list):
        for number, inner in enumerate(content):
            yield from values(inner, (*path, number))


@pytest.mark.parametrize("name", [*BALLS, *BEARINGS])
def test_a_summary_is_short_and_its_bands_have_frequencies(name: str) -> None:
    view = json.loads(json.dumps(summary_of(stored(name).numbers)))
    for path, value in values(view):
        if isinstance(value, float):
            assert value == float(f"{value:.{DIGITS - 1}e}"), path
        if isinstance(value, list) and len(value) > 20 and isinstance(value[0], int | float | None):
            *parent, key = path
            beside = view
            for part in parent:
                beside = beside[part]
            assert key in ("frequency_hz", "mean_at_angles_n") or "frequency_hz" in beside, path


def test_a_folder_needs_its_numbers_and_not_their_view(tmp_path: Path) -> None:
    folder = rc.save_run(moving(), tmp_path / "run", report=False)
    view = json.loads((folder / "summary.json").read_text())
    assert view["format"] == StoredNumbers.format and view["kind"] == "ball"
    (folder / "summary.json").write_text("of a person who edits")
    assert rc.open_run(folder).numbers.vibration == moving().vibration
    (folder / "summary.json").unlink()  # it is written last, and tells that the run is whole
    with pytest.raises(FolderError, match="not done"):
        rc.open_run(folder)


# ---- what a stranger wrote

LATER = frozenset(range(2, 100))
ODD = ("odd", [None], {"a": 1}, True, None, 1e308, -5, "\x00", [[[]]])


def mutations(content: dict[str, Any]) -> Iterator[tuple[tuple[Any, ...], bytes]]:
    """Yield a path and the content with an odd value there, or without it; one for each path."""
    whole = json.dumps(content)
    # Of lists the first two entries stand for all.
    paths = [path for path, _ in values(content) if path and not LATER.intersection(path)]
    for number, path in enumerate(paths):
        changed = json.loads(whole)
        place = changed
        for part in path[:-1]:
            place = place[part]
        odd = number % (len(ODD) + 1)
        if odd == len(ODD):
            del place[path[-1]]
        else:
            place[path[-1]] = ODD[odd]
        yield path, json.dumps(changed).encode()


@pytest.mark.parametrize("name", ["dynamics", "numbers_only/with_error_estimate"])
def test_a_strangers_numbers_are_refused_by_name_or_have_their_types(name: str) -> None:
    refused = 0
    for path, content in mutations(json.loads(to_bytes(stored(name)))):
        try:
            read = from_bytes(StoredNumbers, content)
        except ValueError as error:
            refused += 1
            named = [str(part) for part in path if isinstance(part, str)]
            assert any(part in str(error) for part in named), (path, error)
            assert len(str(error)) < 300
            continue
        assert from_bytes(StoredNumbers, to_bytes(read)) == read, path
        assert repr(read.numbers) and level_rows(read.numbers) is not None
        assert views.columns(read.numbers) and summary_of(read.numbers)
    assert refused > 100


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not readable"),
        (b"\xff\xfe", "not readable"),
        (b"[]", "not readable"),
        (b"{}", "not readable .*numbers of the kind None"),
        (b'{"format": 1, "kind": "ball", "numbers": ' + b"[" * 100_000, "not readable"),
        (b'{"format": 1' + b" " * MAX_NUMBERS + b"}", "not readable"),
    ],
    ids=["empty", "no text", "a list", "nothing", "deep", "large"],
)
def test_what_is_no_numbers_is_refused_in_one_message(
    content: bytes, words: str, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "numbers.json").write_bytes(content)
    with pytest.raises(FolderError, match=words) as error:
        read_stored(folder)
    assert "numbers.json" in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_a_number_that_is_not_finite_is_named(number: str) -> None:
    content = json.loads(to_bytes(moving().numbers))
    content["contact"]["max_pressure_pa"] = "here"
    text = json.dumps(content).replace('"here"', number)
    with pytest.raises(ValueError, match=r"contact\.max_pressure_pa"):
        from_bytes(RunNumbers, text.encode())


def test_numbers_of_another_kind_of_run_are_refused(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "numbers.json").write_bytes(to_bytes(stored("bearing")))
    with pytest.raises(FolderError, match="numbers of the kind bearing"):
        read_stored(folder, "ball")
