"""The report page, on which runs are heard, seen and read: an HTML file without network access.

This module gathers the content of the page as plain text, numbers and data URIs. Layout and
behaviour are in `assets/`.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from acoustics import extension, wav
from acoustics.bands import BAND_NAMES
from acoustics.plot_style import PREFIXES
from rolling import __version__
from rolling.figures import run_figures
from rolling.figures.picture import Picture
from rolling.figures.seed_figures import SEED
from rolling.folders import program
from rolling.report import assumed, citation, hearing, playback, templates
from rolling.report import text as report_text
from rolling.report.films import Film, film_of
from rolling.report.playback import Playback
from rolling.report.run_maps import MapScale, RunMaps, maps_of
from rolling.simulation import caveats
from rolling.simulation.caveats import Caveat
from rolling.simulation.labels import printable
from rolling.simulation.run_result import RunResult
from rolling.terminal import defaults

LARGEST_CSV = 200_000  # bytes on the page; longer tables stay in the run folder
GENERATOR = f"{program.NAME} {__version__}"
MOST_RUNS = defaults.MOST_RUNS_ON_PAGE
EXTENDED = range(18, 22)  # powers of two: lengths of extended records in samples
SECTIONS = {  # by their places on the page
    "listen": "Listen",
    "slow": "Slow motion",
    "contact": "Contact",
    "spectra": "Spectra",
    "compare": "Two runs compared",
    "spectrograms": "Spectrograms",
    "levels": "Levels",
    "vibration": "Vibration",
    "surface": "Surface",
    "events": "Recovery events",
    "assumed": "Assumed and warned",
    "again": "Make it again",
}
TIMELINES = ("release_power", "spectrogram")  # pictures of a run over time
# Maps keep their colours, which have a scale; ground, axes and letters around them turn dark.
MAPS = ("spectrogram", "surface", "contact")
DARK = (
    b'<style class="dark">@media (prefers-color-scheme: dark) {'
    b' svg { fill: #e6e8eb; } [style*="fill: #ffffff"] { fill: #15181c !important; }'
    b' [style*="fill: #404040"] { fill: #a3abb5 !important; }'
    b' [style*="stroke: #000000"] { stroke: #e6e8eb !important; } }</style>'
)
VIBRATION = ("sources", "contact_force", "contact_filter", "mobilities")
# pictures of single runs, even if several are compared
OWN = (*TIMELINES, "surface", "contact", "recovery_events", *VIBRATION)


@dataclass(frozen=True)
class TimeAxis:
    """The plot area of a picture over time [percent of the picture], and its time limits [s]."""

    left: float
    right: float
    top: float
    bottom: float
    begin: float
    end: float


@dataclass(frozen=True)
class Exhibit:
    """A picture on the page, with its curves as a link if they are short enough.

    Parameters
    ----------
    name, alt : str. As in `Picture`.
    src : str. Data URI of the SVG file.
    csv : str or None. Data URI of the curves; None if they are too long.
    has_curves : bool. Whether the picture has curves at all.
    time : TimeAxis or None. The time axis of a picture over time.
    size : (int, int), pixels. Width and height of the picture, so that nothing moves as it loads.
    """

    name: str
    alt: str
    src: str
    csv: str | None
    has_curves: bool
    time: TimeAxis | None
    size: tuple[int, int]


@dataclass(frozen=True)
class Surface:
    """A surface with the labels of the runs that share it."""

    labels: list[str]
    words: str
    statistics: dict[str, float]
    picture: Exhibit


@dataclass(frozen=True)
class RunView:
    """A run on the page.

    Parameters
    ----------
    label : str. Label that distinguishes the run from the other runs.
    run : RunResult. The run.
    playback : Playback. Gains of its record.
    wav : str. Data URI of its record.
    pictures : dict of Exhibit. Its own pictures by name.
    maps : RunMaps or None. Its pressure maps.
    film : Film or None. Its slow motion.
    """

    label: str
    run: RunResult
    playback: Playback
    wav: str
    pictures: dict[str, Exhibit]
    maps: RunMaps | None
    film: Film | None

    @property
    def repeats(self) -> list[Caveat]:
        """Caveats of a record that sounds as the tone of its repetition."""
        return [
            caveat for caveat in caveats.stored(self.run.summary) if caveat.key in caveats.REPEATS
        ]

    @property
    def player(self) -> dict[str, Any]:
        """Numbers of the run for the script of the page, as JSON."""
        sound = self.run.sound
        maps = (
            asdict(self.maps) | {"sheet": _uri("image/png", self.maps.sheet)} if self.maps else None
        )
        return {
            "label": self.label,
            "seconds": len(sound.pressure) / sound.sample_rate,
            "loops": sound.loops,
            "buzzes": any(caveat.key == "short_loop" for caveat in self.repeats),
            "playback": asdict(self.playback),
            "maps": maps,
            "film": _film_data(self.film) if self.film else None,
            "slug": templates.slug(self.label),
            "bands": _rounded(sound.levels.third_octave_db),
            "spreads": _rounded(self.run.summary["third_octave_uncertainty_db"]),
            "laps": self.run.laps,
            "extendable": not sound.not_extendable,
            "kurtosis": round(extension.kurtosis(sound.pressure), 3)
            if sound.pressure.any()
            else None,
        }


def is_page(path: Path) -> bool:
    """Return whether a file is a page of this program, of version 0.2.0 or later."""
    with path.open("rb") as file:
        return f'<meta name="generator" content="{program.NAME} '.encode() in file.read(4096)


def belongs(run: RunResult | None, name: str, runs: int) -> bool:
    """Return whether a picture is on the page; comparisons replace the curves of single runs."""
    return run is None or runs == 1 or name in OWN


def exhibits(runs: Sequence[RunResult]) -> list[tuple[RunResult | None, Exhibit]]:
    """Draw the pictures for the page of runs, each with its run, or with None for several runs.

    More runs than `MOST_RUNS` have no pictures of their own.
    """
    if len(runs) > MOST_RUNS:
        return [(None, exhibit(picture)) for picture in run_figures.of_runs(runs)]
    return [
        (run, exhibit(picture))
        for run, picture in run_figures.gallery(runs)
        if belongs(run, picture.name, len(runs))
    ]


def exhibit(picture: Picture) -> Exhibit:
    """Embed a picture."""
    csv = picture.csv() if picture.columns else b""
    link = _uri("text/csv", csv) if 0 < len(csv) <= LARGEST_CSV else None
    time = _time_axis(picture) if picture.name in TIMELINES else None
    return Exhibit(
        picture.name,
        picture.alt,
        _uri("image/svg+xml", _in_the_dark(picture)),
        link,
        bool(csv),
        time,
        _size(picture),
    )


def _in_the_dark(picture: Picture) -> bytes:
    """Return the SVG file of a picture; a map has a style for dark pages."""
    svg = picture.svg()
    return svg.replace(b"</defs>", b"</defs>" + DARK, 1) if picture.name in MAPS else svg


def _size(picture: Picture) -> tuple[int, int]:
    """Return width and height of a picture in pixels of CSS, 96 to the inch."""
    width, height = (round(96 * inches) for inches in picture.figure.get_size_inches())
    return width, height


def page(
    runs: Sequence[RunResult],
    shelf: Sequence[tuple[RunResult | None, Exhibit]],
    unheard: Sequence[str] = (),
) -> bytes:
    """Write the page of one run or several.

    Parameters
    ----------
    runs : sequence of runs, at least one, in the order of the page. Their labels differ.
    shelf : sequence of pairs. The pictures of the runs, from `exhibits`.
    unheard : sequence of str. Labels of runs that have too few steps for a sound. Default: none.

    Returns
    -------
    bytes
        The HTML file.
    """
    scale, maps = maps_of(runs)
    films = [film_of(run, scale.max_gpa) if scale else None for run in runs]
    views = _views(runs, shelf, maps, films)
    common = [
        picture
        for run, picture in shelf
        if run is None or (len(runs) == 1 and picture.name not in OWN)
    ]
    html = (
        templates.environment()
        .get_template("report.html")
        .render(
            generator=GENERATOR,
            title=report_text.titles(runs),
            descriptions=list(
                dict.fromkeys(
                    _one_line(run.scene.description) for run in runs if run.scene.description
                )
            ),
            text=report_text,
            hearing=hearing,
            citation=citation,
            runs=runs,
            views=views,
            contents=_contents(runs, views),
            unheard=list(unheard),
            lengths={round(run.sound.duration, 4) for run in runs},
            SHORT_S=caveats.SHORT_S,
            map_scale=scale,
            noted=any(view.repeats or view.playback.calibrated_pa is None for view in views),
            filmed=any(films),
            moved=any(film is not None and film.motion is not None for film in films),
            curves=common,
            surfaces=_surfaces(views),
            vibrations=_vibrations(views),
            css=templates.own_text("report.css"),
            js=templates.scripts(),
            lengths_of_extended=_lengths_of_extended(runs),
            row=_differ_in_seed(runs),
            **_script_data(runs, views, scale),
        )
    )
    return html.encode()


def _script_data(
    runs: Sequence[RunResult], views: Sequence[RunView], scale: MapScale | None
) -> dict[str, Any]:
    """Return the data of the page's script, and whether a record is short."""
    players = [view.player for view in views]
    data = {
        "runs": players,
        "view": asdict(scale) if scale else None,
        "tsv": report_text.tsv(runs),
        "bands": BAND_NAMES,
    }
    return {"data": data, "short": any(player["buzzes"] for player in players)}


