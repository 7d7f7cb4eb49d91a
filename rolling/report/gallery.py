"""The gallery: a page of many runs as cards, each with its drawing, its level and Play."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.texts import printable
from rolling.figures.catalogue import single_picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.heard_sound import HeardSound, played_sound
from rolling.kinds.page_parts import Part
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import PAGE
from rolling.report import leading_numbers, page_sounds, text
from rolling.report.charts import Chart
from rolling.report.machine_drawing import drawing_of
from rolling.report.page_of_parts import PageOfParts, exhibit
from rolling.results.notes import UNVALIDATED

MAX_CARDS = 200
# All sounds together weigh about 5 MB: an MP3 of a rough contact takes up to 25 kB per second.
SECONDS = 8.0  # of a run at most
MIN_SECONDS = 1.0  # of a run at least
ALL_SECONDS = 150.0  # of all runs together
FADE_S = 0.02


def gallery_page(
    runs: Iterable[Any], count: int, folder: Path, unsolved: Sequence[str] = ()
) -> bytes:
    """Write the page of many runs.

    Each run is heard for 8 s of listen.wav, or for less where all runs together would exceed 150 s,
    but for 1 s at least.

    Parameters
    ----------
    runs : iterable of runs of any kinds, in the order of the page; each is dropped after its card.
    count : int. Number of the runs.
    folder : Path. The folder of the page, from which it links to the pages of the runs.
    unsolved : sequence of str. Labels of runs that are not solved. Default: none.

    Returns
    -------
    bytes
        The HTML file.
    """
    seconds = min(SECONDS, max(MIN_SECONDS, ALL_SECONDS / count))
    cards = [_card(run, number, seconds, folder) for number, run in enumerate(runs)]
    for card, gains in zip(cards, _gains(cards), strict=True):
        card["gain"] = gains
    notes = [*dict.fromkeys(card["note"] for card in cards if card["note"])]
    made = PageOfParts(
        title="Rolling contacts to hear",
        unsolved=unsolved,
        first=[Part("gallery_first.html", {"count": len(cards), "seconds": seconds})],
        parts=[Part("gallery.html", {"cards": cards, "notes": [*notes, UNVALIDATED]})],
        styles=("gallery.css",),
        script="page/gallery.js",
    )
    return made.written()


def _card(run: Any, number: int, seconds: float, folder: Path) -> dict[str, Any]:
    """Return the parts of the card of a run: drawing, sentence, level, sound, and what it shows."""
    kind = kind_of(run.scene)
    played = played_sound(kind.sounds(run))
    sound = _excerpt(played, seconds)
    peak = float(np.abs(sound).max(initial=0.0))
    still = None
    with left_out_if_it_fails(f"of the card of {run.label}"):
        still = kind.still(run)
    return {
        "title": text.titles([run]),
        "label": run.label,
        "machine": drawing_of([run.scene], [run.numbers], name=f"machine-{number}"),
        "answers": leading_numbers.shown_columns([run]),
        "sentence": _sentence(run),
        "listen_for": _listen_for(run.scene),
        "heard": kind.heard(run, is_alone=True),
        "still": still,
        "chart": _chart(run, kind.card_figure),
        "sound": page_sounds.compressed(wav.PEAK / peak * sound) if peak > 0 else None,
        "peak": peak,
        "unit": "" if played is None else played.unit,
        "level_db": None if played is None else played.level_db,
        "report": _link(run.home / PAGE, folder),
        "note": kind.gallery_note,
    }


def _chart(run: Any, name: str) -> Chart | None:
    """Return a figure of a run as a chart; None without a name, or where the run lacks it."""
    drawn = single_picture(name, run) if name else None
    if drawn is None:
        return None
    with left_out_if_it_fails(f"{name} of the card of {run.label}"):
        return exhibit(drawn)
    return None


def _gains(cards: Sequence[Mapping[str, Any]]) -> list[dict[str, float | None]]:
    """Return the gains of the sounds of cards: equal loudness for all, one scale for each unit."""
    peaks = [card["peak"] for card in cards]
    levels = [card["level_db"] for card in cards]
    equal = page_sounds.gains(peaks, levels)
    calibrated = page_sounds.gains_by_source([card["unit"] for card in cards], peaks, levels)
    return [
        {"equal": of_all["equal"], "calibrated": of_unit["calibrated"]}
        for of_all, of_unit in zip(equal, calibrated, strict=True)
    ]


def _link(page: Path, folder: Path) -> str | None:
    """Return the relative address of a page from a folder; None without a page or a common disk."""
    if not page.is_file() or page.resolve().drive != folder.resolve().drive:
        return None
    return quote(Path(os.path.relpath(page.resolve(), folder.resolve())).as_posix())


def _excerpt(sound: HeardSound | None, seconds: float) -> Array:
    """Return the beginning of a sound in its unit, with a fade at its end; nothing of no sound."""
    if sound is None:
        return np.zeros(0)
    rate = wav.SAMPLE_RATE_HZ
    part = np.array(sound.samples[: round(seconds * rate)], dtype=float)
    fade = min(len(part), round(FADE_S * rate))
    part.T[..., len(part) - fade :] *= np.linspace(1, 0, fade)  # of all channels
    return part


def _sentence(run: Any) -> str:
    """Return the description of a scene of one run; in a sweep, what follows from the run."""
    description = " ".join((getattr(run.scene, "description", None) or "").split())
    if run.values or not description:
        return kind_of(run.scene).card_sentence(run)
    return printable(description).rstrip(".") + "."


def _listen_for(scene: Any) -> str:
    """Return what to listen for in a scene, as it says it; empty where it says nothing."""
    words = " ".join((getattr(scene, "listen_for", None) or "").split())
    return f"Listen for {printable(words).rstrip('.')}." if words else ""
