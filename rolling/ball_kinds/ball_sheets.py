"""Sheets of a ball on a plate: the declaration of its level, and the roughness it rolled over."""

from __future__ import annotations

from acoustics.numbers import rounded
from rolling import __version__
from rolling.in_si.scene_surface import scene_surface
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.sheet import Sheet, SheetRow, SheetTable
from rolling.report import assumed
from rolling.results import noise_sheet, verdict
from rolling.results.notes import UNVALIDATED
from rolling.results.roughness_sheet import MADE_HEIGHTS, roughness_sheet
from rolling.results.run_lines import surface_parts
from rolling.results.run_quantities import as_heard
from rolling.results.run_result import Run

NOISE = "noise"


def noise_sheet_of(run: Run) -> Sheet:
    """Return the declaration of the level of a run, from its stored numbers."""
    numbers = run.numbers
    level = numbers.vibration
    parts = noise_sheet.parts_table(level)
    beside = _beside(numbers)
    tables = [noise_sheet.declared_table(level)]
    if parts is not None and not noise_sheet.why_not_declared(level):
        tables.append(parts)
    if beside:
        title = "Beside the declared value, without K"
        tables.append(SheetTable(title=title, heads=("value",), rows=tuple(beside)))
    return Sheet(
        name=NOISE,
        title=noise_sheet.TITLE,
        subject=numbers.sentence or run.scene.name,
        notice=noise_sheet.NOTICE,
        tables=tuple(tables),
        facts=tuple(_noise_facts(run)),
        departures=(*noise_sheet.departures(level, has_peak=bool(beside)), UNVALIDATED),
    )


def _beside(numbers: RunNumbers) -> list[SheetRow]:
    """Return the rows of the levels beside that which is declared, as far as a run has them."""
    levels = as_heard(numbers).levels
    rows = []
    if levels.vibration is not None:
        of_vibration = levels.vibration
        rows += [
            noise_sheet.beside_row("LpZ", "level without weighting, LZeq", of_vibration.level_db),
            noise_sheet.beside_row("LpAF,max", "maximum, A, fast", of_vibration.laf_max_db),
            noise_sheet.beside_row("LpZ,peak", "peak, without weighting", of_vibration.lz_peak_db),
        ]
    powers = (
        ("plate", levels.plate_power_level_db),
        ("sphere", levels.ball_power_level_db),
    )
    for body, power_db in powers:
        meaning = f"sound power of the {body} to one side, without weighting"
        rows.append(noise_sheet.beside_row(f"LW,{body}", meaning, power_db, "dB re 1 pW"))
    return [row for row in rows if row.cells[0].value is not None]


def _noise_facts(run: Run) -> list[tuple[str, str]]:
    """Return what the level rests on."""
    numbers = run.numbers
    level = numbers.vibration
    by_key = {doubt.key: doubt.text for doubt in verdict.listed(numbers)}
    distance_m = run.scene.sound.distance_m
    if run.scene.plate.edges_mm is not None:
        distance_m = run.scene.listener_distance_m
    facts = [
        ("Quantity", f"{level.measure} of the vibration of plate and ball. {level.meaning}"),
        ("Position", by_key.get("on_axis", by_key.get("at_listener", level.where))),
        ("Distance", f"{rounded(distance_m, 3)} m from the contact"),
        ("Mounting", by_key.get("plate_edges", by_key.get("infinite_plate", _mounting(run)))),
        ("Operating conditions", numbers.sentence),
        ("Record", _record(numbers)),
        ("Method", f"rolling-contact-noise {__version__}: {_method(numbers)}"),
        ("Verdict", "" if level.judged is None else level.judged.sentence),
        ("Deviation behind K", noise_sheet.DEVIATION),
    ]
    facts += [(f"Assumed: {name}", words) for name, words in assumed.of_machine(run).items()]
    return [(name, words) for name, words in facts if words]


def _mounting(run: Run) -> str:
    """Say which bodies a level without dynamics is estimated for."""
    estimate = run.numbers.estimate
    bodies = "ball and plate" if estimate is None else estimate.bodies
    return f"No support is part of the scene; the estimate is for {bodies}."


def _record(numbers: RunNumbers) -> str:
    """Say how long the record is, and how much of it was solved."""
    record = numbers.vibration.record
    if record is None:
        return ""
    words = f"{rounded(record.heard_s, 3)} s, of which {rounded(record.solved_s, 3)} s were solved"
    return f"{words}; it repeats" if record.repeats else words


def _method(numbers: RunNumbers) -> str:
    """Say what was simulated."""
    how = "the motion of ball and plate over it was computed in time"
    if numbers.vibration.how == "estimated":
        how = "the motion of ball and plate over it was estimated by a linear chain"
    return (
        f"the rough contact was solved at {numbers.record.steps:,} positions, {how}, and their"
        " sound was computed in a free field. All of it is simulated; nothing was measured."
    )


def roughness_sheet_of(run: Run) -> Sheet:
    """Return the roughness report of the surface over which a run rolled; nothing is marched."""
    surface = scene_surface(run.scene)
    return roughness_sheet(
        f"{assumed.surface_words(run.scene)}{surface_parts(run.numbers)}",
        surface.heights,
        (surface.spacing, surface.spacing),
        is_periodic=True,
        facts=_surface_facts(run),
        departures=[MADE_HEIGHTS],
    )


def _surface_facts(run: Run) -> list[tuple[str, str]]:
    """Return where the heights of a run are from, and what was removed from them."""
    surface = run.numbers.surface
    facts = [("Heights", assumed.surface_words(run.scene))]
    if surface.ball_ra_m is not None:
        facts.append(("Bodies", "plate and ball together, as they meet in pure rolling"))
    if surface.levelling is not None:
        facts.append(("Form and plane", surface.levelling.text))
    facts += [(f"Step: {step.step}", step.text) for step in surface.preparation or ()]
    if not surface.preparation and surface.levelling is None:
        facts.append(("Removed", "the mean alone; the heights are made without form"))
    if surface.instrument is not None:
        cutoff = rounded(1e6 * surface.instrument.cutoff_m, 3)
        words = f"waves shorter than {cutoff} µm are not known, by {surface.instrument.limit}"
        facts.append(("Instrument", words))
    return facts