def _rounded(levels: Mapping[str, float | None]) -> list[float | None]:
    """Return levels by band [dB], with three decimals."""
    return [None if (level := levels[name]) is None else round(level, 3) for name in BAND_NAMES]


def _contents(runs: Sequence[RunResult], views: Sequence[RunView]) -> list[tuple[str, str]]:
    """Return place and name of the sections of the page."""
    shown = {
        "compare": len(runs) > 1,
        "events": any("recovery_events" in view.pictures for view in views),
        "vibration": any(run.vibration is not None for run in runs),
    }
    return [(place, name) for place, name in SECTIONS.items() if shown.get(place, True)]


def _lengths_of_extended(runs: Sequence[RunResult]) -> list[tuple[int, str]]:
    """Return exponents and seconds of the extended records that the page can make.

    They are longer than all records; there are none where no record can be extended.
    """
    if all(run.sound.not_extendable for run in runs):
        return []
    longest = max(len(run.sound.pressure) for run in runs)
    return [
        (exponent, f"{2**exponent / wav.SAMPLE_RATE_HZ:.3g}")
        for exponent in EXTENDED
        if 2**exponent > longest
    ]


def _differ_in_seed(runs: Sequence[RunResult]) -> bool:
    """Return whether several runs that sound differ in the seed of their surface alone."""
    others = [
        run.scene.to_dict() | {"surface": run.scene.surface.model_dump() | {"seed": None}}
        for run in runs
        if SEED in run.values and not run.sound.not_extendable
    ]
    return len(runs) > 1 and len(others) == len(runs) and all(each == others[0] for each in others)


