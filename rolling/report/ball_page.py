"""Parts of the page of balls, on which they are heard, seen and rolled by hand.

This module gathers the content as plain text, numbers and data URIs. Layout and behaviour are in
`assets/`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from acoustics.bands import BAND_NAMES
from acoustics.plot_style import PREFIXES
from acoustics.texts import printable
from rolling.figures.catalogue import (
    comparing_pictures,
    figures_of,
    single_names,
    single_picture,
)
from rolling.figures.picture import Picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.page_parts import PageParts, Part
from rolling.numbers.doubt import Doubt
from rolling.report import (
    assumed,
    ball_work,
    film,
    leading_numbers,
    live,
    maps,
    number_table,
    page_sounds,
    text,
)
from rolling.report.charts import Chart
from rolling.report.page_of_parts import ChartList, exhibit
from rolling.report.page_room import page_room
from rolling.report.templates import joined_script
from rolling.results import answer, description, run_lines, verdict
from rolling.results.level_words import SILENT
from rolling.results.listening import QUIET_DB, Raised
from rolling.results.notes import REPEATS
from rolling.results.run_result import Run
from rolling.results.stated_sound import StatedSound
from rolling.terminal import defaults

MAX_RUNS = defaults.MAX_RUNS_ON_PAGE
MAX_BESIDE = 3  # runs whose own pictures stand below each other
OVER_SWEEP = "levels"  # chart of the first view of a sweep
FIRST_HIGH = 270  # pixels of its height
LEADING = ("third_octaves_a",)  # shown first; other curves are one choice away
TIMELINES = ("release_power", "spectrogram")  # pictures of a run over time
SURFACES = ("surface", "ball_surface")
VIBRATION = ("sources", "contact_force", "contact_filter", "mobilities")
ARTICLE = (
    "Lee, B.; Kim, K.; Kim, T.: Analysis of Contact Noise Due to Elastic Recovery of Surface"
    " Asperities for Spherical Contact. Inventions 2025, 10(1), 17. doi:10.3390/inventions10010017"
)
CHANNELS = ("channel_third_octaves", "channel_spectrum", "channel_envelope")


def ball_parts(runs: Sequence[Run]) -> PageParts:
    """Return the parts of the page of one run of a ball or several.

    More runs than `MAX_RUNS` have a page without players and without pictures of single runs.

    Parameters
    ----------
    runs : sequence of Run, at least one, in the order of the page. Their labels differ.
    """
    shown = runs if len(runs) <= MAX_RUNS else []
    scale = maps.map_scale(shown)
    views = _views(shown)
    players = [_player(view, scale) for view in views]
    charts = BallCharts(views)
    curves = _comparing_exhibits(runs)
    over_sweep = next((curve for curve in curves if curve["name"] == OVER_SWEEP), None)
    if over_sweep is not None:
        over_sweep["high"] = FIRST_HIGH
    room = page_room(shown) if shown else None
    shared = {
        "room": room,
        "views": views,
        "film": film,
        "analyst": Markup(joined_script("engine/analyst.js")) if views else "",
        "quiet_db": QUIET_DB,
        "sounds": [view.stated for view in views],
        "with_released": " ".join(str(view.number) for view in views if view.released),
        "map_scale": scale,
        "contact_key": None if scale is None else film.contact_key(scale),
        "filmed": any(player["film"] for player in players),
        "moved": any(len(view.curves) > 1 for view in views),
        "is_known": charts.is_known,
        "crowded": len(views) > MAX_BESIDE,
    }
    return PageParts(
        has_drawing_within=True,
        first=[Part("hero.html", _first(runs, players, over_sweep))],
        beside=[Part("player.html"), Part("contents.html")] if views else [],
        charts=_charts(runs, shown, views, players, curves),
        doubted=[ball_work.work_of(runs)],
        more=[Part("details.html", _details(runs, shown, views))] if views else [],
        has_number_table=False,
        styles=("heard.css", "play.css"),
        has_plain_players=False,
        script="page/begin.js" if views else "page/plain.js",
        engine="engine/worklet.js" if any(view.live for view in views) else "",
        shared=shared,
        data={
            "runs": players,
            "view": scale,
            "bands": BAND_NAMES,
            "room": None if room is None else {"gains": room.gains},
        },
        charted=charts,
        cited=[ARTICLE],
    )


def _first(
    runs: Sequence[Run], players: Sequence[Mapping[str, Any]], over_sweep: Chart | None
) -> dict[str, Any]:
    """Return the values of the first view, which shows the levels of a sweep, or the contact."""
    has_stills = any(player["maps"] and not player["falls"] for player in players)
    return {
        "sentence": description.runs_sentence(runs),
        "follows": answer.follows(runs),
        "units": leading_numbers.units(runs),
        "over_sweep": over_sweep,
        "folds_runs": over_sweep is not None and len(runs) > MAX_BESIDE,
        "stills": has_stills and over_sweep is None,
    }


def _charts(
    runs: Sequence[Run],
    shown: Sequence[Run],
    views: Sequence[RunView],
    players: Sequence[Mapping[str, Any]],
    curves: Sequence[Chart],
) -> list[Part]:
    """Return the instrument, the spectra and the contact; of too many runs the spectra alone."""
    spectra = {
        "curves": [curve for curve in curves if curve["name"] != OVER_SWEEP],
        "LEADING": LEADING,
        "listeners": number_table.listeners(runs),
    }
    if not views:
        return [Part("spectra.html", spectra)]
    moving = {
        "map_flies": any(any(player["maps"]["instead"]) for player in players if player["maps"]),
        "surfaces": _surfaces(shown),
    }
    return [
        Part("play.html", {"band_names": BAND_NAMES}),
        Part("spectra.html", spectra),
        Part("moving.html", moving),
    ]


def _details(runs: Sequence[Run], shown: Sequence[Run], views: Sequence[RunView]) -> dict[str, Any]:
    """Return the values of what few people ask for."""
    return {
        "descriptions": _descriptions(shown),
        "assumptions": text.facts(runs, [assumed.assumptions(run) for run in runs]),
        "provenance": text.provenance(runs),
        "lengths": {round(run.sound.duration, 4) for run in runs},
        "short": any(doubt.key == "short_loop" for view in views for doubt in view.repeats),
        "vibration": [name for name in VIBRATION if any(name in view.pictures for view in views)],
        "channels": [name for name in CHANNELS if any(name in view.pictures for view in views)],
        "channel_lines": run_lines.channel_lines(shown),
    }


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
    playback : dict. Gains, as `page_sounds.gains` returns them.
    below_db : float. Level of the loudest run of its source over its own.
    records : list of PageRecord. Its records; the first is heard.
    lap : dict. Lap to which the end of that record leads back.
    solved : float, s. Time in that record at which the solved track ends.
    ends : bool. Whether that record is of something that ends, and so does not go round.
    raised : Raised or None. Its end that is raised.
    stated : StatedSound. What plays, at the level that is stated.
    released : RunRecords or None. Records of the released power where the vibration plays.
    repeats : list. Notes on the repetition of that record.
    pictures : dict. Charts of the run by their names.
    live : dict. Data for the engine, or None.
    curves : list of dict. Charts of its slow motion.
    """

    label: str
    run: Run
    number: int
    playback: dict[str, float | None]
    below_db: float
    records: list[page_sounds.PageRecord]
    lap: dict[str, float]
    solved: float
    ends: bool
    raised: Raised | None
    stated: StatedSound
    released: page_sounds.RunRecords | None
    repeats: list[Doubt]
    pictures: dict[str, Chart]
    live: dict[str, Any] | None
    curves: list[Chart]

    @property
    def level(self) -> str:
        """Level of what plays in words, without its unit."""
        level_db = self.stated.level.level_db
        return SILENT if level_db is None else f"{level_db:.1f}"

    @property
    def special(self) -> str:
        """What is special about the sound, in a sentence; empty where nothing is."""
        return description.special(self.run.scene, self.run.numbers)

    @property
    def all_records(self) -> list[page_sounds.PageRecord]:
        """Records of what plays, and of the released power beside it."""
        released = [] if self.released is None else self.released.records
        return [*self.records, *released]

    @property
    def is_measured(self) -> bool:
        """Whether the surface of the plate was read from a file, or has faults."""
        return self.run.scene.height_path is not None or bool(self.run.scene.surface.faults)


