"""Pictures of README and docs show what this program computes, and pages state their numbers."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from rolling import __version__

ROOT = next(folder for folder in Path(__file__).parents if (folder / "pyproject.toml").exists())
sys.path.append(str(ROOT / "docs" / "_hooks"))

import pictures  # noqa: E402  # beside the docs

TIMES = "step-cost"  # of a machine, whatever the version; a benchmark draws it
LARGEST = 300_000  # bytes
each_picture = pytest.mark.parametrize("picture", pictures.ALL, ids=lambda picture: picture.stem)


def stored(picture: pictures.Picture) -> dict[str, Any]:
    """Return the JSON beside a picture."""
    path = pictures.PICTURES / f"{picture.stem}.json"
    assert path.is_file(), f"make it: python docs/_hooks/pictures.py {picture.name}"
    return json.loads(path.read_text(encoding="utf-8"))


def test_each_picture_has_a_command_and_is_small() -> None:
    drawn = {picture.stem for picture in pictures.ALL if picture.is_drawn}
    files = sorted(pictures.PICTURES.glob("*.png"))
    assert {path.stem for path in files} == {*drawn, TIMES}
    assert max(path.stat().st_size for path in files) < LARGEST


@each_picture
def test_a_picture_is_of_this_version_and_of_the_scenes_as_they_are(
    picture: pictures.Picture,
) -> None:
    """Between releases a picture may be of the last one, and its scenes as they were."""
    content = stored(picture)
    if picture.is_drawn:
        path = pictures.PICTURES / f"{picture.stem}.png"
        assert content["picture_sha256"] == pictures.digest_of(path), "it has another JSON"
    if ".dev" not in __version__:
        assert content["program"] == __version__, f"make it again: {content['command']}"
        assert content["scenes"] == picture.digests, f"make it again: {content['command']}"


@each_picture
def test_pages_state_the_numbers_of_a_picture(picture: pictures.Picture) -> None:
    content = stored(picture)
    assert content["numbers"]
    assert pictures.missing(content["pages"]) == {}


def test_equal_runs_have_equal_numbers_in_all_pictures() -> None:
    page, spectrum, table = map(stored, pictures.ALL[:3])
    assert page["numbers"] == spectrum["numbers"] == table["numbers"]["quickstart"]


def test_a_number_that_a_page_does_not_state_is_missed() -> None:
    row = "|5 N|14.8 ± 99.9|70.2 ± 0.1|"
    heading = "The table shows\nboth  at 1 m"  # spaces and ends of lines are no difference
    assert pictures.missing({"README.md": [heading]}) == {}
    assert pictures.missing({"README.md": [heading, row]}) == {"README.md": [row]}
