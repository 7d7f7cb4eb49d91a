"""The command `rolling surface`: parameters and picture of the heights of a scene or a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.check import refusals
from rolling.commands.replaced import SOURCE, refuse_others, source_name
from rolling.in_si import measured, offered_lines
from rolling.in_si.described_file import (
    ChainStep,
    FileOptions,
    described_file,
    offer_of_file,
    scene_chain,
)
from rolling.in_si.plate_file import ScaleLimited, scale_limited_file
from rolling.in_si.scene_surface import scene_surface
from rolling.results.roughness_sheet import MADE_HEIGHTS
from rolling.scene import height_files
from rolling.scene.file import read_as
from rolling.scene.height_files import is_array
from rolling.scene.height_format import HeightFormatError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface import character
from rolling.surface.step_words import filter_words, form_words
from rolling.terminal import progress, whole_files
from rolling.terminal.streams import wrapped
from rolling.terminal.whole_files import FolderError

# Bytes of memory for each node while parameters and picture are made; 87 were seen.
BYTES_OF_NODE = 90.0


def surface(
    source: Path,
    overrides: Sequence[str] = (),
    spacing_um: float | None = None,
    channel: str | None = None,
    unit: str | None = None,
    xy_unit: str | None = None,
    *,
    along: str | None = None,
    instrument: Mapping[str, float | None] | None = None,
    l_filter_um: float | None = None,
    save: Path | None = None,
    out: Path | None = None,
    declare: bool = False,
) -> list[Path]:
    """Print the parameters of a surface by ISO 25178-2, and write them with a picture.

    Parameters
    ----------
    source : Path. A scene, whose surface is described, or a file of measured heights.
    overrides : sequence of str. Assignments such as "surface.level=plane", to a scene.
    spacing_um, channel, unit, xy_unit, along : as in the section `surface` of a scene, of a file.
    instrument : mapping. The section `surface.instrument` of a file: tip_radius_um, sampling_um,
        noise_nm; None where one is not stated. Default: nothing is stated.
    l_filter_um : float, um. Nesting index of the L-filter of a file. Default: no such filter.
    save : Path. File for the heights, in the format of its ending. Default: none.
    out : Path. Folder of picture and table. Default: outputs/NAME-surface.
    declare : bool. Whether the roughness report is written, too. Default: false.

    Raises
    ------
    SceneError, FolderError : bad input; nothing is written.
    """
    _refuse_taken(save, out)
    options = FileOptions(
        spacing_um=spacing_um,
        channel=channel,
        height_unit=unit,
        xy_unit=xy_unit,
        along=along,
        l_filter_um=l_filter_um,
        **(instrument or {}),
    )
    is_scene = source.suffix.lower() in ("", ".yaml", ".yml")
    if is_scene:
        if options != FileOptions():
            raise FolderError(
                "--spacing-um, --channel, --height-unit, --xy-unit, --along, --tip-radius-um,"
                " --sampling-um, --noise-nm, --l-filter-um: only for a file of heights"
            )
        described = _surface_of_scene(source, overrides)
    else:
        if overrides:
            raise FolderError("--set: only goes with a scene")
        described = _surface_of_file(source, options)
    folder = out or Path("outputs") / f"{described.name}-surface"
    with progress.step("computing the parameters, drawing the picture"):
        named = source_name(source, folder)
        lines, contents = _parameters_and_picture(described, named)
        if declare:
            contents |= _roughness_report(described, named)
    for name, content in contents.items():
        refuse_others(folder / name, content)
    if save is not None:
        _save_heights(save, described)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        whole_files.write_bytes(folder / name, content)
    if progress.is_quiet():
        return [folder]
    nodes = " x ".join(str(count) for count in described.heights.shape)
    sides = " x ".join(str(step) for step in np.round(1e6 * described.steps, 6))
    print(f"{printable(described.name)}: {nodes} nodes of {sides} um, {described.words}\n")
    _print_chain(described.chain)
    _print_character(described)
    print("\n".join(["\nAll parameters of ISO 25178-2:", *lines]))
    print(f"\nall files: {printable(str(folder))}")
    return []


def _print_chain(chain: Sequence[ChainStep]) -> None:
    """Print the steps of the preparation, each with its effect and its reason."""
    for step in chain:
        words = "; ".join(word for word in (step.effect, step.reason) if word)
        print(wrapped(printable(f"{step.name}: {words}"), "  "))
    if chain:
        print()


def _print_character(described: _DescribedSurface) -> None:
    """Print the numbers by which finishes are compared, and lines of a scene with the surface."""
    numbers = character.character(described.heights, described.steps, described.is_periodic)
    for sentence in character.sentences(numbers, described.pair):
        print(wrapped(sentence, ""))
    if described.sight:
        print(wrapped(described.sight, ""))
    if described.of_file is not None:
        if character.lies_along(numbers) and described.may_be_turned:
            words = "The lay runs along the track. If the ball rolls across the lay, add --along x."
            print(wrapped(words, ""))
        _print_offer(described.of_file)
    is_profile = described.heights.shape[1] == 1
    width = 0.0 if is_profile else described.heights.shape[1] * described.steps[1]
    of_statistics = offered_lines.offer_of_statistics(numbers, min(described.steps), width)
    if of_statistics is not None:
        _print_offer(of_statistics)


def _print_offer(offer: offered_lines.Offer) -> None:
    """Print a line of a scene below its sentence, which may say why there is no line."""
    print(f"\n{wrapped(printable(offer.sentence), '')}")
    if offer.line:
        print(f"  {printable(offer.line)}")


class MeasuredMap(NamedTuple):
    """Heights [m] (along, across) as they were measured, and their spacings [m]."""

    heights: Array
    steps: Array


@dataclass(frozen=True)
class _DescribedSurface:
    """Surface that `rolling surface` describes.

    name : str. Name of the scene or the file.
    words : str. Words on its edges and nodes.
    heights : (along, across) array, m. NaN where they are not measured.
    steps : (2,) array, m. Spacing of the nodes along and across.
    is_periodic : bool. Whether the surface closes, as that of a scene does.
    pair : Pair. Ball and plate of the plasticity index.
    of_file : Offer or None. The line of a scene that rolls over the file; None for a scene.
    may_be_turned : bool. Whether the option `along` is left to choose.
    sight : str. What the instrument sees of a file; empty where there is nothing to say.
    chain : list of ChainStep. The preparation of a file, step by step.
    before : MeasuredMap or None. The heights of a file before their preparation.
    period : (along, across) array or None, m. What a run rolls over, where that is something else.
    facts : tuple of pairs of str. Where the heights are from, and what was removed, for a report.
    departures : tuple of str. What a measurement would have and the heights do not, in sentences.
    """

    name: str
    words: str
    heights: Array
    steps: Array
    is_periodic: bool
    pair: character.Pair
    of_file: offered_lines.Offer | None = None
    may_be_turned: bool = False
    sight: str = ""
    chain: Sequence[ChainStep] = ()
    before: MeasuredMap | None = None
    period: Array | None = None
    facts: tuple[tuple[str, str], ...] = ()
    departures: tuple[str, ...] = ()


def _refuse_taken(save: Path | None, out: Path | None) -> None:
    """Raise FolderError for a file of heights that exists, or a folder that is a file."""
    for path in (save, out):
        if path is not None and path.exists() and (path is save or not path.is_dir()):
            raise FolderError(f"{path}: exists; take another name, or remove it")
    if save is not None and not save.parent.is_dir():
        raise FolderError(f"--save {save}: no such folder")


def _refuse_many(count: int) -> None:
    """Raise FolderError for so many nodes that memory does not hold their parameters."""
    advice = {"surface": "take a part of the surface, or a larger spacing"}
    for need in refusals.lacking_memory({"surface": BYTES_OF_NODE * count}, advice):
        raise FolderError(need.line)


def _surface_of_scene(path: Path, overrides: Sequence[str]) -> _DescribedSurface:
    """Make the surface of a scene, and print the doubts about it."""
    scene = read_as(path, Scene, overrides)
    if any(key.startswith(("surface", "sphere.surface")) for key in scene.sweep):
        progress.line("the surface of the scene without its sweep; --set chooses other values")
    _refuse_many(scene.track.n_along * scene.track.n_across)
    surface = scene_surface(scene)
    for doubt in surface.suspicions:
        progress.line(f"warning: {doubt}")
    own = _measurement_of_scene(scene)
    if own is not None and isinstance(scene.surface, HeightFile):
        return _DescribedSurface(
            name=scene.name,
            words="prepared by the scene; the ball rolls over a period of it, whose ends are"
            f" joined, with an Ra of {rounded(1e6 * surface.statistics.ra, 3)} um",
            heights=own.heights,
            steps=np.array(own.steps),
            is_periodic=False,
            pair=offered_lines.pair_of_scene(scene),
            chain=scene_chain(own, scene.surface),
            period=surface.heights,
            facts=(("Heights", f"the file of the scene {printable(scene.name)}, prepared by it"),),
            departures=("What the instrument filtered before it wrote the file is not known.",),
        )
    return _DescribedSurface(
        name=scene.name,
        words="periodic",
        heights=surface.heights,
        steps=np.full(2, scene.spacing),
        is_periodic=True,
        pair=offered_lines.pair_of_scene(scene),
        facts=(
            ("Heights", f"those of the scene {printable(scene.name)}, as a run rolls over them"),
        ),
        departures=(MADE_HEIGHTS,),
    )


def _measurement_of_scene(scene: Scene) -> ScaleLimited | None:
    """Return the measured heights of a scene that the ball rolls over alone, else None."""
    path = scene.height_path
    plate = scene.surface
    if path is None or not isinstance(plate, HeightFile) or plate.made_periodic == "none":
        return None
    if plate.faults or scene.sphere.surface is not None:
        return None
    return scale_limited_file(path, plate)


def _surface_of_file(path: Path, options: FileOptions) -> _DescribedSurface:
    """Read and level a file of heights, and print the doubts about it."""
    if is_array(path):
        with suppress(HeightFormatError):  # which is told where the file is read
            along, across = height_files.nodes(path)
            _refuse_many(along * across)
    read = described_file(path, options)
    if read.taken:
        progress.line(printable(f"{path}: taken for {read.taken}"))
    for doubt in read.doubts:
        progress.line(printable(f"warning: {path}: {doubt}"))
    _refuse_many(read.heights.size)
    gaps = int(np.count_nonzero(np.isnan(read.measured_heights)))
    words = "prepared as below" if read.chain else "less its least-squares plane"
    if gaps:
        words += f", {gaps} unmeasured"
    return _DescribedSurface(
        name=path.name,
        words=words,
        heights=read.heights,
        steps=read.steps,
        is_periodic=False,
        pair=offered_lines.pair_of_steel(),
        of_file=offer_of_file(path, read.keys),
        may_be_turned=options.along is None and 1 not in read.heights.shape,
        chain=read.chain,
        before=MeasuredMap(read.measured_heights, read.measured_steps) if read.chain else None,
        sight=read.sight,
        facts=(
            ("Heights", f"the file {printable(path.name)} as it was measured"),
            ("Form", _form_words(read.keys)),
            ("Filters of the surface", _filter_words(read.keys)),
            ("Unmeasured nodes", f"{gaps:,}, {'filled' if read.chain else 'which do not count'}"),
        ),
        departures=("What the instrument filtered before it wrote the file is not known.",),
    )


def _form_words(keys: Mapping[str, Any]) -> str:
    """Name the form that is removed."""
    level = str(keys.get("level", "plane"))
    return "none is removed" if level == "none" else f"the {form_words(level)} is removed"


def _filter_words(keys: Mapping[str, Any]) -> str:
    """Name the filters with their nesting indices."""
    parts = []
    if "s_filter_um" in keys:
        parts.append(f"S-filter, {filter_words(1e-6 * keys['s_filter_um'])}")
    if "l_filter_um" in keys:
        is_robust = keys.get("l_filter") == "robust"
        parts.append(f"L-filter, {filter_words(1e-6 * keys['l_filter_um'], is_robust)}")
    return "; ".join(parts) or "none"


def _parameters_and_picture(
    described: _DescribedSurface, source: str
) -> tuple[list[str], dict[str, bytes]]:
    """Return the lines of the parameters of a surface, and its files by name.

    Both files name their source, so that the command knows its own when it is given again.
    """
    from rolling.figures.settings import left_out_if_it_fails
    from rolling.figures.topography import (
        before_and_after,
        parameter_lines,
        parameter_table,
        topography,
    )
    from rolling.results.runs_table import csv_bytes
    from rolling.surface.parameters import is_upper_bound, parameters

    heights = described.heights
    steps = described.steps
    values = parameters(heights, steps, described.is_periodic)
    is_bound = is_upper_bound(heights, steps, described.is_periodic)
    table = parameter_table(values, is_bound).assign(**{SOURCE.lower(): source})
    contents = {"surface.csv": csv_bytes(table)}
    with left_out_if_it_fails("surface.png"):
        drawn = topography(described.name, values, heights, steps, described.is_periodic, is_bound)
        facts = {"Software": "rolling-contact-noise", SOURCE: source}
        contents["surface.png"] = drawn.file("png", facts) or b""
    before = described.before
    if before is not None and 1 not in heights.shape:
        with left_out_if_it_fails("preparation.png"):
            maps = before_and_after(described.name, before.heights, before.steps, heights, steps)
            facts = {"Software": "rolling-contact-noise", SOURCE: source}
            contents["preparation.png"] = maps.file("png", facts) or b""
    return parameter_lines(values, is_bound), contents


def _roughness_report(described: _DescribedSurface, source: str) -> dict[str, bytes]:
    """Return the files of the roughness report of a surface by their names."""
    from rolling.commands.declare import DECLARATION, sheet_contents
    from rolling.results.roughness_sheet import roughness_sheet

    name = printable(described.name)
    sheet = roughness_sheet(
        f"Surface {name}, {described.words}.",
        described.heights,
        (float(described.steps[0]), float(described.steps[1])),
        described.is_periodic,
        facts=described.facts,
        departures=described.departures,
    )
    contents = sheet_contents(f"Roughness report: {name}", {name: [sheet]}, source)
    stem = Path(DECLARATION)
    names = [stem.name, stem.with_suffix(".csv").name, stem.with_suffix(".json").name]
    return dict(zip(names, contents, strict=True))


def _save_heights(path: Path, described: _DescribedSurface) -> None:
    """Write the heights of a surface in the format of the ending of a path."""
    along, across = described.steps
    heights = described.heights if described.period is None else described.period
    try:
        measured.write(path, heights, (along, across))
    except HeightFormatError as error:
        raise FolderError(error.of(f"--save {path}")) from error