def _views(runs: Sequence[Run]) -> list[RunView]:
    """Return the runs as the page shows them."""
    views = []
    for number, (run, record) in enumerate(zip(runs, page_sounds.of_runs(runs), strict=True)):
        repeats = []
        if record.records[0].name == "run":  # a long record goes on
            repeats = [doubt for doubt in verdict.listed(run.numbers) if doubt.key in REPEATS]
        view = RunView(
            label=run.label,
            run=run,
            number=number,
            playback=record.playback,
            below_db=record.below_db,
            records=record.records,
            lap=record.lap,
            solved=record.solved,
            ends=record.ends,
            raised=record.raised,
            stated=record.stated,
            released=record.released,
            repeats=repeats,
            pictures=_pictures(run, number, runs),
            live=live.live_of(run),
            curves=_film_curves(run, number),
        )
        views.append(view)
    return views


def _pictures(run: Run, number: int, runs: Sequence[Run]) -> dict[str, Chart]:
    """Return the charts of a run by their names, but those that the page shows otherwise."""
    left_out = {*SURFACES}  # which the page has once for all its runs
    if run.result.maps:
        left_out.add("contact_pressure")  # the page has maps that move
    pictures = {}
    for name in single_names(run):
        if name in left_out:
            continue
        chart = _single_chart(name, run, runs)
        if chart is not None:
            pictures[name] = chart | {"run": number}
    with left_out_if_it_fails(f"places of {run.label}"):
        if run.sound_by_place is not None:
            chart = _made_once(run, "places", lambda: _places(run))
            pictures["places"] = chart | {"run": number}
    return pictures


