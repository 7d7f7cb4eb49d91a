"""The report page, on which runs are heard, seen and read: an HTML file without network access.

This module gathers the content of the page as plain text, numbers and data URIs. Layout and
behaviour are in `assets/`. The gallery is a page of many runs, each with a picture, a sound, its
level and a sentence.
"""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2
import numpy as np
from markupsafe import Markup

from acoustics import wav
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.plot_style import PREFIXES
from acoustics.texts import printable
from rolling import __version__
from rolling.check.doubt import Doubt
from rolling.figures import origins
from rolling.figures.catalogue import SINGLE, comparing_pictures, single_picture
from rolling.figures.picture import Picture, slug
from rolling.figures.settings import left_out_if_it_fails
from rolling.report import assumed, film, live, maps, records, text
from rolling.report.charts import Chart, chart_of
from rolling.results import runs_table, verdict
from rolling.results.doubts import REPEATS, UNVALIDATED
from rolling.results.listening import record_for_ear
from rolling.results.run_folder import PAGE
from rolling.results.run_result import Run
from rolling.terminal import defaults

LARGEST_CSV = 20_000  # bytes of a table on the page; of longer ones it has the curves as drawn
MAX_RUNS = defaults.MAX_RUNS_ON_PAGE
MAX_BESIDE = 3  # runs whose own pictures stand below each other
TIMELINES = ("release_power", "spectrogram")  # pictures of a run over time
VIBRATION = ("sources", "contact_force", "contact_filter", "mobilities")


def page(runs: Sequence[Run], unsolved: Sequence[str] = ()) -> bytes:
    """Write the page of one run or several.

    More runs than `MAX_RUNS` have a page without players and without pictures of single runs.

    Parameters
    ----------
    runs : sequence of Run, at least one, in the order of the page. Their labels differ.
    unsolved : sequence of str. Labels of runs that are not solved. Default: none.

    Returns
    -------
    bytes
        The HTML file.
    """
    shown = runs if len(runs) <= MAX_RUNS else []
    scale = maps.map_scale(shown)
    views = _views(shown)
    players = [_player(view, scale) for view in views]
    charts = PageCharts(views)
    data = {"runs": players, "view": scale, "bands": BAND_NAMES, "charts": charts.shown}
    templates = environment()
    templates.globals["numbered"] = charts.add
    templates.globals["is_known"] = charts.is_known
    templates.globals["sharing"] = charts.sharing
    templates.globals["crowded"] = len(views) > MAX_BESIDE
    template = templates.get_template("report.html")
    return template.render(
        version=__version__,
        title=text.titles(runs),
        descriptions=_descriptions(shown),
        text=text,
        origins=origins,
        film=film,
        verdict=verdict,
        runs_table=runs_table,
        summaries=[(run.label, run.summary) for run in runs],
        assumptions=text.facts(runs, [assumed.assumptions(run) for run in runs]),
        runs=runs,
        views=views,
        unsolved=list(unsolved),
        lengths={round(run.sound.duration, 4) for run in runs},
        short=any(doubt.key == "short_loop" for view in views for doubt in view.repeats),
        map_scale=scale,
        map_flies=any(any(player["maps"]["instead"]) for player in players if player["maps"]),
        stills=any(player["maps"] and not player["falls"] for player in players),
        filmed=any(player["film"] for player in players),
        moved=any(len(view.curves) > 1 for view in views),
        curves=_comparing_exhibits(runs),
        surfaces=_surfaces(shown),
        vibration=[name for name in VIBRATION if any(name in view.pictures for view in views)],
        css=Markup(text.asset("report.css") + text.asset("play.css") + text.asset("chart.css")),
        js=Markup(joined("page/begin.js" if shown else "page/chart.js")),
        engine=Markup(joined("engine/worklet.js")),
        data=data,
    ).encode()


# ---- templates and scripts


_IMPORT = re.compile(r'^import \{[^}]*\} from "(\./|\.\./)([\w/]+\.js)";\n', re.MULTILINE)


