"""Players of the runs that pictures show, beside the pictures in the site.

The entries of pictures.toml with `plays` have them. The sounds are made when the site is built, and
all sounds of a page that measure the same share a gain, so that a louder one is louder.
"""

from __future__ import annotations

import html
import json
import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from build_cache import cached_build, compressed
from picture_parts import PictureScene, kept_run

TABLE = Path(__file__).with_name("pictures.toml")
PICTURE = re.compile(r"^!\[[^\]]*\]\((?:\.\./)+scenarios/pictures/([\w-]+)\.\w+\)$", re.MULTILINE)
FOLDER = "picture-sounds"
CARDS = "cards.json"
ONE_GAIN = "The sounds of this page have one gain: a louder one is louder."
# With ROLLING_SHORT_SITE in the environment, as in the tests, these pictures alone have players, of
# runs on shorter tracks.
IS_SHORT = bool(os.environ.get("ROLLING_SHORT_SITE"))
SHORT = {"loads": ["rolling.duration_s=0.005", "surface.spacing_um=4", "sound.listen_s=1"]}


class PlayedRun(NamedTuple):
    """A run that is played beside a picture.

    page : str. The page of the picture, such as docs/theory.md.
    picture : str. The name of the picture.
    label : str. Its label on the picture; empty for the only run.
    scene : PictureScene. Its scene.
    """

    page: str
    picture: str
    label: str
    scene: PictureScene


def on_files(files, config):
    """Add the sounds."""
    from mkdocs.structure.files import File

    for path in sorted(site_sounds().glob("*.mp3")):
        files.append(File.generated(config, f"{FOLDER}/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Put the players of a picture below it."""
    cards = json.loads((site_sounds() / CARDS).read_text(encoding="utf-8"))
    return with_players(markdown, cards, page.url)


def with_players(markdown: str, cards: Mapping[str, list[dict[str, str]]], url: str) -> str:
    """Return the Markdown of a page with the players of each of its pictures."""
    above = "../" * url.count("/")

    def players(match: re.Match[str]) -> str:
        of_picture = cards.get(match[1], [])
        if not of_picture:
            return match[0]
        rows = [_player(card, above) for card in of_picture]
        note = f"<p>{ONE_GAIN}</p>\n" if len(rows) > 1 else ""
        return "\n".join([match[0], "", '<div class="players">', *rows, f"{note}</div>"])

    return PICTURE.sub(players, markdown)


def _player(card: Mapping[str, str], above: str) -> str:
    """Return the player of a run with what it is and its level, as HTML."""
    words = html.escape(card["words"])
    source = f"{above}{FOLDER}/{card['file']}"
    player = f'<audio controls preload="none" aria-label="{words}" src="{source}"></audio>'
    return f"<p>{player} {words}</p>"


# ---- sounds


def site_sounds() -> Path:
    """Return the folder of the sounds that the site plays, and what they are."""
    content = Path(__file__).read_bytes() + TABLE.read_bytes() + bytes([IS_SHORT])
    return cached_build("picture-sounds/site", content, _make_sounds)


def played_runs() -> Iterator[PlayedRun]:
    """Yield the runs of the pictures that have players."""
    entries = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    for picture, entry in entries.items():
        if not entry.get("plays", False) or (IS_SHORT and picture not in SHORT):
            continue
        for label, scene in entry["scenes"].items():
            settings = [*scene.get("settings", ())]
            if IS_SHORT:
                settings += SHORT[picture]
            is_alone = len(entry["scenes"]) == 1
            yield PlayedRun(
                page=entry["page"],
                picture=picture,
                label="" if is_alone else label,
                scene=PictureScene(scene["name"], settings),
            )


def _make_sounds(folder: Path) -> None:
    """Run the scenes, and write the sound that each plays first, with what it is."""
    from rolling.kinds.registry import kind_of
    from rolling.results.stored_numbers import read_stored

    folder.mkdir(parents=True)
    runs = list(played_runs())
    sounds = []
    files = []
    for played in runs:
        run = kept_run(played.scene.read())
        kind = kind_of(run.scene)
        sound = kind.sounds(run)[0]
        gains = kind.file_gains(read_stored(run.folder))
        sounds.append(sound)
        files.append((played.page, next(file for file in gains if file.file == sound.file)))
    cards: dict[str, list[dict[str, str]]] = {}
    for played, sound, gain in zip(runs, sounds, page_gains(files), strict=True):
        of_picture = cards.setdefault(played.picture, [])
        file = f"{played.picture}-{len(of_picture) + 1}.mp3"
        (folder / file).write_bytes(compressed(sound.wav(gain)))
        words, _, _ = sound.words.partition(";")  # the rest says how the record was made
        if played.label:
            words = f"{played.label}: {words}"
        of_picture.append({"file": file, "words": words})
    (folder / CARDS).write_text(json.dumps(cards), encoding="utf-8")


def page_gains(files: Sequence[tuple[str, Any]]) -> list[float]:
    """Return the gain of each sound [full scale per unit]: one for each page and group of sounds.

    `files` are pairs of a page and the FileGain of a sound.
    """
    from rolling.kinds.heard_sound import common_gains

    gains = {}
    for page, _ in files:
        gains[page] = common_gains(file for other, file in files if other == page)
    return [gains[page][file.group] for page, file in files]
