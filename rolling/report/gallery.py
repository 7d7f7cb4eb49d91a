"""The gallery: a page of many runs, each with a picture, a sound, its level and a sentence."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from acoustics import wav
from acoustics.arrays import Array
from acoustics.texts import printable
from rolling import __version__
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.heard_sound import HeardSound, played_sound
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import PAGE
from rolling.report import leading_numbers, page_sounds, text
from rolling.report.templates import environment
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
    cards = [_card(run, seconds, folder) for run in runs]
    template = environment().get_template("gallery.html")
    return template.render(
        version=__version__,
        cards=[*zip(cards, _gains(cards), strict=True)],
        notes=[*dict.fromkeys(card["note"] for card in cards if card["note"])],
        seconds=seconds,
        unsolved=unsolved,
        remark=UNVALIDATED,
        css=Markup(text.asset("report.css") + text.asset("gallery.css")),
    ).encode()


def _card(run: Any, seconds: float, folder: Path) -> dict[str, Any]:
    """Return title, picture, sound, level and sentence of a run, and the link to its page."""
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
        "answers": leading_numbers.shown_columns([run]),
        "sentence": _sentence(run),
        "listen_for": _listen_for(run),
        "heard": kind.heard(run, is_alone=True),
        "picture": still,
        "sound": page_sounds.compressed(wav.PEAK / peak * sound) if peak > 0 else None,
        "peak": peak,
        "unit": "" if played is None else played.unit,
        "level_db": None if played is None else played.level_db,
        "report": _link(run.home / PAGE, folder),
        "note": kind.gallery_note,
    }


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


def _listen_for(run: Any) -> str:
    """Return what to listen for in a run, as its scene says it; empty where it says nothing."""
    words = " ".join((getattr(run.scene, "listen_for", None) or "").split())
    return f"Listen for {printable(words).rstrip('.')}." if words else ""
