"""The words of a scene's keys, and the labels that distinguish runs.

Terminal, figures, tables, page and files all take the names of runs from `labels`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from rolling.scene.scene import Scene
from rolling.scene.sweep import Value

LONGEST = 72  # characters of a label: the width of a row in a legend
_LONGEST_PART = 28  # characters of a scene's or a folder's name in a label that would be too long
_PROMINENT = 3  # differences that a label names even where fewer would distinguish the runs
_CUT = "…"


@dataclass(frozen=True)
class Word:
    """The words for a key of the scene.

    name : str. Quantity in the field's term.
    unit : str. Unit as it is printed; empty for text and for numbers without a unit.
    absent : str. Words for a scene that omits the key; if empty, the label omits the quantity.
    minor : bool. Whether a label avoids the key, because it follows from other keys or hardly
        changes the sound.
    """

    name: str
    unit: str = ""
    absent: str = ""
    minor: bool = False


WORDS = {  # in the order in which labels name them
    "rolling.load_n": Word("load", "N"),
    "rolling.speed_m_s": Word("speed", "m/s"),
    "surface.kind": Word("surface"),
    "surface.path": Word("heights"),
    "surface.roughness_ra_um": Word("Ra", "µm"),
    "surface.correlation_length_um": Word("correlation length", "µm"),
    "surface.correlation_length_across_um": Word(
        "correlation length across", "µm", "correlation length across as along"
    ),
    "surface.autocorrelation": Word("autocorrelation"),
    "surface.height_unit": Word("height unit"),
    "surface.level": Word("levelling"),
    "surface.seed": Word("seed"),
    "sphere.radius_mm": Word("sphere radius", "mm"),
    "sphere.youngs_modulus_gpa": Word("sphere Young's modulus", "GPa", "rigid sphere"),
    "sphere.poissons_ratio": Word("sphere Poisson's ratio"),
    "sphere.density_kg_m3": Word("sphere density", "kg/m³", "sphere density as steel"),
    "plate.youngs_modulus_gpa": Word("Young's modulus", "GPa"),
    "plate.poissons_ratio": Word("Poisson's ratio"),
    "plate.hardness_gpa": Word("hardness", "GPa", "no hardness"),
    "plate.density_kg_m3": Word("plate density", "kg/m³", "no plate density"),
    "plate.thickness_mm": Word("thickness", "mm", "half-space"),
    "plate.loss_factor": Word("loss factor", "", "no loss factor"),
    "surface.spacing_um": Word("spacing", "µm"),
    "numerics.step_nodes": Word("step", "nodes"),
    "numerics.edges": Word("edges"),
    "numerics.subcells": Word("sub-cells"),
    "recovery.rule": Word("release rule"),
    "sound.source": Word("source"),
    "sound.ball": Word("ball"),
    "sound.distance_m": Word("distance", "m"),
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
    "sound.loudness": Word("loudness", minor=True),
}


class Labelled(Protocol):
    """A run, solved or not, for which a label can be made."""

    @property
    def values(self) -> Mapping[str, Value]:
        """The swept values of the run, by dotted key."""

    @property
    def scene(self) -> Scene:
        """The scene without its sweep."""

    @property
    def folder(self) -> Path:
        """The run's own folder."""


def named(key: str) -> tuple[str, str]:
    """Return word and unit of a dotted key: rolling.load_n is load in N."""
    word = WORDS.get(key, Word(key))  # a section has its own name
    return word.name, word.unit


def worded(key: str, value: float | str) -> str:
    """Write a value with its word and unit, or with its label: load 5 N, surface lapped."""
    name, unit = named(key)
    if isinstance(value, str):
        return f"{name} {printable(value)}"
    return f"{name} {value:g} {unit}".rstrip()


def labels(runs: Sequence[Labelled]) -> list[str]:
    """Name runs by their differences.

    All labels differ, are printable and have at most `LONGEST` characters. The scene's name comes
    first if the names differ. The swept values and other differences between the scenes follow, as
    many as distinguish the runs. Runs of equal scenes are distinguished by the names of their
    folders, and finally by a number. A single run is named by its swept values, or by its load.
    """
    names, folders = [run.scene.name for run in runs], _folder_names(runs)
    parts = _parts(runs)
    texts = _joined(names, folders, parts)
    if max(map(len, texts), default=0) > LONGEST:
        texts = _joined(shortened(names, _LONGEST_PART), shortened(folders, _LONGEST_PART), parts)
    return _numbered(shortened(texts, LONGEST))


