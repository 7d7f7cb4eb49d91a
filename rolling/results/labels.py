"""The words of a scene's keys, and the labels that distinguish runs on terminal, page and files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rolling.scene.scene import Scene
from rolling.scene.sections import Section
from rolling.scene.sweep import Value

LONGEST = 72  # characters of a label: the width of a row in a legend
_PROMINENT = 3  # differences that a label names even where fewer would distinguish the runs
_PATH = "surface.path"


class Word(NamedTuple):
    """The words for a key: quantity, unit, text for its absence; minor: labels avoid the key."""

    name: str
    unit: str = ""
    absent: str = ""
    minor: bool = False


_HEIGHTS = {  # keys of plate and sphere
    "kind": Word("surface"),
    "path": Word("heights"),
    "roughness_ra_um": Word("Ra", "µm"),
    "correlation_length_um": Word("correlation length", "µm"),
    "correlation_length_across_um": Word("correlation length across", "µm", "isotropic"),
    "autocorrelation": Word("autocorrelation"),
    "skewness": Word("skewness", "", "skewness 0"),
    "kurtosis": Word("kurtosis", "", "kurtosis 3"),
    "lay_deg": Word("lay", "°", "lay along the track"),
    "hurst": Word("Hurst exponent"),
    "rolloff_um": Word("roll-off", "µm"),
    "shortest_um": Word("shortest wave", "µm"),
    "rq_um": Word("Sq", "µm", "no Sq"),
    "rdq": Word("Sdq", "", "no Sdq"),
    "height_unit": Word("height unit"),
    "seed": Word("seed"),
}
WORDS = {  # in the order in which labels name them
    "rolling.load_n": Word("load", "N"),
    "rolling.speed_m_s": Word("speed", "m/s"),
    "rolling.resistance": Word("rolling resistance", "", "no rolling resistance"),
    "rolling.drop_mm": Word("drop", "mm", "no drop"),
    **{f"surface.{name}": word for name, word in _HEIGHTS.items()},
    "surface.level": Word("levelling"),
    "surface.faults": Word("faults", "", "no faults"),
    "sphere.radius_mm": Word("sphere radius", "mm"),
    **{
        f"sphere.surface.{name}": word._replace(name=f"sphere {word.name}", absent="")
        for name, word in _HEIGHTS.items()
    },
    "sphere.surface.grade": Word("grade"),
    "sphere.surface.spacing_um": Word("sphere spacing", "µm", minor=True),
    "sphere.surface.waviness": Word("waviness", "", "no waviness"),
    "sphere.surface.faults": Word("sphere faults", "", "no sphere faults"),
    "sphere.youngs_modulus_gpa": Word("sphere Young's modulus", "GPa", "rigid sphere"),
    "sphere.poissons_ratio": Word("sphere Poisson's ratio"),
    "sphere.density_kg_m3": Word("sphere density", "kg/m³", "sphere density as steel"),
    "plate.youngs_modulus_gpa": Word("Young's modulus", "GPa"),
    "plate.poissons_ratio": Word("Poisson's ratio"),
    "plate.hardness_gpa": Word("hardness", "GPa", "no hardness"),
    "plate.density_kg_m3": Word("plate density", "kg/m³", "no plate density"),
    "plate.thickness_mm": Word("thickness", "mm", "half-space"),
    "plate.loss_factor": Word("loss factor", "", "no loss factor"),
    "plate.length_mm": Word("plate length", "mm", "infinite plate"),
    "plate.width_mm": Word("plate width", "mm", "no plate width"),
    "plate.contact_mm": Word("contact point", "mm", "default contact point"),
    "plate.contact_path": Word("contact path", "", "fixed contact"),
    "plate.contact_end_mm": Word("end of the path", "mm", "no end of the path"),
    "plate.contact_loss_factor": Word("contact loss factor", "", "no contact loss"),
    "surface.spacing_um": Word("spacing", "µm"),
    "numerics.step_nodes": Word("step", "nodes"),
    "numerics.edges": Word("edges"),
    "numerics.subcells": Word("sub-cells"),
    "recovery.rule": Word("release rule"),
    "sound.source": Word("source"),
    "sound.ball": Word("ball"),
    "sound.distance_m": Word("distance", "m"),
    "sound.listener_mm": Word("listener", "mm", "listener above the contact"),
    "sound.q": Word("q"),
    "sound.gain_pa_per_w_m2": Word("gain", "Pa per W/m²", "no fixed gain"),
    "numerics.tolerance": Word("tolerance", minor=True),
    "surface.width_um": Word("width", "µm", minor=True),
    "rolling.duration_s": Word("duration", "s", "once round the file", minor=True),
    "rolling.distance_mm": Word("distance rolled", "mm", "no distance rolled", minor=True),
    "rolling.start_um": Word("start", "µm", minor=True),
    "dynamics.loads": Word("loads", minor=True),
    "dynamics.span": Word("span", minor=True),
    "dynamics.release": Word("release under the moving load", minor=True),
    "numerics.precision": Word("precision", minor=True),
    "numerics.error_estimate": Word("error estimate", minor=True),
    "recovery.events": Word("recovery events", minor=True),
    "sound.listen_s": Word("long listening", "s", "no long listening", minor=True),
    "sound.loudness": Word("loudness", minor=True),
}


class Labelled(Protocol):
    """A run, solved or not, with its swept values by dotted key, its scene and its folder."""

    @property
    def values(self) -> Mapping[str, Value]: ...  # noqa: D102
    @property
    def scene(self) -> Scene: ...  # noqa: D102
    @property
    def folder(self) -> Path: ...  # noqa: D102


def named(key: str) -> tuple[str, str]:
    """Return word and unit of a dotted key: rolling.load_n is load in N."""
    word = WORDS.get(key, Word(key))  # a section has its own name
    return word.name, word.unit


def worded(key: str, value: float | str) -> str:
    """Write a value with its word and unit, or with its label: load 5 N, surface lapped."""
    name, unit = named(key)
    return f"{name} {printable(value) if isinstance(value, str) else f'{value:g} {unit}'}".rstrip()


def labels(runs: Sequence[Labelled]) -> list[str]:
    """Name runs by their differences in labels that differ and have at most `LONGEST` characters.

    The scene's name comes first where names differ; swept values and other differences follow, as
    many as distinguish the runs. The names of the folders, and at last a number, distinguish runs
    of equal scenes. A single run is named by its swept values, or by its load.
    """
    names = [run.scene.name for run in runs]
    rows = zip(*_parts(runs), strict=True)
    texts = [", ".join(filter(None, row)) for row in rows]
    if len(set(names)) > 1:
        texts = [f"{name}, {text}" for name, text in zip(names, texts, strict=True)]
    homes = [(run.folder.parent if run.values else run.folder).resolve().name for run in runs]
    shared: dict[str, set[str]] = {}
    for text, home in zip(texts, homes, strict=True):
        shared.setdefault(text, set()).add(home)
    texts = [
        f"{text} ({printable(home)})" if len(shared[text]) > 1 else text
        for text, home in zip(texts, homes, strict=True)
    ]
    return _numbered([_cut(text, LONGEST) for text in texts])


def title(name: str, label: str) -> str:
    """Put the scene's name before a label, unless the label begins with it."""
    return label if label.partition(", ")[0] == name else f"{name}, {label}"


