"""The library that comes with the program: scenes, materials and finishes by name.

The tables of materials and finishes are data, `materials.yaml` and `finishes.yaml` in this folder.
A section is filled in when it is read and stored with all values, so that a change of a table
changes no stored run.
"""

import difflib
import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field
from ruamel.yaml import YAML

from acoustics.numbers import rounded
from rolling.scene import bearing_names
from rolling.scene.messages import SceneError, mistake, nearest, quoted

# In an installed package the scenes stand inside of it, in a checkout beside it.
_PLACES = (Path(__file__).parents[1] / "scenarios", Path(__file__).parents[2] / "scenarios")
_SUFFIX = ".yaml"
_SCHEMA = re.compile(r"\$schema=([\w.]+)")  # of a scene, in the comment that it begins with


def folder() -> Path:
    """Return the folder of the library."""
    return next((place for place in _PLACES if place.is_dir()), _PLACES[0])


def scenes() -> dict[str, Path]:
    """Return the files of the library by name, such as `quickstart`."""
    root = folder()
    files = sorted(root.rglob(f"*{_SUFFIX}"))
    return {file.relative_to(root).with_suffix("").as_posix(): file for file in files}


def find(path: Path) -> Path:
    """Return the library's file if `path` is the name of its scene and no file; else `path`."""
    file = scenes().get(path.as_posix())
    return path if file is None or path.is_file() else file


def companions(file: Path) -> list[Path]:
    """Return the files of heights that a scene of the library has beside it, by its name."""
    return [path for path in sorted(file.parent.glob(f"{file.stem}.*")) if path != file]


def title(file: Path) -> str:
    """Return the title of a scene: the first sentence of the comment that it begins with."""
    lines = file.read_text(encoding="utf-8").splitlines()
    comment = itertools.takewhile(lambda line: line.startswith("#"), lines)
    text = " ".join(line.strip("# ") for line in comment if "$schema=" not in line)
    return re.split(r"(?<=[.?!])\s", text, maxsplit=1)[0]


def titles(inner: bool = False) -> list[tuple[str, str]]:
    """Return name and title of each scene; `inner` includes the scenes in folders, of studies."""
    return [(name, title(file)) for name, file in scenes().items() if inner or "/" not in name]


def copy(name: str, target: Path) -> list[Path]:
    """Copy a scene of the library into a folder, with its heights and the schema that it names.

    Return the files that were written, the scene first; other files that exist stay as they are.
    Raise SceneError where there is no such scene, or the file exists.
    """
    file = scenes().get(name.removesuffix(_SUFFIX))
    if file is None:
        words = f"no such scene in the library{_nearest(name)}; `rolling scenes` lists them"
        raise SceneError([f"{name}: {words}"])
    content = file.read_bytes()
    copied = target / file.name
    try:
        _write_new(copied, content)
    except FileExistsError as error:
        advice = "nothing is replaced; rename it or change to another folder"
        raise SceneError([f"{copied}: exists, and {advice}"]) from error
    written = [copied]
    others = companions(file)
    if schema := _SCHEMA.search(content.decode("utf-8")):
        others.append(folder() / schema[1])
    for other in others:
        with suppress(FileExistsError):
            _write_new(target / other.name, other.read_bytes())
            written.append(target / other.name)
    return written


def hint(path: Path) -> str:
    """Return the end of a message about a missing file that looks like the name of a scene here."""
    name = path.as_posix().removesuffix(_SUFFIX)
    if name in scenes():
        return f"; `rolling init {name}` copies the scene of that name into the current folder"
    like = _nearest(name)
    return f"{like}, a scene of the library" if like else ""


def _nearest(name: str) -> str:
    """Write ", nearest: NAME" with the scene whose name is like a misspelt one, or nothing."""
    return nearest(name.removesuffix(_SUFFIX), [*scenes()])


def _write_new(path: Path, content: bytes) -> None:
    """Write a file that does not exist, or raise FileExistsError; a failed write leaves nothing."""
    with path.open("xb") as file:
        try:
            file.write(content)
            file.flush()
        except OSError:
            path.unlink()
            raise


