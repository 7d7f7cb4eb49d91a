"""Definitions of the arrays that a march leaves, in the archive of a piece and in result.h5."""

from __future__ import annotations

from rolling.archive.definition import TEXT, Variable, by_name
from rolling.marches.effort import ARRAY

# Of a piece that failed, in place of its arrays. Pieces of version 0.8 have this name.
FAILURE = Variable("fault", "", "1", TEXT, "reason why a contact has no solution")
# Entry i of a step series belongs to the step from position i to the next.
STEPS = (
    Variable("release_energy", "step", "J", "f8", "elastic energy released in each step"),
    Variable("loading_energy", "step", "J", "f8", "elastic energy loaded in each step"),
    Variable("energy_defect", "step", "J", "f8", "defect of the energy balance of each step"),
)
STEP_TIME = Variable("step_time", "step", "s", "f8", "processor time of each step")
STATES = (
    Variable("approach", "position", "m", "f8", "approach of sphere and plate"),
    Variable("contact_area", "position", "m2", "f8", "area in contact"),
    Variable("plastic_area", "position", "m2", "f8", "area at the hardness"),
    Variable("max_pressure", "position", "Pa", "f8", "maximum contact pressure"),
    Variable("max_deflection", "position", "m", "f8", "maximum deflection"),
    Variable("stored_energy", "position", "J", "f8", "stored elastic energy"),
    Variable("residual", "position", "1", "f8", "KKT residual of the solver"),
    Variable("iterations", "position", "1", "u4", "iterations of the solver"),
    Variable("convolutions", "position", "1", "u4", "transforms or direct sums of the solver"),
)
SNAPSHOT = (
    Variable("pressure", "along across", "Pa", "f8", "contact pressure"),
    Variable("deflection", "along across", "m", "f8", "deflection"),
)
MAPS = (
    Variable("position", "map", "1", "u4", "number of the position of each map"),
    Variable("distance", "map", "m", "f8", "distance along the track"),
    Variable("along", "map", "m", "f8", "plate coordinate of the first cell's corner, along"),
    Variable("across", "map", "m", "f8", "plate coordinate of the first cell's corner, across"),
    Variable("cell", "map", "m", "f8", "side of a square cell"),
    Variable("rows", "map", "1", "u4", "rows of each map"),
    Variable("columns", "map", "1", "u4", "columns of each map"),
    Variable("pressure", "map row column", "Pa", "f4", "mean pressure of cells, NaN outside a map"),
)
EVENTS = (
    Variable("node", "event axis", "1", "i4", "node of the plate, along and across"),
    Variable("first", "event", "position", "u4", "position from which the deflection falls"),
    Variable("last", "event", "position", "u4", "position up to which the deflection falls"),
    Variable("energy", "event", "J", "f8", "energy released by the event"),
    Variable("peak", "event", "J per step", "f8", "maximum energy released in a step"),
)
FILM = (
    Variable(
        "pressure",
        "map_position along across",
        "Pa",
        "u1",
        "mean pressure of cells",
        scale_factor="pressure_unit",
    ),
    Variable(
        "release",
        "map_position along across",
        "J",
        "u2",
        "energy released since last map",
        scale_factor="release_unit",
    ),
)

MOVING_SERIES = tuple(by_name(*STEPS))  # of a march under the moving load
STEP_SERIES = (*MOVING_SERIES, STEP_TIME.name)
STATE_SERIES = tuple(by_name(*STATES))
EVENT_COLUMNS = tuple(by_name(*EVENTS))
# Names of the series that a kind of piece returns; the track and its passes return all of them.
SERIES_OF_KIND = {
    "load": ("approach",),
    "judge": ("approach",),
    "moving": (*MOVING_SERIES, "approach"),
    "error": ("release_energy", "approach", "plastic_area"),
}

# Groups of the archive of a piece, as of result.h5.
SNAPSHOT_GROUP = "snapshot"
MAPS_GROUP = "pressure_maps"
EVENTS_GROUP = "events"
FILM_GROUP = "slow_motion"

EFFORT = Variable(ARRAY, "part", "s", "f8", "processor times of surface, march and compilation")