def printable(text: str) -> str:
    r"""Escape control characters, directions of writing and bytes that are not UTF-8.

    A line feed becomes \n, the byte 255 in the name of a file \xff.
    """

    def escaped(letter: str) -> str:
        if 0xDC80 <= ord(letter) <= 0xDCFF:  # Python's surrogate for a byte that is not UTF-8
            return f"\\x{ord(letter) - 0xDC00:02x}"
        return letter.encode("unicode_escape").decode("ascii")

    return "".join(letter if letter.isprintable() else escaped(letter) for letter in text)


def _parts(runs: Sequence[Labelled]) -> list[list[str]]:
    """Choose the keys that labels name, and return a text of each of them for each run."""
    swept = list(dict.fromkeys(key for run in runs for key in run.values))
    sections = tuple(f"{key}." for key in swept if key not in WORDS)  # swept under labels
    keys = [*swept, *(key for key in WORDS if not key.startswith(sections))]
    texts = {key: _texts(key, runs) for key in dict.fromkeys(keys)}
    minor = {key: WORDS.get(key, Word(key)).minor for key in texts}
    differing = sorted((key for key in texts if len(set(texts[key])) > 1), key=minor.__getitem__)
    names = [run.scene.name for run in runs]
    chosen = [key for key in swept if key in differing] or swept
    if len(set(names)) == 1:
        major = [key for key in differing if key not in chosen and not minor[key]]
        chosen += major[: max(0, _PROMINENT - len(chosen))]
    for key in differing:
        known = [names, *(texts[name] for name in chosen)]
        rows = len(set(zip(*known, strict=True)))
        if key not in chosen and len(set(zip(*known, texts[key], strict=True))) > rows:
            chosen.append(key)
    return [texts[key] for key in chosen or ["rolling.load_n"]]