def title(name: str, label: str) -> str:
    """Put the scene's name before a label, unless the label begins with it, whole or cut."""
    first = label.partition(", ")[0]
    head, cut, tail = first.partition(_CUT)
    begins = first == name or bool(cut and name.startswith(head) and name.endswith(tail))
    return label if begins else f"{name}, {label}"


def printable(text: str) -> str:
    r"""Escape the characters that cannot be printed.

    They are control characters, directions of writing and bytes that are not UTF-8. A line feed
    becomes \n, the byte 255 in the name of a file \xff.
    """
    return "".join(letter if letter.isprintable() else _escaped(letter) for letter in text)


def shortened(texts: Sequence[str], longest: int) -> list[str]:
    """Cut long texts in the middle, or around the place where they differ.

    Different texts stay different if a stretch of `longest` characters distinguishes them.
    """
    short: dict[str, str] = {}
    for text in dict.fromkeys(texts):
        head = (longest - len(_CUT) + 1) // 2
        short[text] = (
            text
            if len(text) <= longest
            else text[:head] + _CUT + text[head + len(_CUT) - longest :]
        )
    alike: dict[str, list[str]] = {}
    for text, cut in short.items():
        alike.setdefault(cut, []).append(text)
    for group in alike.values():
        if len(group) > 1:
            short |= _windows(group, longest)
    return [short[text] for text in texts]


# ---- the parts of a label


def _parts(runs: Sequence[Labelled]) -> list[list[str]]:
    """Choose the quantities that labels name, and write them for every run.

    The text is empty where a quantity does not apply.
    """
    swept = list(dict.fromkeys(key for run in runs for key in run.values))
    labelled = {key: texts for key in swept if (texts := _labelled(key, runs)) is not None}
    differing = {
        key: written
        for key in WORDS
        if key.partition(".")[0] not in labelled and len(set(written := _texts(key, runs))) > 1
    }
    differing |= {key: texts for key, texts in labelled.items() if len(set(texts)) > 1}
    names = [run.scene.name for run in runs]
    chosen = [key for key in swept if key in differing] or swept
    if len(set(names)) == 1:
        major = [key for key in differing if key not in chosen and not _is_minor(key)]
        chosen += major[: max(0, _PROMINENT - len(chosen))]
    parts = {key: labelled.get(key) or _texts(key, runs) for key in chosen}
    for key in sorted(differing, key=_is_minor):
        before = len(set(zip(names, *parts.values(), strict=True)))
        if (
            key not in parts
            and len(set(zip(names, *parts.values(), differing[key], strict=True))) > before
        ):
            parts[key] = differing[key]
    return list((parts or {"rolling.load_n": _texts("rolling.load_n", runs)}).values())


def _is_minor(key: str) -> bool:
    return key in WORDS and WORDS[key].minor


def _labelled(key: str, runs: Sequence[Labelled]) -> list[str] | None:
    """Write the labels of a swept key, or return None where its values speak for themselves."""
    values = [run.values.get(key) for run in runs]
    named_by_label = [
        isinstance(value, str) and (key not in WORDS or _value(run.scene, key) != value)
        for run, value in zip(runs, values, strict=True)
    ]
    if key == "surface.path" or not any(named_by_label):
        return None
    return [
        worded(key, value) if value is not None else _texts(key, runs)[k]
        for k, value in enumerate(values)
    ]


def _texts(key: str, runs: Sequence[Labelled]) -> list[str]:
    """Write the value of a key for each run, as short as different values stay different."""
    word, values = WORDS[key], [_value(run.scene, key) for run in runs]
    there = {value for value in values if value is not None}
    by_word = ({value: write(word, value) for value in there} for write in (_short, _full))
    ways = _paths(there) if key == "surface.path" else [*by_word]
    written = next((way for way in ways if len(set(way.values())) == len(there)), ways[-1])
    return [
        _absent(run.scene, key) if value is None else written[value]
        for run, value in zip(runs, values, strict=True)
    ]