# ---- materials and finishes


HV_GPA = 9.80665e-3 / 0.927  # mean pressure under a Vickers indenter over the hardness number
HANDLED = "handled"  # damping of an object as one meets it, with hands, supports and joints
INTRINSIC = "intrinsic"  # damping of the material alone
NONE = "none"  # hardness of a plate that is purely elastic
_ELASTIC = ("youngs_modulus_gpa", "poissons_ratio", "density_kg_m3")
YIELDS = 3  # hardness over yield strength of metals, by Tabor's rule
_HARDNESS = {"hardness_hv": HV_GPA, "yield_strength_gpa": YIELDS}  # factors of keys of the data


class Name(NamedTuple):
    """Key of a section that takes a name, the table of names, and the keys that they give.

    A section without the key has the default, if there is one. `instead` says what to give for a
    thing that is not in the table. `part` is the part of an entry that has the values of a section;
    entries without it are no names of this section. `allowed` says in words which names there are,
    where these are too many for a list.
    """

    key: str
    table: str
    gives: tuple[str, ...]
    default: str = ""
    instead: str = ""
    part: str = ""
    allowed: str = ""

    @property
    def entries(self) -> dict[str, dict[str, Any]]:
        """Entries of the table by name, each value before its source."""
        whole = data(self.table)[self.table]
        if not self.part:
            return dict(whole)
        return {name: entry[self.part] for name, entry in whole.items() if self.part in entry}

    def entry(self, name: str) -> dict[str, Any] | None:
        """Return the entry of a name, None for an unknown one."""
        if self.table == BEARINGS:
            return bearing_entry(name)
        return self.entries.get(name)


BEARINGS = "bearings"
BEARING_KEYS = (
    "bore_mm",
    "outside_diameter_mm",
    "width_mm",
    "balls",
    "ball_diameter_mm",
    "pitch_diameter_mm",
    "radial_clearance_um",
    "conformity_inner",
    "conformity_outer",
)
RACEWAY_KEYS = (
    "wave_amplitude_um",
    "wave_exponent",
    "roughness_ra_um",
    "correlation_length_um",
    "correlation_length_across_um",
)
NAMES = {
    "plate": (Name("material", "materials", (*_ELASTIC, "hardness_gpa", "loss_factor")),),
    "sphere": (Name("material", "materials", _ELASTIC),),
    "surface": (Name("finish", "finishes", ("roughness_ra_um", "correlation_length_um")),),
    "raceway": (Name("finish", "finishes", RACEWAY_KEYS, part="raceway"),),
    "bearing": (
        Name(
            key="named",
            table=BEARINGS,
            gives=BEARING_KEYS,
            allowed=f"608, 6000 to 6010, 6200 to 6210, 6300 to 6310, with suffixes such as"
            f" {bearing_names.EXAMPLES}",
            instead="in place of a name give balls, ball_diameter_mm, pitch_diameter_mm and a"
            " contact angle or clearance",
        ),
        Name("material", "materials", _ELASTIC, default="steel-100cr6"),
    ),
}
# Sections within others, by their place in a scene.
_SECTIONS = {
    "bearing.surfaces.inner": "raceway",
    "bearing.surfaces.outer": "raceway",
}
NAME_KEYS = tuple(f"{section}.{name.key}" for section, names in NAMES.items() for name in names)
# Keys in whose presence a name does not give another key, which follows from them.
_REPLACED = {"yield_strength_gpa": "hardness_gpa", "contact_angle_deg": "radial_clearance_um"}


@cache
def data(table: str) -> dict[str, dict[str, Any]]:
    """Return a table: its `sources` by key, its entries by name, each value before its source."""
    text = files("rolling.scene").joinpath(f"{table}.yaml").read_text(encoding="utf-8")
    return dict(YAML(typ="safe", pure=True).load(text))