def _texts(key: str, runs: Sequence[Labelled]) -> list[str]:
    """Write the value of a key for each run, as short as different values stay different."""
    word = WORDS.get(key, Word(key))
    swept = [run.values.get(key) for run in runs]
    values = [_value(run.scene, key) for run in runs]
    present = {value for value in values if value is not None}
    written = {}
    for digits in range(1, 20):
        written = {value: _written(word, value, digits) for value in present}
        if len(set(written.values())) == len(present):
            break
    texts = []
    for run, label, value in zip(runs, swept, values, strict=True):
        section, _, last = key.rpartition(".")
        if isinstance(label, str) and key != _PATH and label != value:  # swept under labels
            texts.append(f"{word.name} {printable(label)}")
        elif value is not None:
            texts.append(written[value])
        else:  # a key that the kind of surface lacks has no words
            texts.append(word.absent if hasattr(value_at(run.scene, section), last) else "")
    return texts


def _value(scene: Scene, key: str) -> Any:
    """Read the value of a dotted key, or None; a height file is its place on the disk."""
    if key == _PATH:
        return scene.height_path and scene.height_path.resolve()
    value = value_at(scene, key)
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {number:g}" for name, number in value.items())
    if isinstance(value, list):
        return f"({len(value)})"
    return None if isinstance(value, Section) else value


def value_at(scene: Scene, key: str) -> Any:
    """Read the value of a dotted key, None where a section lacks it."""
    value: Any = scene
    for name in key.split("."):
        value = getattr(value, name, None)
    return value


def _written(word: Word, value: Any, detail: int) -> str:
    """Write a value with its word and unit; more detail shows all digits, or more folders."""
    if isinstance(value, bool):
        return f"{'with' if value else 'without'} {word.name}"
    if isinstance(value, Path):
        return f"{word.name} {printable('/'.join(value.parts[-detail:]))}"
    if isinstance(value, str):
        return f"{word.name} {printable(value.replace('_', ' '))}"
    if isinstance(value, tuple) and word.unit == "mm":  # a point, or listeners
        points = value if isinstance(value[0], tuple) else (value,)
        texts = (", ".join(f"{x:.{detail + 3}g}" for x in point) for point in points)
        return f"{word.name} {'; '.join(texts)} {word.unit}"
    if isinstance(value, tuple) and detail == 1:  # a speed that changes
        speeds = [speed for _, speed in value]
        return f"{word.name} {min(speeds):g} to {max(speeds):g} {word.unit}"
    if isinstance(value, tuple):
        pairs = (f"{speed!r} {word.unit} at {time!r} s" for time, speed in value)
        return f"{word.name} {', '.join(pairs)}"
    return f"{word.name} {f'{value:g}' if detail == 1 else value} {word.unit}".rstrip()


def _cut(text: str, longest: int) -> str:
    """Cut a long text in its middle."""
    head = longest // 2
    return text if len(text) <= longest else f"{text[:head]}…{text[head + 1 - longest :]}"


def _numbered(texts: Sequence[str]) -> list[str]:
    """Append a number to texts that are equal."""
    count, numbers, numbered = Counter(texts), Counter[str](), dict[str, None]()
    for text in texts:
        label = text
        while count[text] > 1 and (label in count or label in numbered):
            numbers[text] += 1
            ending = f" ({numbers[text]})"
            label = text[: LONGEST - len(ending)] + ending
        numbered[label] = None
    return list(numbered)
