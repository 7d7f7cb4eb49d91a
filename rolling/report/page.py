"""Runs as one HTML page to be heard, seen and read: a single file that needs no network. Depends on jinja2.

Gathers what the page shows, as plain text, numbers and data URIs; how it looks and moves is in `page/`.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from acoustics import wav
from rolling import __version__
from rolling.contact import closed_forms
from rolling.figures import run_figures
from rolling.figures.picture import Picture
from rolling.folders import program
from rolling.report import citation, playback, pressure_maps
from rolling.report import text as report_text
from rolling.report.playback import Playback
from rolling.simulation import caveats
from rolling.simulation.caveats import Caveat
from rolling.simulation.labels import printable
from rolling.simulation.run_result import Heard
from rolling.simulation.simulate import PressureMap

LARGEST_CSV = 200_000  # bytes on the page; longer tables stay in the run folder
GENERATOR = f"{program.NAME} {__version__}"
MOST_RUNS = 24  # on one page: it grows by half a megabyte and more with each
TIMELINES = ("release_power", "spectrogram")  # pictures over the time of one run
OWN = (*TIMELINES, "surface", "contact", "recovery_events")  # pictures that show one run however many there are


@dataclass(frozen=True)
class Exhibit:
    """A picture on the page; its curves as a link, where there are any and they are short enough."""

    name: str
    alt: str
    src: str
    csv: str | None
    has_curves: bool
    time: TimeAxis | None


@dataclass(frozen=True)
class TimeAxis:
    """Where the plot of a picture over time lies in it [percent], and the times [s] at the plot's sides."""

    left: float
    right: float
    top: float
    bottom: float
    begin: float
    end: float


@dataclass(frozen=True)
class Surface:
    """A surface that some runs share."""

    labels: list[str]
    words: str
    statistics: dict[str, float]
    picture: Exhibit


@dataclass(frozen=True)
class Shown:
    """One run on the page; pictures by name."""

    label: str
    heard: Heard
    playback: Playback
    wav: str
    pictures: dict[str, Exhibit]

    @property
    def repeats(self) -> list[Caveat]:
        """Caveats of a record that is heard as the tone of its repetition."""
        return [each for each in caveats.stored(self.heard.numbers) if each.key in caveats.REPEATS]


def is_page(path: Path) -> bool:
    """Return whether a file is a page of this program, of version 0.2.0 or later."""
    with path.open("rb") as file:
        return f'<meta name="generator" content="{program.NAME} '.encode() in file.read(4096)


def belongs(one: Heard | None, name: str, runs: int) -> bool:
    """Whether a picture is on the page: curves of one run are not where several are compared."""
    return one is None or runs == 1 or name in OWN


def exhibits(runs: Sequence[Heard]) -> list[tuple[Heard | None, Exhibit]]:
    """The pictures for the page of these runs, each with the run it shows or None."""
    return [(one, exhibit(each)) for one, each in run_figures.gallery(runs) if belongs(one, each.name, len(runs))]


def exhibit(picture: Picture) -> Exhibit:
    """A picture as the page holds it."""
    csv = picture.csv() if picture.columns else b""
    link = _uri("text/csv", csv) if 0 < len(csv) <= LARGEST_CSV else None
    time = _time_axis(picture) if picture.name in TIMELINES else None
    return Exhibit(picture.name, picture.alt, _uri("image/svg+xml", picture.svg()), link, bool(csv), time)


def page(runs: Sequence[Heard], shelf: Sequence[tuple[Heard | None, Exhibit]], unheard: Sequence[str] = ()) -> bytes:
    """The page of one run or several.

    Parameters
    ----------
    runs : in the order in which they are to be seen, with labels that tell them apart; at least one.
    shelf : their pictures, as `exhibits` gives them.
    unheard : labels of runs of which too little is solved for a sound.
    """
    peaks = [float(np.abs(one.sound.pressure).max()) for one in runs]
    players = playback.playbacks(peaks, [one.sound.levels.laeq_db for one in runs])
    shown = [
        _shown(one, player, {each.name: each for whose, each in shelf if whose is one})
        for one, player in zip(runs, players, strict=True)
    ]
    maps = _maps(runs)
    data = {
        "runs": [_played(one) | {"maps": seen} for one, seen in zip(shown, maps["runs"], strict=True)],
        "view": maps["view"],
        "tsv": report_text.tsv(runs),
    }
    html = (
        environment()
        .get_template("report.html")
        .render(
            generator=GENERATOR,
            title=", ".join(dict.fromkeys(one.scene.name for one in runs)),
            descriptions=list(dict.fromkeys(_one_line(one.scene.description) for one in runs if one.scene.description)),
            text=report_text,
            citation=citation,
            heard=runs,
            runs=shown,
            unheard=list(unheard),
            lengths={round(one.sound.duration, 4) for one in runs},
            SHORT_S=caveats.SHORT_S,
            short=any(one["buzzes"] for one in data["runs"]),
            view=maps["view"],
            curves=[each for whose, each in shelf if whose is None or (len(runs) == 1 and each.name not in OWN)],
            surfaces=_surfaces(shown),
            data=data,
            css=own_text("report.css"),
            js=own_text("report.js"),
        )
    )
    return html.encode()