def _absent(scene: Scene, key: str) -> str:
    """Return the words for an omitted key, or nothing if the kind of surface has no such key."""
    section, _, last = key.partition(".")
    return WORDS[key].absent if hasattr(getattr(scene, section), last) else ""


def _value(scene: Scene, key: str) -> Hashable:
    """Read the value of a dotted key, or return None if it has none.

    A height file is compared by its place on the disk.
    """
    if key == "surface.path":
        return scene.height_path and scene.height_path.resolve()
    section, _, last = key.partition(".")
    value: Hashable = getattr(getattr(scene, section), last, None)
    return value


def _short(word: Word, value: Any) -> str:
    if isinstance(value, bool):
        return f"{'with' if value else 'without'} {word.name}"
    if isinstance(value, str):
        return f"{word.name} {printable(value.replace('_', ' '))}"
    if isinstance(value, tuple):  # a speed that changes
        speeds = [speed for _, speed in value]
        return f"{word.name} {min(speeds):g} to {max(speeds):g} {word.unit}"
    return f"{word.name} {value:g} {word.unit}".rstrip()


def _full(word: Word, value: Any) -> str:
    """Write a value with all its digits, or a speed with all its points."""
    if isinstance(value, tuple):
        points = ", ".join(f"{speed!r} {word.unit} at {time!r} s" for time, speed in value)
        return f"{word.name} {points}"
    return f"{word.name} {value} {word.unit}".rstrip()


def _paths(files: set[Hashable]) -> list[dict[Hashable, str]]:
    """Name files by their names, then with more and more of their parent folders."""
    paths = [path for path in files if isinstance(path, Path)]
    deepest = max((len(path.parts) for path in paths), default=1)
    word = WORDS["surface.path"].name
    return [
        {path: f"{word} {printable('/'.join(path.parts[-k:]))}" for path in paths}
        for k in range(1, deepest + 1)
    ]


def _folder_names(runs: Sequence[Labelled]) -> list[str]:
    """Name the run folders; the runs of a sweep share the folder of the sweep."""
    homes = [run.folder.parent if run.values else run.folder for run in runs]
    return [printable(home.resolve().name) for home in homes]


def _joined(
    names: Sequence[str], folders: Sequence[str], parts: Sequence[Sequence[str]]
) -> list[str]:
    """Join the parts of each label.

    Names of scenes and folders are added where they distinguish labels.
    """
    several = len(set(names)) > 1
    texts = [
        ", ".join(filter(None, [name if several else "", *(part[k] for part in parts)]))
        for k, name in enumerate(names)
    ]
    places: dict[str, set[str]] = {}
    for text, folder in zip(texts, folders, strict=True):
        places.setdefault(text, set()).add(folder)
    return [
        f"{text} ({folder})" if len(places[text]) > 1 else text
        for text, folder in zip(texts, folders, strict=True)
    ]


# ---- texts that stay different


def _escaped(letter: str) -> str:
    if 0xDC80 <= ord(letter) <= 0xDCFF:  # Python's surrogate for a byte that is not UTF-8
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return letter.encode("unicode_escape").decode("ascii")


def _windows(texts: Sequence[str], longest: int) -> dict[str, str]:
    """Cut long texts to the stretch in which they first differ."""
    begin = next(
        k for k in range(max(map(len, texts))) if len({text[k : k + 1] for text in texts}) > 1
    )
    room = longest - 2 * len(_CUT)
    start = max(0, begin - room // 2)
    cut = {
        text: _CUT * (start > 0) + text[start : start + room] + _CUT * (start + room < len(text))
        for text in texts
    }
    alike: dict[str, list[str]] = {}
    for text in texts:
        alike.setdefault(cut[text], []).append(text)
    for group in alike.values():
        if len(group) > 1:
            cut |= _windows(group, longest)
    return cut


def _numbered(texts: Sequence[str]) -> list[str]:
    """Append a number to texts that are equal."""
    count = Counter(texts)
    taken, numbers = {text for text in texts if count[text] == 1}, Counter[str]()
    result = []
    for text in texts:
        label = text
        while count[text] > 1 and (label == text or label in taken):
            numbers[text] += 1
            ending = f" ({numbers[text]})"
            label = text[: LONGEST - len(ending)] + ending
        taken.add(label)
        result.append(label)
    return result