def prepare(run: Run) -> None:
    """Make the charts and the sounds of a page that follow from a run alone; the run keeps them."""
    for name in single_names(run):
        if name not in SURFACES and not figures_of([run])[name].shares_scales:
            _single_chart(name, run, ())
    if run.sound_by_place is not None:
        _made_once(run, "places", lambda: _places(run))
    page_sounds.prepare(run)


def _single_chart(name: str, run: Run, runs: Sequence[Run]) -> Chart | None:
    """Return the chart of a figure of one run; one whose scale no other run changes is made once.

    None for a figure that the run does not have, or that cannot be drawn.
    """

    def drawn() -> Chart | None:
        picture = single_picture(name, run, runs)
        with left_out_if_it_fails(f"{name} of {run.label}"):
            if picture is not None:
                return _exhibit(picture)
        return None

    if figures_of([run])[name].shares_scales:
        return drawn()
    chart: Chart | None = _made_once(run, name, drawn)
    return chart


def _made_once(run: Run, name: str, make: Callable[[], Any]) -> Any:
    """Return a chart of a run alone, which the run keeps for its label; None is not kept."""
    key = "chart", name, run.label
    if key not in run.for_page:
        chart = make()
        if chart is None:
            return None
        run.for_page[key] = chart
    return run.for_page[key]


def _places(run: Run) -> Chart:
    """Return the chart of the sound by place of a run, with the times of its patches."""
    places = run.sound_by_place
    assert places is not None  # as the caller has checked
    (picture,) = comparing_pictures([run], ["places"])
    chart = _exhibit(picture)
    patches = []
    for middle, begin, end in zip(places.position, places.first_s, places.left_s, strict=True):
        if math.isfinite(begin):
            edges = 1e6 * (middle + places.length * np.array([-0.5, 0.5]))
            patch = {"from": edges[0], "to": edges[1], "begin": begin, "end": end}
            patches.append({key: round(float(value), 6) for key, value in patch.items()})
    return chart | {"patches": patches}


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
        run_maps = maps.run_maps(run, scale["max_gpa"], scale["hardness"])
        with left_out_if_it_fails(f"of the slow motion of {run.label}"):
            slow_motion = film.film_of(run, scale["max_gpa"], scale["hardness"])
    bands = run.numbers.bands_of_record
    assert bands is not None  # each source that is measured has third octaves
    return {
        "label": view.label,
        **_playing(view),
        "released": None if view.released is None else _playing(view.released),
        "live": view.live,
        "falls": not run.scene.keeps_its_load,
        "maps": run_maps,
        "film": slow_motion,
        "bands": _rounded(run.sound.levels.third_octave_db),
        "spreads": _rounded(bands.uncertainty_by_name),
    }


def _playing(records: RunView | page_sounds.RunRecords) -> dict[str, Any]:
    """Return the numbers of a sound for the player of the page."""
    raised = records.raised
    return {
        "lap": records.lap,
        "solved": records.solved,
        "ends": records.ends,
        "raised": None if raised is None else raised.begin / records.stated.sound.sample_rate,
        "playback": records.playback,
    }


def _rounded(levels: Mapping[str, float | None]) -> list[float | None]:
    """Return levels by band [dB], with three decimals."""
    by_band = [levels[name] for name in BAND_NAMES]
    return [None if level is None else round(level, 3) for level in by_band]


# ---- pictures


class BallCharts(ChartList):
    """The charts of a page of balls, some of which runs of equal bodies share."""

    def __init__(self, views: Sequence[RunView]) -> None:
        super().__init__()
        self._views = views

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
    """Read a picture as a chart with its table, over time with the length of its unit."""
    chart = exhibit(picture)
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
        exhibits = []
        for name in SURFACES:
            picture = single_picture(name, first)
            with left_out_if_it_fails(f"{name} of {first.label}"):
                if picture is not None:
                    exhibits.append(_exhibit(picture))
        surface = {
            "labels": [run.label for run in members],
            "numbers": [number for number, run in enumerate(runs) if run in members],
            "words": assumed.surface_words(first.scene),
            "roughness": _roughness(first),
            "has_ball": first.numbers.surface.ball_ra_m is not None,
            "pictures": exhibits,
        }
        surfaces.append(surface)
    return surfaces


def _roughness(run: Run) -> str:
    """Write the roughness of the surface of a run; that of plate and ball together says so."""
    surface = run.numbers.surface
    parts = run_lines.surface_parts(run.numbers)
    return (
        f"{'; both together' if parts else ''}: Ra {surface.ra_m * 1e6:.4g} µm, "
        f"Rq {surface.rq_m * 1e6:.4g} µm, skewness {surface.skewness:.2f}, "
        f"kurtosis {surface.kurtosis:.2f}, rms slope {surface.rms_slope:.3g}{parts}."
    )


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
