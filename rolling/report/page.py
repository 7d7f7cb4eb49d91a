"""The report page, on which runs are heard, seen and read: an HTML file without network access.

This module gathers the content of the page as plain text, numbers and data URIs. Layout and
behaviour are in `assets/`. The gallery is a page of many runs, each with a picture, a sound, its
level and a sentence.
"""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
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
from rolling.figures import origins
from rolling.figures.catalogue import SINGLE, comparing_pictures, single_picture
from rolling.figures.picture import Picture, slug
from rolling.figures.settings import left_out_if_it_fails
from rolling.report import assumed, charts, film, live, maps, records, text
from rolling.results import caveats, runs_table
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
    data: dict[str, Any] = {"runs": players, "view": scale, "bands": BAND_NAMES}
    data["charts"] = shown_charts = list[dict[str, Any]]()
    templates = environment()
    templates.globals["numbered"] = partial(_number, shown_charts)
    # Runs of equal bodies have equal curves, which the page shows once.
    templates.globals["is_known"] = lambda chart: any(_is_same(chart, x) for x in shown_charts)
    templates.globals["sharing"] = partial(_sharing, views)
    templates.globals["crowded"] = len(views) > MAX_BESIDE
    template = templates.get_template("report.html")
    return template.render(
        version=__version__,
        title=text.titles(runs),
        descriptions=_descriptions(shown),
        text=text,
        origins=origins,
        film=film,
        caveats=caveats,
        runs_table=runs_table,
        summaries=[(run.label, run.summary) for run in runs],
        assumptions=text.facts(runs, [assumed.assumptions(run) for run in runs]),
        runs=runs,
        views=views,
        unsolved=list(unsolved),
        lengths={round(run.sound.duration, 4) for run in runs},
        short=any(c["key"] == "short_loop" for view in views for c in view["repeats"]),
        map_scale=scale,
        map_flies=any(any(player["maps"]["instead"]) for player in players if player["maps"]),
        stills=any(player["maps"] and not player["falls"] for player in players),
        filmed=any(player["film"] for player in players),
        moved=any(len(view["curves"]) > 1 for view in views),
        curves=_comparing_exhibits(runs),
        surfaces=_surfaces(shown),
        vibration=[name for name in VIBRATION if any(name in x["pictures"] for x in views)],
        css=Markup("".join(map(text.asset, ("report.css", "play.css", "chart.css")))),
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
    letters = (x if x.isascii() and x.isalnum() else f"\\{ord(x):06x}" for x in title)
    return Markup("".join(letters))


def joined(entry: str) -> str:
    """Join a module of `assets/` with all modules that it imports, each once, imports first.

    The modules then share a scope, so no two of them may declare the same name at their top level.
    """
    seen, parts = set[str](), list[str]()

    def gather(name: str) -> None:
        """Add the text of a module behind the texts of the modules that it imports."""
        seen.add(name)
        script, room = text.asset(name), name.rpartition("/")[0]
        for above, imported in _IMPORT.findall(script):
            path = f"{room}/{imported}" if above == "./" else imported
            if path not in seen:
                gather(path)
        parts.append(re.sub(r"^export ", "", _IMPORT.sub("", script), flags=re.MULTILINE))

    gather(entry)
    return "\n".join(parts)


def _descriptions(runs: Sequence[Run]) -> list[str]:
    """Return the different descriptions of scenes, each on a single line in printable letters."""
    texts = (" ".join(run.scene.description.split()) for run in runs if run.scene.description)
    return [*dict.fromkeys(map(printable, texts))]


# ---- runs


def _views(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return label, sound, notes on repetition and pictures of each run."""
    views = []
    for number, (run, sound) in enumerate(zip(runs, records.of_runs(runs), strict=True)):
        # The page has maps that move, and each surface once.
        left_out = {"surface", "contact_pressure" if run.result.maps else ""}
        if run.scene.rolling.drop_mm is not None:  # it does not roll at that time
            left_out.add("release_power")
        pictures = dict[str, dict[str, Any]]()
        for name in SINGLE:
            if name in left_out:
                continue
            picture = single_picture(name, run, runs)
            with left_out_if_it_fails(f"{name} of {run.label}"):
                if picture is not None:
                    pictures[name] = _exhibit(picture, number)
        repeating = [c for c in run.summary["caveats"] if c["key"] in caveats.REPEATS]
        repeats = repeating if sound["records"][0]["name"] == "run" else []  # a long record goes on
        curves = list[dict[str, Any]]()
        with left_out_if_it_fails(f"of the curves of the slow motion of {run.label}"):
            curves = [curve | {"run": number} for curve in film.curves(run)]
        view = {"label": run.label, "run": run, "repeats": repeats, "pictures": pictures}
        views.append(view | sound | {"live": live.live_of(run), "curves": curves})
    return views


def _player(view: dict[str, Any], scale: dict[str, Any] | None) -> dict[str, Any]:
    """Return the numbers of a run for the script of the page."""
    run, slow_motion = view["run"], None
    with left_out_if_it_fails(f"of the slow motion of {run.label}"):
        slow_motion = film.film_of(run, scale["max_gpa"]) if scale else None
    return {name: view[name] for name in ("label", "lap", "solved", "playback", "live")} | {
        "falls": run.scene.rolling.drop_mm is not None,
        "maps": maps.run_maps(run, scale["max_gpa"]) if scale else None,
        "film": slow_motion,
        "bands": _rounded(run.sound.levels.third_octave_db),
        "spreads": _rounded(run.summary["third_octave_uncertainty_db"]),
    }


def _rounded(levels: Mapping[str, float | None]) -> list[float | None]:
    """Return levels by band [dB], with three decimals."""
    return [None if (level := levels[name]) is None else round(level, 3) for name in BAND_NAMES]


# ---- pictures


def _exhibit(picture: Picture, run: int | None = None) -> dict[str, Any]:
    """Read a picture, of one run by its number or of several, as a chart with its table."""
    chart, table = charts.chart_of(picture), picture.file("csv")
    if table is not None and len(table) <= LARGEST_CSV:
        chart["csv"] = table.decode()
    if picture.name in TIMELINES:
        chart["second"] = seconds(chart["x"]["unit"])
    return chart if run is None else chart | {"run": run}


def _comparing_exhibits(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Read the pictures that compare runs as charts."""
    exhibits = []
    for picture in comparing_pictures(runs):
        with left_out_if_it_fails(picture.name):
            exhibits.append(_exhibit(picture))
    return exhibits


def _number(charts: list[dict[str, Any]], chart: dict[str, Any]) -> int:
    """Append a chart to those of the page and return its number."""
    charts.append(chart)
    return len(charts) - 1


def _is_same(chart: dict[str, Any], other: dict[str, Any]) -> bool:
    """Tell whether two charts have the same curves."""
    return bool(chart["xs"] == other["xs"] and chart["parts"] == other["parts"])


def _sharing(views: Sequence[dict[str, Any]], chart: dict[str, Any]) -> str:
    """Return the numbers of the runs that have the chart of a run."""
    others = [view["pictures"].get(chart["name"], {"xs": None}) for view in views]
    numbers = [k for k, x in enumerate(others) if k == chart["run"] or _is_same(chart, x)]
    return " ".join(map(str, numbers))


def seconds(unit: str) -> float:
    """Return the seconds of a unit of time with its prefix."""
    return next(1000.0**power for power, sign in PREFIXES.items() if f"{sign}s" == unit)


def _surfaces(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return the different surfaces, each with the labels of its runs."""
    sharing: dict[str, list[Run]] = {}
    for run in runs:
        scene, track = run.scene, run.scene.track
        ball = scene.sphere.surface and (scene.sphere.surface, track.turn_nodes)
        places = scene.height_path, track.n_along, track.n_across
        sharing.setdefault(f"{scene.surface.model_dump_json()} {ball} {places}", []).append(run)
    surfaces = []
    for members in sharing.values():
        picture, exhibit = single_picture("surface", members[0]), None
        with left_out_if_it_fails(f"surface of {members[0].label}"):
            if picture is not None:
                exhibit = _exhibit(picture)
        surface = {
            "labels": [run.label for run in members],
            "numbers": [number for number, run in enumerate(runs) if run in members],
            "words": assumed.surface_words(members[0].scene),
            "statistics": members[0].summary["surface"],
            "parts": runs_table.surface_parts(members[0].summary),
            "picture": exhibit,
        }
        surfaces.append(surface)
    return surfaces


# ---- gallery


MAX_CARDS = 200
# All sounds together weigh about 5 MB: an MP3 of a rough contact takes up to 25 kB per second.
SECONDS, ALL_SECONDS, MIN_SECONDS = 8.0, 150.0, 1.0
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
    gains = records.gains(*zip(*(card["loudness"] for card in cards), strict=True))
    template = environment().get_template("gallery.html")
    return template.render(
        version=__version__,
        cards=[*zip(cards, gains, strict=True)],
        seconds=seconds,
        unsolved=unsolved,
        remark=caveats.UNVALIDATED,
        css=Markup(text.asset("report.css") + text.asset("gallery.css")),
    ).encode()


def _card(run: Run, seconds: float, folder: Path) -> dict[str, Any]:
    """Return title, picture, sound, level and sentence of a run, and the link to its page."""
    sound, still = _excerpt(run, seconds), None
    with left_out_if_it_fails(f"of the contact of {run.label}"):
        still = film.still(run)
    peak = float(np.abs(sound).max())
    level = (run.summary.get("listening") or {}).get("laeq_db", run.summary["laeq_db"])
    return {
        "title": text.titles([run]),
        "label": run.label,
        "level": runs_table.level_text(run.summary, runs_table.level_key(run.summary)),
        "name": runs_table.level_name(run.summary),
        "verdict": run.summary.get("verdict"),
        "sentence": _sentence(run),
        "picture": still,
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
    part = np.array(record_for_ear(run).pressure[: round(seconds * rate)], dtype=float)
    fade = min(len(part), round(FADE_S * rate))
    part[len(part) - fade :] *= np.linspace(1, 0, fade).reshape(-1, *[1] * (part.ndim - 1))
    return np.asarray(part)


def _sentence(run: Run) -> str:
    """Return the description of a scene of one run; in a sweep, a sentence on the run's sound."""
    description = " ".join((run.scene.description or "").split())
    if run.values or not description:
        return text.headline([run])
    return printable(description).rstrip(".") + "."
