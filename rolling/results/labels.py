"""The words of a scene's keys, and the labels that distinguish runs on terminal, page and files."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from acoustics.texts import printable
from rolling.kinds.run_folder import RunFolder
from rolling.scene.library import NAMES
from rolling.scene.messages import table
from rolling.scene.models import Section
from rolling.scene.sections import WEIGHT
from rolling.scene.swept import SweptScene

BY_WEIGHT = "under its own weight"
LONGEST = 72  # characters of a label: the width of a row in a legend
_PROMINENT = 3  # differences that a label names even where fewer would distinguish the runs
SEED = "surface.seed"
_PATH = "surface.path"


class Word(NamedTuple):
    """The words for a key of a scene, which words.toml explains."""

    word: str
    unit: str = ""
    absent: str = ""
    minor: bool = False


WORDS = {key: Word(**words) for key, words in table("rolling.results", "words").items()}


def named(key: str) -> tuple[str, str]:
    """Return word and unit of a dotted key: rolling.load_n is load in N."""
    word = WORDS.get(key, Word(key))  # a section has its own name
    return word.word, word.unit


def worded(key: str, value: float | str) -> str:
    """Write a value with its word and unit, or with its label: load 5 N, surface lapped."""
    if value == WEIGHT:
        return BY_WEIGHT
    name, unit = named(key)
    return f"{name} {printable(value) if isinstance(value, str) else f'{value:g} {unit}'}".strip()


def labels(runs: Sequence[RunFolder]) -> list[str]:
    """Name runs by their differences in labels that differ and have at most `LONGEST` characters.

    The scene's name comes first where names differ; swept values and other differences follow, as
    many as distinguish the runs. The names of the folders, and at last a number, distinguish runs
    of equal scenes. A single run is named by its swept values, or by its load.
    """
    names = [run.scene.name for run in runs]
    texts = [", ".join(filter(None, row)) for row in zip(*_parts(runs), strict=True)]
    if len(set(names)) > 1:
        texts = [f"{name}, {text}" for name, text in zip(names, texts, strict=True)]
    homes = [run.home.resolve().name for run in runs]
    shared = Counter(text for text, _ in {*zip(texts, homes, strict=True)})
    for k, (text, home) in enumerate(zip(texts, homes, strict=True)):
        texts[k] = f"{text} ({printable(home)})" if shared[text] > 1 else text
    return _numbered([_cut(text, LONGEST) for text in texts])


def title(name: str, label: str) -> str:
    """Put the scene's name before a label, unless the label begins with it or is empty."""
    if not label:
        return name
    return label if label.partition(", ")[0] == name else f"{name}, {label}"


def _parts(runs: Sequence[RunFolder]) -> list[list[str]]:
    """Choose the keys that labels name, and return a text of each of them for each run."""
    swept = list(dict.fromkeys(key for run in runs for key in run.values))
    sections = tuple(f"{key}." for key in swept if key not in WORDS)  # swept under labels
    keys = [*swept, *(key for key in WORDS if not key.startswith(sections))]
    texts = {key: _texts(key, runs) for key in dict.fromkeys(keys)}
    for section, names_of_section in NAMES.items():  # different names stand for their values
        for name in names_of_section:
            if len(set(texts.get(f"{section}.{name.key}", ()))) > 1:
                given = {f"{section}.{key}" for key in name.gives}.difference(swept)
                texts = {key: words for key, words in texts.items() if key not in given}
    if len(set(texts.get("plate.damping", ()))) > 1 and "plate.loss_factor" not in swept:
        texts.pop("plate.loss_factor", None)  # which follows from the damping
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


def _texts(key: str, runs: Sequence[RunFolder]) -> list[str]:
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
            texts.append(f"{word.word} {printable(label)}")
        elif value is not None:
            texts.append(written[value])
        else:  # a key that the kind of surface lacks has no words
            texts.append(word.absent if hasattr(value_at(run.scene, section), last) else "")
    return texts


def _value(scene: SweptScene, key: str) -> Any:
    """Read the value of a dotted key, or None; a height file is its place on the disk."""
    if key == _PATH:
        path = scene.height_paths.get("surface")
        return path and path.resolve()
    value = value_at(scene, key)
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {_plain(part)}" for name, part in value.items())
    if isinstance(value, list):
        return f"({len(value)})"
    return None if isinstance(value, Section) else value


def _plain(part: Any) -> str:
    """Write a part of a value: a number, or a name such as that of the edges of a plate."""
    return f"{part:g}" if isinstance(part, int | float) else str(part)


def value_at(scene: SweptScene, key: str) -> Any:
    """Read the value of a dotted key, None where a section lacks it."""
    value: Any = scene
    for name in key.split("."):
        value = getattr(value, name, None)
    return value


def _written(word: Word, value: Any, detail: int) -> str:
    """Write a value with its word and unit; more detail shows all digits, or more folders."""
    if isinstance(value, bool):
        return f"{'with' if value else 'without'} {word.word}"
    if isinstance(value, Path):
        return f"{word.word} {printable('/'.join(value.parts[-detail:]))}"
    if value == WEIGHT:
        return BY_WEIGHT
    if isinstance(value, str):
        return f"{word.word} {printable(value.replace('_', ' '))}"
    if isinstance(value, tuple) and word.unit == "mm":  # a point, or listeners
        points = value if isinstance(value[0], tuple) else (value,)
        texts = (", ".join(f"{x:.{detail + 3}g}" for x in point) for point in points)
        return f"{word.word} {'; '.join(texts)} {word.unit}"
    if isinstance(value, tuple) and detail == 1:  # a speed or a loss factor that changes
        changing = [number for _, number in value]
        return f"{word.word} {min(changing):g} to {max(changing):g} {word.unit}".rstrip()
    if isinstance(value, tuple):
        unit = f" {word.unit}" if word.unit else ""
        over = "s" if word.unit == "m/s" else "Hz"
        pairs = (f"{number!r}{unit} at {place!r} {over}" for place, number in value)
        return f"{word.word} {', '.join(pairs)}"
    return f"{word.word} {f'{value:g}' if detail == 1 else value} {word.unit}".rstrip()


def _cut(text: str, longest: int) -> str:
    """Cut a long text in its middle."""
    head = longest // 2
    return text if len(text) <= longest else f"{text[:head]}…{text[head + 1 - longest :]}"


def _numbered(texts: Sequence[str]) -> list[str]:
    """Append a number to texts that are equal."""
    count = Counter(texts)
    numbers = Counter[str]()
    numbered = dict[str, None]()
    for text in texts:
        label = text
        while count[text] > 1 and (label in count or label in numbered):
            numbers[text] += 1
            ending = f" ({numbers[text]})"
            label = text[: LONGEST - len(ending)] + ending
        numbered[label] = None
    return list(numbered)
