"""The gallery: a page of many runs, each with a picture, a sound, its level and a sentence."""

import os
from collections.abc import Iterable, Sequence
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
from rolling.kinds.run_folder import PAGE
from rolling.report import film, quantities, records, text
from rolling.report.templates import environment
from rolling.results import answer
from rolling.results.listening import record_for_ear
from rolling.results.notes import UNVALIDATED
from rolling.results.run_result import Run

MAX_CARDS = 200
# All sounds together weigh about 5 MB: an MP3 of a rough contact takes up to 25 kB per second.
SECONDS = 8.0  # of a run at most
MIN_SECONDS = 1.0  # of a run at least
ALL_SECONDS = 150.0  # of all runs together
FADE_S = 0.02


def gallery_page(
    runs: Iterable[Run], count: int, folder: Path, unsolved: Sequence[str] = ()
) -> bytes:
    """Write the page of many runs.

    Each run is heard for 8 s of listen.wav, or for less where all runs together would exceed 150 s,
    but for 1 s at least.

    Parameters
    ----------
    runs : iterable of Run. The runs in the order of the page; each is dropped after its card.
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
    gains = records.gains([card["peak"] for card in cards], [card["level_db"] for card in cards])
    template = environment().get_template("gallery.html")
    return template.render(
        version=__version__,
        cards=[*zip(cards, gains, strict=True)],
        seconds=seconds,
        unsolved=unsolved,
        remark=UNVALIDATED,
        css=Markup(text.asset("report.css") + text.asset("gallery.css")),
    ).encode()


def _card(run: Run, seconds: float, folder: Path) -> dict[str, Any]:
    """Return title, picture, sound, level and sentence of a run, and the link to its page."""
    sound = _excerpt(run, seconds)
    peak = float(np.abs(sound).max())
    still = None
    with left_out_if_it_fails(f"of the contact of {run.label}"):
        still = film.still(run)
    return {
        "title": text.titles([run]),
        "label": run.label,
        "answers": quantities.shown_columns([run]),
        "sentence": _sentence(run),
        "heard": text.heard(run, is_alone=True),
        "picture": still,
        "sound": records.compressed(wav.PEAK / peak * sound) if peak > 0 else None,
        "peak": peak,
        "level_db": _heard_laeq_db(run),
        "report": _link(run.home / PAGE, folder),
    }


def _heard_laeq_db(run: Run) -> float | None:
    """Return LAeq of the record that is heard [dB(A)]: of the long record if there is one."""
    long = run.numbers.listening
    if long is not None and long.refused is None:
        return long.laeq_db
    return run.numbers.played.laeq_db


def _link(page: Path, folder: Path) -> str | None:
    """Return the relative address of a page from a folder; None without a page or a common disk."""
    if not page.is_file() or page.resolve().drive != folder.resolve().drive:
        return None
    return quote(Path(os.path.relpath(page.resolve(), folder.resolve())).as_posix())


def _excerpt(run: Run, seconds: float) -> Array:
    """Return the beginning of the record for the ear [Pa], with a fade at its end."""
    rate = run.sound.sample_rate
    part = np.array(record_for_ear(run).pressure[: round(seconds * rate)], dtype=float)
    fade = min(len(part), round(FADE_S * rate))
    part.T[..., len(part) - fade :] *= np.linspace(1, 0, fade)  # of all channels
    return part


def _sentence(run: Run) -> str:
    """Return the description of a scene of one run; in a sweep, what follows from the run."""
    description = " ".join((run.scene.description or "").split())
    if run.values or not description:
        return answer.follows([run])
    return printable(description).rstrip(".") + "."
