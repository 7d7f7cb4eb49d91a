"""Pictures of README and docs show what this program computes, and pages state their numbers."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

import rolling
from acoustics.numbers import rounded
from rolling import __version__
from rolling.kinds.heard_sound import FileGain

ROOT = next(folder for folder in Path(__file__).parents if (folder / "pyproject.toml").exists())
sys.path.append(str(ROOT / "docs" / "_hooks"))

# isort: split, for these stand beside the docs
import drawn_pictures  # noqa: E402
import growth_picture  # noqa: E402
import picture_list  # noqa: E402
import picture_parts  # noqa: E402
import picture_sounds  # noqa: E402
import pictures  # noqa: E402
import speed_pictures  # noqa: E402

LARGEST = {".png": 300_000, ".svg": 60_000}  # bytes
CAPTIONED = [picture for picture in picture_list.ALL if picture.has_dark]
each_picture = pytest.mark.parametrize(
    "picture", picture_list.ALL, ids=lambda picture: picture.stem
)


def stored(picture: pictures.Picture) -> dict[str, Any]:
    """Return the JSON beside a picture."""
    path = picture_parts.PICTURES / f"{picture.stem}.json"
    assert path.is_file(), f"make it: python docs/_hooks/pictures.py {picture.name}"
    return json.loads(path.read_text(encoding="utf-8"))


def test_each_picture_has_a_command_and_is_small() -> None:
    made = {picture.path.name for picture in picture_list.ALL if picture.is_drawn}
    made |= {picture_parts.dark_twin(picture.path).name for picture in CAPTIONED}
    files = [path for path in picture_parts.PICTURES.iterdir() if path.suffix in LARGEST]
    assert {path.name for path in files} == made
    assert all(path.stat().st_size < LARGEST[path.suffix] for path in files)


@each_picture
def test_a_picture_is_of_this_version_and_of_the_scenes_as_they_are(
    picture: pictures.Picture,
) -> None:
    """Between releases a picture may be of the last one, and its scenes as they were."""
    content = stored(picture)
    if picture.is_drawn:
        assert content["picture_sha256"] == pictures.digest_of(picture.path), "of another JSON"
    if picture.has_dark:
        twin = picture_parts.dark_twin(picture.path)
        assert content["dark_sha256"] == pictures.digest_of(twin), "of another JSON"
    if ".dev" not in __version__:
        assert content["program"] == __version__, f"make it again: {content['command']}"
        assert content["scenes"] == pictures.digests(picture), (
            f"make it again: {content['command']}"
        )


@each_picture
def test_pages_state_the_numbers_of_a_picture(picture: pictures.Picture) -> None:
    content = stored(picture)
    assert content["numbers"]
    assert pictures.missing(content["pages"]) == {}


def test_equal_runs_have_equal_numbers_in_all_pictures() -> None:
    page, spectrum, table = map(stored, picture_list.ALL[:3])
    assert page["numbers"] == spectrum["numbers"] == table["numbers"]["quickstart"]


def test_a_number_that_a_page_does_not_state_is_missed() -> None:
    row = "|5 N|14.8 ± 99.9|70.2 ± 0.1|"
    heading = "The table shows\nboth  at 1 m"  # spaces and ends of lines are no difference
    assert pictures.missing({"README.md": [heading]}) == {}
    assert pictures.missing({"README.md": [heading, row]}) == {"README.md": [row]}


def test_texts_of_the_last_picture_are_renewed_where_they_stand_once() -> None:
    page = "|5 N|1.0|\n|20 N|2.0|\n2.0 and 2.0 dB\n"
    before = ["|5 N|1.0|", "|20 N|2.0|", "2.0"]
    now = ["|5 N|1.5|", "|20 N|2.5|", "2.5"]
    assert pictures.renewed(page, before, now) == "|5 N|1.5|\n|20 N|2.5|\n2.0 and 2.0 dB\n"
    assert pictures.renewed(page, before[:2], now) == page


@pytest.mark.parametrize("picture", CAPTIONED, ids=lambda picture: picture.stem)
def test_a_page_shows_a_picture_above_its_caption(picture: picture_parts.Picture) -> None:
    content = stored(picture)
    page = next(iter(content["pages"]))
    text = (ROOT / page).read_text(encoding="utf-8")
    link = f"](../scenarios/pictures/{picture.path.name})\n\n{content['caption']}\n"
    assert link in text, f"{page} lacks {link}"


@pytest.mark.parametrize(
    "picture", [picture for picture in CAPTIONED if picture.is_quick], ids=lambda x: x.stem
)
def test_the_program_makes_the_same_picture_again(
    picture: picture_parts.Picture, tmp_path: Path
) -> None:
    """Numbers and caption of pictures without a march are those of the program as it is."""
    content = stored(picture)
    shown = picture.make(tmp_path / picture.path.name)
    assert shown.numbers == content["numbers"]
    assert shown.caption == content["caption"]
    assert picture_parts.dark_twin(tmp_path / picture.path.name).is_file()


@pytest.mark.slow
def test_a_march_gives_the_numbers_of_its_picture_again(tmp_path: Path) -> None:
    """The contact is marched anew: a kept run would not know that the program has changed."""
    (picture,) = (picture for picture in CAPTIONED if picture.stem == "contact")
    run = rolling.simulate(picture.scenes["ball"].read(), workers=1, progress=False)
    ratio = rounded(100 * run.numbers.contact.plastic_ratio, 2)
    assert stored(picture)["numbers"]["yielding"] == f"{ratio} %"


# Their pictures show the output of a command, or the keys, of which the text before tells.
AFTER_THEIR_TEXT = {"index", "key-effects", "what-would-help", "which-finish-is-quieter"}


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda page: page.stem)
def test_a_page_with_pictures_begins_with_one(page: Path) -> None:
    """The question of the page comes first, and the picture before headings, code and tables."""
    blocks = page.read_text(encoding="utf-8").split("\n\n")
    if page.stem not in AFTER_THEIR_TEXT and any(block.startswith("![") for block in blocks):
        assert blocks[2].startswith("![")


def test_pictures_of_runs_have_players_on_the_site(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(picture_sounds, "IS_SHORT", False)
    played = [*picture_sounds.played_runs()]
    assert len({run.picture for run in played}) > 8 and len(played) > 20
    for run in played:
        stems = picture_sounds.PICTURE.findall((ROOT / run.page).read_text(encoding="utf-8"))
        assert run.picture in stems
        assert not run.scene.read().sweep  # of which no player would tell the run


def test_players_stand_below_their_picture() -> None:
    markdown = "![A](../scenarios/pictures/loads.svg)\n\n*What it shows.*\n"
    cards = {
        "loads": [
            {"file": "loads-1.mp3", "words": '5 N: "vibration", LAeq 15.2 dB(A)'},
            {"file": "loads-2.mp3", "words": "20 N: vibration, LAeq 10.6 dB(A)"},
        ]
    }
    shown = picture_sounds.with_players(markdown, cards, "for-noise-engineers.html")
    picture, players, caption = shown.strip().split("\n\n")
    assert picture == "![A](../scenarios/pictures/loads.svg)" and caption == "*What it shows.*"
    assert re.findall('src="([^"]+)"', players) == [
        "picture-sounds/loads-1.mp3",
        "picture-sounds/loads-2.mp3",
    ]
    assert "&quot;vibration&quot;, LAeq 15.2 dB(A)</p>" in players
    assert picture_sounds.ONE_GAIN in players
    assert picture_sounds.with_players(markdown, {}, "for-noise-engineers.html") == markdown


def test_sounds_of_a_page_have_one_gain() -> None:
    """Records that measure another quantity, and those of another page, have gains of their own."""

    def file(group: str, own: float) -> FileGain:
        return FileGain(f"{group}.wav", group, own, used=None, words=str)

    heard = [
        ("a", file("listen", 20.0)),
        ("a", file("listen", 5.0)),
        ("a", file("housing", 9.0)),
        ("b", file("listen", 40.0)),
    ]
    assert picture_sounds.page_gains(heard) == [5.0, 5.0, 9.0, 40.0]


def test_a_dark_page_has_light_ink_dark_paper_and_the_hues_of_a_light_one() -> None:
    light = '<svg a="b"><path fill="#ffffff" stroke="#000000"/><g fill="#000004"/><text>a</text>'
    dark = drawn_pictures.darkened(light, frozenset({"#000004"}))
    ink = dark.partition('stroke="')[2][:7]
    paper = dark.partition('path fill="')[2][:7]
    assert dark.startswith(f'<svg fill="{ink}" a="b">')  # of letters, which have no own colour
    assert min(_levels(ink)) > 200 and max(_levels(paper)) < 50
    assert 'g fill="#000004"' in dark
    red, green, blue = _levels(drawn_pictures.dark_colour("#0072b2"))
    assert red < green < blue and green > 0x72


def test_the_site_shows_the_twin_of_a_picture_on_a_dark_page() -> None:
    pytest.importorskip("mkdocs", reason="the extra `docs` is not installed")
    place = ROOT / "docs" / "_hooks" / "site.py"
    spec = importlib.util.spec_from_file_location("site_hook", place)
    assert spec is not None and spec.loader is not None
    site_hook = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(site_hook)
    both = "![A](pictures/model.svg#only-light)![A](pictures/model-dark.svg#only-dark)"
    for markdown, shown in (
        ("![A](../scenarios/pictures/model.svg)", both),
        ("![A](../scenarios/pictures/choice.png)", "![A](pictures/choice.png)"),
        ("[A](../scenarios/pictures/model.svg)", "[A](pictures/model.svg)"),
    ):
        assert site_hook.on_page_markdown(markdown, None, None, None) == shown


def test_the_time_at_an_error_lies_between_two_tolerances() -> None:
    """Half way in the logarithm of the error is half way in that of the time."""
    curve = [[1e-3, 1.0, 1e-10, 0.0], [1e-4, 10.0, 1e-12, 0.0]]
    assert speed_pictures.ms_at(curve, 1e-11) == pytest.approx(10**0.5)
    assert speed_pictures.ms_at(curve, 1e-12) == pytest.approx(10.0)
    assert speed_pictures.ms_at(curve, 1e-9) == 1.0
    assert speed_pictures.ms_at(curve, 1e-13) is None
    assert speed_pictures.ms_at([], 1e-9) is None


def test_the_time_at_some_nodes_in_contact_lies_between_two_contacts() -> None:
    """A power law keeps its power; nothing is told beyond the contacts that were measured."""
    nodes = (50.0, 3e3, 2e4, 2e5)
    points = [{"in_contact": n, "ms": 1e-3 * n**1.1, "own_ms": 1e-3 * n} for n in nodes]
    assert growth_picture.at_nodes(points, "ms", 1e3) == pytest.approx(1e-3 * 1e3**1.1)
    assert growth_picture.at_nodes(points, "ms", 1e4, over="own_ms") == pytest.approx(1e4**0.1)
    assert growth_picture.power_of(points) == pytest.approx(1.1)
    assert growth_picture.at_nodes(points, "ms", 20.0) is None
    unsolved = [*points[:-1], points[-1] | {"ms": None}]
    assert growth_picture.at_nodes(unsolved, "ms", 1e5) is None
    assert growth_picture.power_of(unsolved) is None


def _levels(colour: str) -> tuple[int, ...]:
    """Return red, green and blue of #rrggbb."""
    return tuple(bytes.fromhex(colour[1:]))
