"""Make the pictures of README and docs, each with a JSON of the numbers that it shows.

    python docs/_hooks/pictures.py [--write] [NAME...]

makes all of them in scenarios/pictures, or those of the names. The names are those of
page_pictures.py (quickstart, vibrating-ball, python, choice, accuracy, gallery), which the program
draws by its own commands, and those of the tables in pictures.toml, which have captions, and a
second file for dark pages. A JSON has the version of the program, the digests of the scenes, the
numbers, the caption, and the texts by which pages state them. tests/test_pictures.py compares these
with the pages and the program, and the command prints the texts that a page lacks. With `--write`
it first puts them in place of those of the last picture, where these stand once on their page. Runs
are kept in outputs/pictures, by the sources of the program. Chromium (extra `dev`) draws the pages.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import choice_picture
from build_cache import ROOT
from picture_list import ALL
from picture_parts import Picture, dark_twin


def main(names: list[str]) -> int:
    """Make the pictures of some names, or all; return the exit code."""
    is_written = "--write" in names
    names = [name for name in names if name != "--write"]
    known = dict.fromkeys(picture.name for picture in ALL)
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no picture: {', '.join(unknown)}, allowed: {', '.join(known)}", file=sys.stderr)
        return 2
    for picture in ALL:
        if names and picture.name not in names:
            continue
        print(f"== {picture.stem}", flush=True)
        last = picture.path.with_suffix(".json")
        before = json.loads(last.read_text(encoding="utf-8"))["pages"] if last.is_file() else {}
        stored = write(picture)
        if is_written:
            write_pages(before, stored["pages"])
        for page, texts in missing(stored["pages"]).items():
            print(f"{page} lacks:", *texts, sep="\n")
    return 0


def write(picture: Picture) -> dict[str, Any]:
    """Make a picture, and write its JSON beside it; return the content of the JSON."""
    from rolling import __version__

    shown = picture.make(picture.path)
    content: dict[str, Any] = {
        "program": __version__,
        "command": f"python docs/_hooks/pictures.py {picture.name}",
        "picture_sha256": digest_of(picture.path) if picture.is_drawn else None,
    }
    if picture.has_dark:
        content["dark_sha256"] = digest_of(dark_twin(picture.path))
    if shown.caption:
        content["caption"] = shown.caption
    content["scenes"] = digests(picture)
    content["numbers"] = shown.numbers
    content["pages"] = shown.pages
    text = json.dumps(content, indent=2, ensure_ascii=False)
    picture.path.with_suffix(".json").write_text(f"{text}\n", encoding="utf-8")
    return content


def write_pages(before: Mapping[str, Sequence[str]], now: Mapping[str, Sequence[str]]) -> None:
    """Put the texts of a picture in place of those before, by page."""
    for page, texts in now.items():
        path = ROOT / page
        content = path.read_text(encoding="utf-8")
        path.write_text(renewed(content, before.get(page, ()), texts), encoding="utf-8")


def renewed(content: str, before: Sequence[str], now: Sequence[str]) -> str:
    """Return the content of a page with texts in place of those before.

    A text that does not stand there once stays, and all do if their number has changed.
    """
    if len(before) != len(now):
        return content
    for old, new in zip(before, now, strict=True):
        if content.count(old) == 1:
            content = content.replace(old, new)
    return content


def digests(picture: Picture) -> dict[str, str]:
    """Return the digests of what is computed for a picture, by its labels."""
    from rolling.scene.identity import scene_identity

    if picture.blocks:
        blocks = "\0".join(choice_picture.blocks()).encode()
        return {picture.blocks: hashlib.sha256(blocks).hexdigest()}
    return {label: scene_identity(scene.read()) for label, scene in picture.scenes.items()}


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def missing(pages: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return the texts that pages lack, by page; the spaces and ends of lines may differ."""
    lacking = {}
    for page, texts in pages.items():
        content = _folded((ROOT / page).read_text(encoding="utf-8"))
        absent = [text for text in texts if _folded(text) not in content]
        if absent:
            lacking[page] = absent
    return lacking


def _folded(text: str) -> str:
    """Return a text with single spaces."""
    return " ".join(text.split())


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
