"""All pictures of README and docs, in the order in which they are made."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import answer_pictures
import bearing_pictures
import contact_pictures
import drawn_pictures
import growth_picture
import instrument_picture
import machine_drawings
import measured_pictures
import sound_pictures
import speed_pictures
import surface_pictures
from page_pictures import PAGE_PICTURES
from picture_parts import Picture, PictureScene

ENTRIES = tomllib.loads(Path(__file__).with_name("pictures.toml").read_text(encoding="utf-8"))
DRAW: dict[str, drawn_pictures.Draw] = {
    "model": machine_drawings.model,
    "bearing": machine_drawings.bearing,
    "contact": contact_pictures.pressure,
    "roughness-in-hertz": contact_pictures.roughness_in_hertz,
    "running-in": contact_pictures.running_in,
    "made-surfaces": surface_pictures.made,
    "scan": surface_pictures.scan,
    "loads": sound_pictures.loads,
    "knob-roughness": sound_pictures.knob,
    "knob-speed": sound_pictures.knob,
    "knob-load": sound_pictures.knob,
    "knob-radius": sound_pictures.knob,
    "knob-thickness": sound_pictures.knob,
    "sources": sound_pictures.sources,
    "rolling-out": sound_pictures.rolling_out,
    "bearing-spectrum": bearing_pictures.spectrum,
    "bearing-fault": bearing_pictures.fault,
    "finishes": answer_pictures.finishes,
    "improve": answer_pictures.improve,
    "bench": answer_pictures.bench,
    "speed": speed_pictures.easy,
    "speed-hard": speed_pictures.hard,
    "growth": growth_picture.growth,
    "calibration": measured_pictures.calibration,
}


def _drawn() -> Iterator[Picture]:
    """Yield the pictures of pictures.toml."""
    for stem, entry in ENTRIES.items():
        scenes = {
            label: PictureScene(scene["name"], scene.get("settings", ()))
            for label, scene in entry.get("scenes", {}).items()
        }
        if stem == instrument_picture.STEM:
            make = partial(instrument_picture.make, entry=entry, scenes=scenes)
        else:
            make = partial(drawn_pictures.make, draw=DRAW[stem], entry=entry, scenes=scenes)
        yield Picture(
            name=stem,
            stem=stem,
            make=make,
            scenes=scenes,
            ending=entry.get("ending", ".svg"),
            has_dark=True,
            is_quick=entry.get("is_quick", False),
        )


ALL = (*PAGE_PICTURES, *_drawn())