def environment() -> jinja2.Environment:
    """Return the environment of the page, which escapes values and raises on missing values."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rolling.report", "assets"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"slug": slug, "css_text": css_text}
    # NaN must not reach the script of the page, because it is not JSON.
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment


def css_text(title: str) -> Markup:
    """Write any text as the inside of a string of CSS, all but letters and digits as numbers."""
    letters = []
    for letter in title:
        if letter.isascii() and letter.isalnum():
            letters.append(letter)
        else:
            letters.append(f"\\{ord(letter):06x}")
    return Markup("".join(letters))


def joined(entry: str) -> str:
    """Join a module of `assets/` with all modules that it imports, each once, imports first.

    The modules then share a scope, so no two of them may declare the same name at their top level.
    """
    seen = set[str]()
    parts = list[str]()

    def gather(name: str) -> None:
        """Add the text of a module behind the texts of the modules that it imports."""
        seen.add(name)
        script = text.asset(name)
        room = name.rpartition("/")[0]
        for above, imported in _IMPORT.findall(script):
            path = f"{room}/{imported}" if above == "./" else imported
            if path not in seen:
                gather(path)
        parts.append(re.sub(r"^export ", "", _IMPORT.sub("", script), flags=re.MULTILINE))

    gather(entry)
    return "\n".join(parts)


def _descriptions(runs: Sequence[Run]) -> list[str]:
    """Return the different descriptions of scenes, each on a single line in printable letters."""
    descriptions = [run.scene.description for run in runs if run.scene.description]
    lines = [printable(" ".join(text.split())) for text in descriptions]
    return [*dict.fromkeys(lines)]


# ---- runs


@dataclass(frozen=True)
class RunView:
    """A run as the page shows it, for the templates.

    Parameters
    ----------
    label : str
    run : Run
    number : int. Place of the run on the page.
    playback : dict. Gains, as `records.gains` returns them.
    records : list of dict. Name, sound and description of its records; the first is heard.
    lap : dict. Lap to which the end of that record leads back.
    solved : float, s. Time in that record at which the solved track ends.
    repeats : list. Notes on the repetition of that record.
    pictures : dict. Charts of the run by their names.
    live : dict. Data for the engine, or None.
    curves : list of dict. Charts of its slow motion.
    """

    label: str
    run: Run
    number: int
    playback: dict[str, float | None]
    records: list[dict[str, str]]
    lap: dict[str, float]
    solved: float
    repeats: list[Doubt]
    pictures: dict[str, Chart]
    live: dict[str, Any] | None
    curves: list[Chart]


def _views(runs: Sequence[Run]) -> list[RunView]:
    """Return the runs as the page shows them."""
    views = []
    for number, (run, record) in enumerate(zip(runs, records.of_runs(runs), strict=True)):
        repeats = []
        if record.records[0]["name"] == "run":  # a long record goes on
            repeats = [doubt for doubt in verdict.listed(run.summary) if doubt.key in REPEATS]
        view = RunView(
            label=run.label,
            run=run,
            number=number,
            playback=record.playback,
            records=record.records,
            lap=record.lap,
            solved=record.solved,
            repeats=repeats,
            pictures=_pictures(run, number, runs),
            live=live.live_of(run),
            curves=_film_curves(run, number),
        )
        views.append(view)
    return views


def _pictures(run: Run, number: int, runs: Sequence[Run]) -> dict[str, Chart]:
    """Return the charts of a run by their names, but those that the page shows otherwise."""
    left_out = {"surface"}  # which the page has once for all its runs
    if run.result.maps:
        left_out.add("contact_pressure")  # the page has maps that move
    if run.scene.rolling.drop_mm is not None:
        left_out.add("release_power")  # it does not roll at that time
    pictures = {}
    for name in SINGLE:
        if name in left_out:
            continue
        picture = single_picture(name, run, runs)
        with left_out_if_it_fails(f"{name} of {run.label}"):
            if picture is not None:
                pictures[name] = _exhibit(picture) | {"run": number}
    return pictures


def _film_curves(run: Run, number: int) -> list[Chart]:
    """Return the charts of the slow motion of a run."""
    with left_out_if_it_fails(f"of the curves of the slow motion of {run.label}"):
        return [curve | {"run": number} for curve in film.curves(run)]
    return []


def _player(view: RunView, scale: dict[str, Any] | None) -> dict[str, Any]:
    """Return the numbers of a run for the script of the page."""
    run = view.run
    run_maps = slow_motion = None
    if scale is not None:
        run_maps = maps.run_maps(run, scale["max_gpa"])
        with left_out_if_it_fails(f"of the slow motion of {run.label}"):
            slow_motion = film.film_of(run, scale["max_gpa"])
    return {
        "label": view.label,
        "lap": view.lap,
        "solved": view.solved,
        "playback": view.playback,
        "live": view.live,
        "falls": run.scene.rolling.drop_mm is not None,
        "maps": run_maps,
        "film": slow_motion,
        "bands": _rounded(run.sound.levels.third_octave_db),
        "spreads": _rounded(run.summary["third_octave_uncertainty_db"]),
    }


def _rounded(levels: Mapping[str, float | None]) -> list[float | None]:
    """Return levels by band [dB], with three decimals."""
    by_band = [levels[name] for name in BAND_NAMES]
    return [None if level is None else round(level, 3) for level in by_band]


# ---- pictures


class PageCharts:
    """The charts of a page in the order in which its templates show them."""

    def __init__(self, views: Sequence[RunView]) -> None:
        self.shown = list[Chart]()
        self._views = views

    def add(self, chart: Chart) -> int:
        """Show a chart and return its number."""
        self.shown.append(chart)
        return len(self.shown) - 1

    def is_known(self, chart: Chart) -> bool:
        """Tell whether equal curves are shown already, as runs of equal bodies have them."""
        return any(_is_same(chart, other) for other in self.shown)

    def sharing(self, chart: Chart) -> str:
        """Return the numbers of the runs that have the chart of a run."""
        numbers = []
        for view in self._views:
            own = view.pictures.get(chart["name"])
            if view.number == chart["run"] or (own is not None and _is_same(chart, own)):
                numbers.append(str(view.number))
        return " ".join(numbers)


def _is_same(chart: Chart, other: Chart) -> bool:
    """Tell whether two charts have the same curves."""
    return bool(chart["xs"] == other["xs"] and chart["parts"] == other["parts"])


def _exhibit(picture: Picture) -> Chart:
    """Read a picture as a chart with its table."""
    chart = chart_of(picture)
    table = picture.file("csv")
    if table is not None and len(table) <= LARGEST_CSV:
        chart["csv"] = table.decode()
    if picture.name in TIMELINES:
        chart["second"] = _seconds(chart["x"]["unit"])
    return chart


def _comparing_exhibits(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Read the pictures that compare runs as charts."""
    exhibits = []
    for picture in comparing_pictures(runs):
        with left_out_if_it_fails(picture.name):
            exhibits.append(_exhibit(picture))
    return exhibits