def _views(
    runs: Sequence[RunResult],
    shelf: Sequence[tuple[RunResult | None, Exhibit]],
    maps: Sequence[RunMaps | None],
    films: Sequence[Film | None],
) -> list[RunView]:
    """Return the runs with players, pictures, maps and films."""
    peaks = [float(np.abs(run.sound.pressure).max()) for run in runs]
    gains = playback.playbacks(peaks, [run.sound.levels.laeq_db for run in runs])
    views = []
    for run, gain, own_maps, film in zip(runs, gains, maps, films, strict=True):
        comment = f"full scale = {gain.full_scale_pa:.6g} Pa"
        record = wav.listening(
            run.sound.pressure, 1 / gain.full_scale_pa, comment, run.label, 16, run.sound.loops
        )
        pictures = {picture.name: picture for owner, picture in shelf if owner is run}
        views.append(
            RunView(run.label, run, gain, _uri("audio/wav", record), pictures, own_maps, film)
        )
    return views


def _film_data(film: Film) -> dict[str, Any]:
    """Return a film for the script of the page."""
    data = asdict(film) | {"ground": _uri("image/png", film.ground)}
    for name, sheet in (("pressure", film.pressure), ("release", film.release)):
        data[name]["png"] = _uri("image/png", sheet.png)
    return data


def _time_axis(picture: Picture) -> TimeAxis:
    """Read the time axis of a picture, whose label names the unit."""
    left, bottom, right, top = (100 * share for share in picture.plot_area())
    axes = picture.figure.axes[0]
    unit = axes.get_xlabel().partition("[")[2].partition("]")[0]
    second = next(1000.0**power for power, sign in PREFIXES.items() if f"{sign}s" == unit)
    begin, end = axes.get_xlim()
    return TimeAxis(left, right, 100 - top, 100 - bottom, begin * second, end * second)


def _surfaces(views: Sequence[RunView]) -> list[Surface]:
    """Return the different surfaces, each with the labels of its runs."""
    sharing: dict[str, list[RunView]] = {}
    for view in views:
        scene, grid = view.run.scene, view.run.scene.track
        key = (
            f"{scene.surface.model_dump_json()} {scene.height_path} {grid.n_along} {grid.n_across}"
        )
        sharing.setdefault(key, []).append(view)
    return [
        Surface(
            labels=[view.label for view in members],
            words=assumed.surface_words(members[0].run.scene),
            statistics=members[0].run.summary["surface"],
            picture=members[0].pictures["surface"],
        )
        for members in sharing.values()
    ]


def _vibrations(views: Sequence[RunView]) -> list[tuple[RunView, list[Exhibit]]]:
    """Return the runs that vibrate with their pictures; runs that share one show it once."""
    shown, seen = [], set[tuple[str, str]]()
    for view in views:
        summary, identity = view.run.summary, view.run.result.identity
        march = identity.text if identity else view.label
        bodies = (f"{summary.get(key)}" for key in ("ball_mass_kg", "plate_mobility_s_kg"))
        shared = {"contact_filter": march, "mobilities": " ".join([march, *bodies])}
        pictures = []
        for name in VIBRATION:
            key = name, shared.get(name, view.label)
            if name in view.pictures and key not in seen:
                pictures.append(view.pictures[name])
                seen.add(key)
        if pictures:
            shown.append((view, pictures))
    return shown


def _one_line(text: str) -> str:
    """Write a text of the scene on a single line, in printable letters."""
    return printable(" ".join(text.split()))


def _uri(kind: str, content: bytes) -> str:
    """Return a file as a data URI."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
