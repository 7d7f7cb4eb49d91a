"""Table of the names that numbers had in version 0.8, with the names that they have now."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from number_tables import columns_of, table

from rolling.numbers.ball_numbers import RunNumbers
from rolling.results import former_numbers

HEAD = ("summary.json of 0.8", "Python", "column of runs.csv and of `table()`")
PLAYED = "played"  # levels of the record that is measured, which are those of a source
SOURCES = ("levels.vibration", "levels.released_power")


class Renamed(NamedTuple):
    """A former name with the place of the same number in the numbers of a run.

    `rest` is what follows the place in Python, such as `.uncertainty` of a quantity.
    """

    former: str
    path: str
    rest: str = ""


# Names of 0.8 of what is no single number, or was made of several.
OTHERS = (
    Renamed("answer", "vibration"),
    Renamed("answer", "released_power"),
    Renamed("verdict", "leading", ".verdict"),
    Renamed("vibration_laeq_db", "vibration", ".value"),
    Renamed("vibration_laeq_db", "levels.vibration.laeq_db"),
    Renamed("vibration_level_db", "levels.vibration.level_db"),
    Renamed("vibration_estimate_uncertainty_db", "vibration", ".uncertainty"),
    Renamed("laeq_uncertainty_db", "leading", ".uncertainty"),
    Renamed("laeq_uncertainty_parts_db", "leading", ".parts"),
    Renamed("contact_loss_db", "contact_loss_db"),
    Renamed("listeners", "levels.listeners"),
    Renamed("third_octave_db", "bands.vibration"),
    Renamed("third_octave_db", "bands.released_power"),
    Renamed("third_octave_a_db", "bands.vibration_a"),
    Renamed("third_octave_a_db", "bands.released_power_a"),
    Renamed("third_octave_uncertainty_db", "bands.vibration", ".uncertainty"),
    Renamed("third_octave_uncertainty_db", "bands.released_power", ".uncertainty"),
    Renamed("vibration_third_octave_db", "bands.vibration"),
    Renamed("release_third_octave_db", "bands.released_power_at_listener"),
    Renamed("plate_power_third_octave_db", "bands.plate_power"),
    Renamed("ball_power_third_octave_db", "bands.ball_power"),
    Renamed("force_third_octave_n", "bands.force"),
    Renamed("grid_error_db", "bands.grid_error"),
    Renamed("grid_error_uncertainty_db", "bands.grid_error", ".uncertainty"),
    Renamed("solver_error_db", "bands.solver_error"),
    Renamed("subgrid_error_db", "bands.subgrid_error"),
    Renamed("subgrid_error_uncertainty_db", "bands.subgrid_error", ".uncertainty"),
    Renamed("levelling", "surface.levelling"),
    Renamed("preparation", "surface.preparation"),
    Renamed("surface_made", "surface.made"),
    Renamed("ball_surface_made", "surface.ball_made"),
    Renamed("wavelength_octaves", "surface.wavelength_octaves"),
    Renamed("instrument", "surface.instrument"),
    Renamed("channels", "channels"),
    Renamed("passes", "passes"),
    Renamed("listening", "listening"),
    Renamed("doubts", "doubts"),
)


def renamed() -> Iterator[Renamed]:
    """Yield each former name with its present place."""
    tables = former_numbers
    for subject, names in tables._SAME.items():
        yield from _of(subject, names)
    yield from _of(PLAYED, tables._OF_SOUND)
    yield from _of(f"{PLAYED}.spreads", tables._SPREADS, "uncertainty_db: ")
    yield from _of("levels", {**tables._BESIDE_VIBRATION, **tables._MEANS})
    yield from _of("errors", tables._ERRORS)
    yield from _of("errors", tables._FACTS, "error_estimate: ")
    yield from _of("energy", tables._MOVING)
    for names in (tables._MOTION, tables._FALL, tables._PLATE_MODES, tables._FORCE_LAW):
        yield from _of("motion", names)
    yield from _of("estimate", tables._ESTIMATE)
    yield from _of("ears", {name: name for name in tables._EARS})
    yield from _of("turns", tables._TURNS)
    yield from _of("surface", tables._PARTS_OF_SURFACE)
    yield from _of("surface", tables._STATISTICS, "surface: ")
    yield from _of("passes[i]", tables._PASSES, "passes: ")
    yield from OTHERS


def _of(subject: str, names: Mapping[str, str], before: str = "") -> Iterator[Renamed]:
    """Yield the former names of the fields of a subject."""
    for name, former in names.items():
        yield Renamed(before + former, f"{subject}.{name}")


def reference() -> str:
    """Return the table of former and present names."""
    columns = columns_of(RunNumbers)
    rows = []
    for one in renamed():
        found = [] if one.rest else [name for name in _columns(one.path) if name in columns]
        cells = "<br>".join(f"`{name}`" for name in found) or "-"
        rows.append([f"`{one.former}`", f"`run.numbers.{one.path}{one.rest}`", cells])
    return table(HEAD, rows)


def _columns(path: str) -> list[str]:
    """Return the columns that a place would have."""
    subject, _, rest = path.partition(".")
    places = [path] if subject != PLAYED else [f"{source}.{rest}" for source in SOURCES]
    return [place.replace(".", "_") for place in places]