def _shown(one: Heard, player: Playback, pictures: dict[str, Exhibit]) -> Shown:
    comment = f"full scale = {player.full_scale_pa:.6g} Pa"
    record = wav.listening(one.sound.pressure, 1 / player.full_scale_pa, comment, one.label, bits=16)
    return Shown(one.label, one, player, _uri("audio/wav", record), pictures)


def _played(one: Shown) -> dict[str, Any]:
    """What the player needs of a run."""
    sound = one.heard.sound
    return {
        "label": one.label,
        "seconds": len(sound.pressure) / sound.sample_rate,
        "loops": sound.loops,
        "buzzes": any(each.key == "short_loop" for each in one.repeats),
        "playback": asdict(one.playback),
    }


def _maps(runs: Sequence[Heard]) -> dict[str, Any]:
    """Pressure maps of all runs on one scale of length and one of pressure; None for runs without any."""
    having = {k: one for k, one in enumerate(runs) if one.result.maps}
    if not having:
        return {"runs": [None] * len(runs), "view": None}
    hardest = max(one.scene.hardness for one in having.values())
    largest = max(float(each.pressure.max()) for one in having.values() for each in one.result.maps.values())
    greatest = hardest if np.isfinite(hardest) else largest
    sheets = {k: pressure_maps.sheet(_seen(one), _middle(one), greatest) for k, one in having.items()}
    radii = {k: 1e6 * _hertz_radius(one) for k, one in having.items()}
    view = {
        "half_um": pressure_maps.half_width(list(sheets.values()), list(radii.values())),
        "greatest_gpa": greatest * 1e-9,
        "hardness": bool(np.isfinite(hardest)),
        "colours": [f"rgb({r},{g},{b})" for r, g, b in pressure_maps.palette()[1::2]],
    }
    return {
        "runs": [_placed(runs[k], sheets[k], radii[k]) if k in having else None for k in range(len(runs))],
        "view": view,
    }


def _seen(one: Heard) -> list[PressureMap]:
    """Maps of the part of the track that is heard."""
    maps = one.result.maps
    return [maps[position] for position in sorted(maps) if position <= one.result.done_steps]


def _middle(one: Heard) -> float:
    """Where across the plate the sphere runs [m]."""
    return (one.scene.track.n_across - 1) / 2 * one.scene.spacing


def _hertz_radius(one: Heard) -> float:
    return closed_forms.hertz_radius(one.scene.load, one.scene.radius, one.scene.contact_modulus)


def _placed(one: Heard, sheet: pressure_maps.Sheet, hertz_um: float) -> dict[str, Any]:
    """The maps of a run with what is told beside them, position by position."""
    result, maps = one.result, _seen(one)
    positions = np.array([each.position for each in maps])
    lap, rolled = result.solved_steps * result.step, result.done_steps * result.step
    closes = result.complete and one.scene.track.closed
    begins, order = pressure_maps.showing(positions * result.step, lap, rolled, closes, one.scene.motion)

    def state(name: str, factor: float) -> list[float | None]:
        values = result.series[name][positions] * factor
        return [float(f"{value:.4g}") if np.isfinite(value) else None for value in values]

    return {
        "sheet": _uri("image/png", sheet.png),
        "tiles": sheet.tiles,
        "boxes": [[round(value, 4) for value in box] for box in sheet.boxes],
        "begins": np.round(begins, 7).tolist(),
        "order": order.tolist(),
        "hertz_um": hertz_um,
        "load_n": one.scene.load,
        "position_mm": [float(f"{each.distance * 1e3:.6g}") for each in maps],
        "max_pressure_gpa": state("max_pressure", 1e-9),
        "contact_um2": state("contact_area", 1e12),
        "plastic_um2": state("plastic_area", 1e12),
    }


def _time_axis(picture: Picture) -> TimeAxis:
    left, bottom, right, top = (100 * share for share in picture.plot_area())
    axes = picture.figure.axes[0]
    unit = axes.get_xlabel().partition("[")[2].partition("]")[0]
    second = {"ks": 1e3, "s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}[unit]
    begin, end = axes.get_xlim()
    return TimeAxis(left, right, 100 - top, 100 - bottom, begin * second, end * second)


def _surfaces(runs: Sequence[Shown]) -> list[Surface]:
    """The different surfaces, each with the runs that roll over it."""
    sharing: dict[str, list[Shown]] = {}
    for one in runs:
        scene, way = one.heard.scene, one.heard.scene.track
        key = f"{scene.surface.model_dump_json()} {scene.height_path} {way.n_along} {way.n_across}"
        sharing.setdefault(key, []).append(one)
    return [
        Surface(
            labels=[one.label for one in members],
            words=report_text.surface_words(members[0].heard.scene),
            statistics=members[0].heard.numbers["surface"],
            picture=members[0].pictures["surface"],
        )
        for members in sharing.values()
    ]


def _one_line(text: str) -> str:
    """Write a text of the scene on one line, in letters that can be printed."""
    return printable(" ".join(text.split()))


def _uri(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def environment() -> jinja2.Environment:
    """Of the pages: everything that is filled in is escaped, and what is missing is an error."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rolling.report", "assets"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["slug"] = _slug
    # What is no number must not reach the page's script, where it would not be JSON.
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment


def _slug(label: str) -> str:
    """A label as part of a file's name."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", label).strip("_")


def own_text(name: str) -> Markup:
    """A file of the page, which is the program's own text."""
    return Markup(files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8"))