def named_values(section: str, name: str, damping: str = HANDLED) -> dict[str, Any]:
    """Return the values that a name gives to a section; none for an unknown name.

    `damping` chooses the loss factor: the larger of the material's own and that of objects of its
    class as they are handled, or its own (INTRINSIC).
    """
    for by_name in NAMES[section]:
        entry = by_name.entry(name)
        if entry is not None:
            return _values_of(entry, by_name, damping)
    return {}


def entry_of(section: str, name: str) -> dict[str, list[Any]]:
    """Return the values of an entry, each before its source, by the name of a section."""
    for by_name in NAMES[section]:
        entry = by_name.entry(name)
        if entry is not None:
            return {key: entry[key] for key in by_name.gives if key in entry}
    return {}


def _values_of(entry: Mapping[str, Any], by_name: Name, damping: str) -> dict[str, Any]:
    """Return the values that an entry of a table gives to a section."""
    values = {key: pair[0] for key, pair in entry.items() if isinstance(pair, list)}
    for key, factor in _HARDNESS.items():
        if key in values:
            values["hardness_gpa"] = float(rounded(factor * values[key], 3))
    values.setdefault("hardness_gpa", NONE)
    if "class" in entry and damping != INTRINSIC:
        handled = data(by_name.table)["handled"][entry["class"]][0]
        values["loss_factor"] = max(handled, values.get("loss_factor", 0.0))
    return {key: values[key] for key in by_name.gives if key in values}


def listed(table: str, part: str = "") -> Any:
    """Return a field whose JSON Schema lists the names of a table, read when it is made.

    With a part, names are the entries that have it.
    """
    names = Name(key="", table=table, gives=(), part=part)
    return Field(json_schema_extra=lambda schema: schema.update(enum=[*names.entries]))


def begins_with(table: str) -> Any:
    """Return a field whose JSON Schema allows the names of a table, with more behind them."""

    def update(schema: dict[str, Any]) -> None:
        names = [*data(table)[table]]
        schema["anyOf"] = [{"enum": names}, {"pattern": f"^({'|'.join(names)})[^0-9]"}]

    return Field(json_schema_extra=update)


# ---- sections with a name


def name_of(section: str, values: Any) -> str | None:
    """Return the first name in the plain values of a section, None without one."""
    return next((name for _, name in _names_in(section, values)), None)


def _names_in(section: str, values: Any) -> list[tuple[Name, str]]:
    """Return the names in the plain values of a section, with the default ones.

    A name of digits, such as 6204, may be a number.
    """
    if not isinstance(values, Mapping):
        return []
    names = []
    for by_name in NAMES[section]:
        name = values.get(by_name.key)
        if name is None and by_name.default:
            name = by_name.default
        if isinstance(name, str | int):
            names.append((by_name, str(name)))
    return names


def fill_in(section: str, values: Any) -> Any:
    """Fill in the values that the names in a section give; raise a mistake for an unknown name."""
    if not isinstance(values, Mapping):
        return values
    for by_name in NAMES[section]:
        given = values.get(by_name.key)
        if given is None:
            continue
        if not isinstance(given, str | int) or by_name.entry(str(given)) is None:
            words = _unknown_name(given, by_name)
            if by_name.instead:
                words += f"; {by_name.instead}"
            raise mistake(words, at=f"{section}.{by_name.key}")
    return with_named_values(section, values)


def _unknown_name(given: Any, by_name: Name) -> str:
    """Write that a table has no such name, its names, and the nearest of them."""
    known = by_name.entries
    words = f"got {quoted(given)}, allowed: {by_name.allowed or ', '.join(known)}"
    if by_name.table == BEARINGS:
        designation = bearing_names.parsed(str(given), known)
        if designation is None:
            near = bearing_names.nearest_basic(str(given), known)
        else:
            near = designation.basic
        if near:
            words += _not_understood(str(given), designation)
    else:
        # The material alone stands for the first of its kinds: "glass" for "glass-soda-lime".
        forms = {name.partition("-")[0]: name for name in reversed(known)}
        forms |= {name: name for name in known}
        close = difflib.get_close_matches(str(given).casefold().replace(" ", "-"), forms, 1)
        near = forms[close[0]] if close else ""
    if near:
        words += f"; nearest: {near}"
    return words


