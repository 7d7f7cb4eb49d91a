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
from rolling import __version__
from rolling.report import film, hearing, records, text
from rolling.report.page import environment
from rolling.results import runs_table
from rolling.results.labels import printable
from rolling.results.listening import heard
from rolling.results.run_result import Run
from rolling.results.sentences import say

MOST_CARDS = 200
PAGE = "report.html"
# All sounds together weigh about 5 MB: an MP3 of a rough contact takes up to 25 kB per second.
SECONDS, ALL_SECONDS, LEAST_SECONDS = 8.0, 150.0, 1.0
FADE_S = 0.02


def gallery(runs: Iterable[Run], count: int, folder: Path, unsolved: Sequence[str] = ()) -> bytes:
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
    seconds = min(SECONDS, max(LEAST_SECONDS, ALL_SECONDS / count))
    cards = [_card(run, seconds, folder) for run in runs]
    gains = records.gains(*zip(*(card["loudness"] for card in cards), strict=True))
    template = environment().get_template("gallery.html")
    html = template.render(
        version=__version__,
        cards=[*zip(cards, gains, strict=True)],
        seconds=seconds,
        unsolved=unsolved,
        remark=say("unvalidated"),
        css=Markup(text.asset("report.css") + text.asset("gallery.css")),
    )
    return html.encode()


def _card(run: Run, seconds: float, folder: Path) -> dict[str, Any]:
    """Return title, picture, sound, level and sentence of a run, and the link to its page."""
    sound = _excerpt(run, seconds)
    peak = float(np.abs(sound).max())
    level = (run.summary.get("listening") or {}).get("laeq_db", run.summary["laeq_db"])
    return {
        "title": text.titles([run]),
        "label": run.label,
        "level": runs_table.level_text(run.summary, "laeq_db"),
        "name": runs_table.level_name(run.summary),
        "verdict": run.summary.get("verdict"),
        "sentence": _sentence(run),
        "picture": film.still(run),
        "sound": records.compressed(wav.PEAK / peak * sound) if peak > 0 else None,
        "loudness": (peak, level),
        "report": _link(run.home / PAGE, folder),
    }


def _link(page: Path, folder: Path) -> str | None:
    """Return the relative address of a page from a folder; None without a page or a common disk."""
    if not page.is_file() or page.resolve().drive != folder.resolve().drive:
        return None
    return quote(Path(os.path.relpath(page.resolve(), folder.resolve())).as_posix())


def _excerpt(run: Run, seconds: float) -> Array:
    """Return the beginning of the record for the ear [Pa], with a fade at its end."""
    rate = run.sound.sample_rate
    part = np.array(heard(run)[0][: round(seconds * rate)], dtype=float)
    fade = min(len(part), round(FADE_S * rate))
    part[len(part) - fade :] *= np.linspace(1, 0, fade).reshape(-1, *[1] * (part.ndim - 1))
    return np.asarray(part)


def _sentence(run: Run) -> str:
    """Return the description of a scene of one run; in a sweep, a sentence on the run's sound."""
    description = " ".join((run.scene.description or "").split())
    if run.values or not description:
        return hearing.headline([run])
    return printable(description).rstrip(".") + "."
