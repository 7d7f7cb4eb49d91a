"""Runs as one HTML page to be heard, seen and read: a single file that needs no network. Depends on jinja2.

Gathers what the page shows, as plain text, numbers and data URIs; how it looks and moves is in `page/`.
"""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.resources import files
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from acoustics import wav
from rolling import citation, figures, playback, reference, report_text, sprites
from rolling.heard import Heard
from rolling.picture import Picture
from rolling.playback import Playback
from rolling.scenario import track
from rolling.simulate import PressureMap

LARGEST_CSV = 200_000  # bytes on the page; longer tables stay in the run folder
TIMELINES = ("release_power", "spectrogram")  # pictures over the time of one run


@dataclass(frozen=True)
class Exhibit:
    """A picture on the page; its curves as a link, where there are any and they are short enough."""

    name: str
    alt: str
    src: str
    csv: str | None
    has_curves: bool


@dataclass(frozen=True)
class Timeline:
    """A picture over time: where its plot lies in it [percent], and the times [s] at the plot's sides."""

    picture: Exhibit
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
    """One run on the page."""

    label: str
    heard: Heard
    playback: Playback
    wav: str
    timelines: dict[str, Timeline]
    events: Exhibit | None


def page(runs: Sequence[Heard], unheard: Sequence[str] = ()) -> bytes:
    """The page of one run or several.

    Parameters
    ----------
    runs : in the order in which they are to be seen, at least one.
    unheard : labels of runs of which too little is solved for a sound.
    """
    runs = distinct(runs)
    peaks = [float(np.abs(one.sound.pressure).max()) for one in runs]
    players = playback.playbacks(peaks, [one.sound.levels.laeq_db for one in runs])
    pictures = [{picture.name: picture for picture in figures.of_run(one, runs)} for one in runs]
    shown = [_shown(*each) for each in zip(runs, players, pictures, strict=True)]
    maps = _maps(runs)
    data = {
        "runs": [_played(one) | {"maps": seen} for one, seen in zip(shown, maps["runs"], strict=True)],
        "view": maps["view"],
        "tsv": report_text.tsv(runs),
    }
    html = (
        _environment()
        .get_template("report.html")
        .render(
            title=", ".join(dict.fromkeys(one.scene.name for one in runs)),
            descriptions=list(dict.fromkeys(one.scene.description for one in runs if one.scene.description)),
            text=report_text,
            citation=citation,
            heard=runs,
            runs=shown,
            unheard=list(unheard),
            partial=[one.label for one in runs if not one.result.complete],
            lengths=sorted({round(one.sound.duration, 4) for one in runs}),
            view=maps["view"],
            shared=[_exhibit(picture) for picture in figures.of_runs(runs)],
            surfaces=_surfaces(runs, pictures),
            data=data,
            css=_own("report.css"),
            js=_own("report.js"),
        )
    )
    return html.encode()


def distinct(runs: Sequence[Heard]) -> list[Heard]:
    """The runs with labels that tell them apart: with the scene's name, its folder's or a number where they are alike."""
    labels = [one.label for one in runs]
    if len({one.scene.name for one in runs}) > 1:
        labels = [f"{one.scene.name}, {label}" for one, label in zip(runs, labels, strict=True)]

    def told_apart(by: Callable[[int], str]) -> list[str]:
        count = Counter(labels)
        return [f"{label} ({by(k)})" if count[label] > 1 else label for k, label in enumerate(labels)]

    labels = told_apart(lambda k: (runs[k].folder.parent if runs[k].values else runs[k].folder).resolve().name)
    labels = told_apart(lambda k: str(k + 1))
    return [one if label == one.label else replace(one, label=label) for one, label in zip(runs, labels, strict=True)]


def _shown(one: Heard, player: Playback, pictures: dict[str, Picture]) -> Shown:
    comment = f"full scale = {player.full_scale_pa:.6g} Pa"
    timelines = {name: _timeline(pictures[name]) for name in TIMELINES if name in pictures}
    events = pictures.get("recovery_events")
    return Shown(
        label=one.label,
        heard=one,
        playback=player,
        wav=_uri("audio/wav", wav.listening(one.sound.pressure, 1 / player.full_scale_pa, comment, one.label, bits=16)),
        timelines=timelines,
        events=_exhibit(events) if events else None,
    )


def _played(one: Shown) -> dict[str, Any]:
    """What the player needs of a run."""
    sound = one.heard.sound
    return {
        "label": one.label,
        "seconds": len(sound.pressure) / sound.sample_rate,
        "loops": sound.closed,
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
    sheets = {k: sprites.sheet(_seen(one), _middle(one), greatest) for k, one in having.items()}
    radii = {k: 1e6 * _hertz_radius(one) for k, one in having.items()}
    view = {
        "half_um": sprites.half_width(list(sheets.values()), list(radii.values())),
        "greatest_gpa": greatest * 1e-9,
        "hardness": bool(np.isfinite(hardest)),
        "colours": [f"rgb({r},{g},{b})" for r, g, b in sprites.palette()[1::2]],
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
    return (track(one.scene).n_across - 1) / 2 * one.scene.spacing


def _hertz_radius(one: Heard) -> float:
    return reference.hertz_radius(one.scene.load, one.scene.radius, one.scene.contact_modulus)


def _placed(one: Heard, sheet: sprites.Sheet, hertz_um: float) -> dict[str, Any]:
    """The maps of a run with what is told beside them, position by position."""
    result, maps = one.result, _seen(one)
    positions = np.array([each.position for each in maps])
    lap, rolled = result.solved_steps * result.step, result.done_steps * result.step
    closes = result.complete and track(one.scene).closed
    begins, order = sprites.showing(positions * result.step, lap, rolled, closes, one.scene.motion)

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


def _timeline(picture: Picture) -> Timeline:
    left, bottom, right, top = (100 * share for share in picture.plot_area())
    axes = picture.figure.axes[0]
    unit = axes.get_xlabel().partition("[")[2].partition("]")[0]
    second = {"ks": 1e3, "s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}[unit]
    begin, end = axes.get_xlim()
    return Timeline(_exhibit(picture), left, right, 100 - top, 100 - bottom, begin * second, end * second)


def _exhibit(picture: Picture) -> Exhibit:
    csv = picture.csv() if picture.columns else b""
    link = _uri("text/csv", csv) if 0 < len(csv) <= LARGEST_CSV else None
    return Exhibit(picture.name, picture.alt, _uri("image/svg+xml", picture.svg()), link, bool(csv))


def _surfaces(runs: Sequence[Heard], pictures: Sequence[dict[str, Picture]]) -> list[Surface]:
    """The different surfaces, each with the runs that roll over it."""
    sharing: dict[str, list[int]] = {}
    for k, one in enumerate(runs):
        way = track(one.scene)
        key = f"{one.scene.surface.model_dump_json()} {one.scene.height_path} {way.n_along} {way.n_across}"
        sharing.setdefault(key, []).append(k)
    return [
        Surface(
            labels=[runs[k].label for k in members],
            words=report_text.surface_words(runs[members[0]].scene),
            statistics=runs[members[0]].numbers["surface"],
            picture=_exhibit(pictures[members[0]]["surface"]),
        )
        for members in sharing.values()
    ]


def _uri(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rolling", "page"),
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


def _own(name: str) -> Markup:
    """A file of the page, which is the program's own text."""
    return Markup(files("rolling").joinpath("page", name).read_text(encoding="utf-8"))