def _not_understood(given: str, designation: bearing_names.Designation | None) -> str:
    """Write which part of the name of a bearing is not understood; empty for another size."""
    if designation is None:
        prefix = bearing_names.prefix_of(given)
        return f"; the prefix {quoted(prefix)} is not understood" if prefix else ""
    if designation.strange:
        return f"; the suffix {quoted(designation.strange)} is not understood"
    groups = " and ".join(designation.groups)
    return f"; {groups} are two clearances, and a bearing has one"


def bearing_entry(name: str) -> dict[str, Any] | None:
    """Return the entry of a bearing by its name with suffixes, None for an unknown one.

    Its radial clearance is that of its bore and its clearance group.
    """
    table = data(BEARINGS)
    designation = bearing_names.parsed(name, table[BEARINGS])
    if designation is None or not designation.is_understood:
        return None
    entry = table[BEARINGS][designation.basic]
    bore_mm = entry["bore_mm"][0]
    clearance_um = bearing_names.clearance_um(bore_mm, designation.group, table["clearances"])
    return {**entry, "radial_clearance_um": [clearance_um, "iso-5753"]}


def with_named_values(section: str, values: Any) -> Any:
    """Return a section with the values that its names give; values that stand beside them win."""
    names = _names_in(section, values)
    if not names:
        return values
    given = {key: value for key, value in values.items() if value is not None}
    if section == "surface" and given.setdefault("kind", "gaussian") != "gaussian":
        return values
    named: dict[str, Any] = {}
    for by_name, name in names:
        entry = by_name.entry(name)
        if entry is not None:
            named |= _values_of(entry, by_name, given.get("damping", HANDLED))
    if "thickness_mm" not in given:
        named.pop("loss_factor", None)
    for key, replaced in _REPLACED.items():
        if key in given:
            named.pop(replaced, None)
    return named | given


def without_replaced_values(data: Mapping[str, Any], key: str, value: Any) -> Mapping[str, Any]:
    """Return plain values without the values that a change of one key replaces.

    They are the values that the old name gave, and those that the first name of a section gives.
    Another name or another damping replaces the loss factor of either damping.
    """
    path, _, last = key.rpartition(".")
    section = _SECTIONS.get(path, path)
    if section not in NAMES or not last:
        return data
    return _changed_at(data, path.split("."), lambda values: _kept(section, values, last, value))


def _changed_at(
    data: Mapping[str, Any], path: Sequence[str], change: Callable[[Any], Any]
) -> Mapping[str, Any]:
    """Return plain values with a change of those of a section, if the section is there."""
    first, *rest = path
    inner = data.get(first)
    if not isinstance(inner, Mapping):
        return data
    return {**data, first: _changed_at(inner, rest, change) if rest else change(inner)}


def _kept(section: str, values: Mapping[str, Any], last: str, value: Any) -> Mapping[str, Any]:
    """Return the values of a section that a change of its key `last` does not replace."""
    kept = dict(values)
    for by_name in NAMES[section]:
        old_name = values.get(by_name.key)
        is_renamed = last == by_name.key
        if is_renamed and value is None and not by_name.default:
            return values
        if isinstance(old_name, str | int):
            dampings = [values.get("damping", HANDLED)]
            if is_renamed or last == "damping":
                dampings = [HANDLED, INTRINSIC]
            for damping in dampings:
                kept = _without_equal(kept, named_values(section, str(old_name), damping))
        elif is_renamed:
            given = named_values(section, str(value))
            kept = {k: v for k, v in kept.items() if k not in given}
    return kept


def _without_equal(values: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return values without those that are equal to given ones."""
    return {key: v for key, v in values.items() if key not in given or v != given[key]}


def order_of_change(key: str) -> int:
    """Return the rank of a change: a name (0) is set before values that may stand beside it."""
    names = {key.rpartition(".")[2] for key in NAME_KEYS}
    return 0 if key.rpartition(".")[2] in names else 1