def _seconds(unit: str) -> float:
    """Return the seconds of a unit of time with its prefix."""
    for power, prefix in PREFIXES.items():
        if f"{prefix}s" == unit:
            return 1000.0**power
    raise ValueError(f"{unit}: no unit of time")


def _surfaces(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return the different surfaces, each with the labels of its runs."""
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(_surface_key(run), []).append(run)
    surfaces = []
    for members in groups.values():
        first = members[0]
        picture = single_picture("surface", first)
        exhibit = None
        with left_out_if_it_fails(f"surface of {first.label}"):
            if picture is not None:
                exhibit = _exhibit(picture)
        surface = {
            "labels": [run.label for run in members],
            "numbers": [number for number, run in enumerate(runs) if run in members],
            "words": assumed.surface_words(first.scene),
            "statistics": first.summary["surface"],
            "parts": runs_table.surface_parts(first.summary),
            "picture": exhibit,
        }
        surfaces.append(surface)
    return surfaces


def _surface_key(run: Run) -> str:
    """Return a text that is the same for runs over the same heights."""
    scene = run.scene
    parts: list[Any] = [
        scene.surface.model_dump_json(),
        scene.height_path,
        scene.track.n_along,
        scene.track.n_across,
    ]
    if scene.sphere.surface:
        parts += [scene.sphere.surface, scene.track.turn_nodes]
    return repr(parts)


# ---- gallery


MAX_CARDS = 200
# All sounds together weigh about 5 MB: an MP3 of a rough contact takes up to 25 kB per second.
SECONDS = 8.0  # of a run at most
MIN_SECONDS = 1.0  # of a run at least
ALL_SECONDS = 150.0  # of all runs together
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
    listening = run.summary.get("listening") or {}
    still = None
    with left_out_if_it_fails(f"of the contact of {run.label}"):
        still = film.still(run)
    return {
        "title": text.titles([run]),
        "label": run.label,
        "level": runs_table.level_text(run.summary, runs_table.level_key(run.summary)),
        "name": runs_table.level_name(run.summary),
        "verdict": run.summary.get("verdict"),
        "sentence": _sentence(run),
        "picture": still,
        "sound": records.compressed(wav.PEAK / peak * sound) if peak > 0 else None,
        "peak": peak,
        "level_db": listening.get("laeq_db", run.summary["laeq_db"]),
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
    part = np.array(record_for_ear(run).pressure[: round(seconds * rate)], dtype=float)
    fade = min(len(part), round(FADE_S * rate))
    part.T[..., len(part) - fade :] *= np.linspace(1, 0, fade)  # of all channels
    return part


def _sentence(run: Run) -> str:
    """Return the description of a scene of one run; in a sweep, a sentence on the run's sound."""
    description = " ".join((run.scene.description or "").split())
    if run.values or not description:
        return text.headline([run])
    return printable(description).rstrip(".") + "."
