"""Data of a run for the engine of the page: its force law or its release, and its numbers in SI.

All tracks close here: the end of an open track, or of a part, is cross-faded with its beginning.
"""

import base64
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.loss_factors import LossFactor, loss_factor_at
from acoustics.numbers import rounded
from acoustics.radiation import HalfSpaceBody
from acoustics.resampling import resample_closed
from acoustics.ritz_plate import RitzPlate
from acoustics.wav import PEAK, SAMPLE_RATE_HZ
from rolling.dynamics import _motion_kernels
from rolling.dynamics._motion_kernels import LawTable
from rolling.dynamics.bodies import half_space_mobility
from rolling.dynamics.force_law import ForceLaw, law_table, slope_weights
from rolling.in_si.physics_of_scene import bodies_of, plate_of, smooth_contact_of
from rolling.marches.result import released_energy
from rolling.report.live_modes import StoredModes, stored_modes
from rolling.results import labels
from rolling.results.run_result import Run
from rolling.scene.messages import SceneError
from rolling.scene.rules import MAX_MODES
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT
from rolling.scene.values_in_si import GRAVITY
from rolling.sound.vibration_sound import Vibration

LARGEST = 300_000  # bytes of a law or a release on the page, in base64
FAITHFUL = 1e-3  # error of the force that a stored law leaves, over its fluctuation
MIN_ROWS = 8  # of a track on which the engine can roll
SEAM = 20  # an open track is cross-faded over its length divided by this
RESOLVED = 1e-5  # share of the roughness in waves that time steps need not resolve
FASTEST_STEPS = 8  # time steps per sample that the highest speed takes
FALL_M_S = 1.0  # speed that a ball which is lifted may reach in its fall
Data = dict[str, Any]


class Slider(NamedTuple):
    """A setting of the page with the range of its slider in SI units, which a run may widen."""

    name: str
    least: float
    most: float
    unit: str


KINDS = {"numbers": "float32", "places": "int16", "values": "int16", "efficiencies": "int16"}
SLIDERS = (
    Slider("ballDensity", 900.0, 19_300.0, "kg/m³"),  # plastics to tungsten
    Slider("plateDensity", 900.0, 19_300.0, "kg/m³"),
    Slider("thickness", 5e-4, 0.05, "m"),  # foil to block
    Slider("lossFactor", 5e-4, 0.3, "-"),  # bells to damped layers
    Slider("contactLossFactor", 0.0, 0.2, "-"),
    Slider("distance", 0.1, 10.0, "m"),
    Slider("q", 1e-6, 1.0, "-"),
)
LEAST_EDGE = 1.5  # lowest length of an edge, over the distance from its corner to the contact
USUAL_RESISTANCE = 0.005  # assumed for balls under their own weight
CHANGED = 1.5  # value of a command that changes a number, over that of the run
# Keys of the solved contact, which the page cannot change, and their names there.
SOLVED_KEYS = {
    "sphere.radius_mm": "Radius",
    "sphere.youngs_modulus_gpa": "Stiffness of the ball",
    "plate.youngs_modulus_gpa": "Stiffness of the plate",
    "plate.hardness_gpa": "Hardness",
    "plate.yield_strength_gpa": "Yield strength",
    "surface.roughness_ra_um": "Roughness Ra",
    "surface.rq_um": "Roughness Sq",
    "surface.rdq": "Roughness Sdq",
}
MIDDLE_HZ = 1000.0  # at which a loss factor over the frequency is set
MOST_EDGE_M = 3.0  # highest length of an edge


def live_of(run: Run) -> Data | None:
    """Return the data of a run for the engine of the page, or None for a track of few steps."""
    scene = run.scene
    if run.result.solved_steps < MIN_ROWS:
        return None
    vibration = run.vibration_sound if run.sound.source == "vibration" else None
    ends = list[list[float]]()
    plate = plate_of(scene.plate).with_edges if vibration is not None else None
    modes = None
    if isinstance(plate, RitzPlate):
        modes = stored_modes(plate)
        if modes is None:
            return None
    if vibration is not None:  # a release is heard at a distance, whatever the edges
        ends = [[1e-3 * x for x in end] for end in scene.plate.contact_ends_mm.values()]
    settings = _settings(run)
    peak = float(np.abs(run.sound.channels).max())
    data: Data = {
        "label": run.label,
        "settings": settings,
        "limits": _limits(scene, settings, vibration is not None, ends),
        "fixed": _fixed(scene),
        "contact": ends[0] if ends else None,
        "ends": [[1e-3 * x for x in end] for end in scene.plate.contact_ends_mm.values()],
        "needs": [need._asdict() for need in needs_of_a_new_run(run)],
        "middle": [*np.mean(ends, axis=0).tolist(), 0.0] if ends else None,
        "listeners": [list(place) for place in scene.listeners] if ends else None,
        "scene": played_scene(scene, settings["speed"]),
        "hearBall": scene.sound.ball,
        "fullScale": peak / PEAK or 1.0,
        "level": run.record_laeq_db,
        "longStep": run.result.step if scene.step_nodes > 1 else None,
    }
    if vibration is None:
        _add_release(data, run)
        track = data["energy"]
    else:
        _add_vibration(data, run, vibration)
        track = data["law"]
    data["remarks"] = _remarks(run, track)
    if modes is not None:
        _add_modes(data, modes)
    return data


def _add_modes(data: Data, modes: StoredModes) -> None:
    """Add the modes of free or clamped edges to the data of a run: one slider scales both sides."""
    settings = data["settings"]
    limits = data["limits"]
    ratio = settings["length"] / settings["width"]
    data["modes"] = stored_arrays(modes)
    data["fixed"] |= {"sideRatio": ratio, "highestNumber": modes.data["highest"] * (1 + 1e-9)}
    least = max(limits["length"][0], ratio * limits["width"][0])
    limits["length"] = [min(least, settings["length"]), limits["length"][1]]
    del limits["width"]
    data["remarks"].append(
        "The width of the plate follows its length, because its modes belong to a side ratio."
    )


def stored_arrays(modes: StoredModes) -> Data:
    """Return modes with their arrays in base64."""
    arrays = {name: packed(values, KINDS[name])[0] for name, values in modes.arrays.items()}
    beams = [packed(values.ravel(), "float32")[0] for values in modes.beams]
    return modes.data | arrays | {"beams": beams}


def _limits(
    scene: Scene, settings: Data, vibrates: bool, ends: list[list[float]]
) -> dict[str, list[float]]:
    """Return lowest and highest value of the settings with a slider; `ends` of the contact [m]."""
    limits = {}
    for slider in SLIDERS:
        if _changes_the_sound(slider.name, settings, vibrates):
            value = settings[slider.name]
            limits[slider.name] = [min(slider.least, value), max(slider.most, value)]
    limits["distance"][0] = min(settings["distance"], max(0.1, 2 * scene.radius))
    if vibrates and settings["length"] is not None:
        for axis, name in enumerate(("length", "width")):
            least = LEAST_EDGE * max(end[axis] for end in ends)
            limits[name] = [min(least, settings[name]), max(MOST_EDGE_M, settings[name])]
    return limits


def _changes_the_sound(name: str, settings: Data, vibrates: bool) -> bool:
    """Tell whether a setting with a slider changes the sound of a run."""
    if not vibrates:
        return name in ("distance", "q")
    if name == "q":
        return False
    if name == "lossFactor" and not settings["length"]:
        return False
    return settings[name] is not None


def _settings(run: Run) -> Data:
    """Return the settings of a run that the page changes, in SI units."""
    scene = run.scene
    plate = scene.plate
    thickness = length = width = None
    if plate.thickness_mm:
        thickness = 1e-3 * plate.thickness_mm
        if plate.edges_mm:
            length, width = (1e-3 * edge for edge in plate.edges_mm)
    return {
        "speed": float(scene.motion.fastest(run.sound.duration)),
        "load": scene.load,
        "ballDensity": scene.sphere.density_kg_m3,
        "plateDensity": plate.density_kg_m3,
        "thickness": thickness,
        "length": length,
        "width": width,
        "lossFactor": _loss_at_middle(plate.loss_factor),
        "contactLossFactor": plate.contact_loss_factor or 0.0,
        "distance": scene.listener_distance_m,
        "q": scene.sound.q,
        "dropHeight": bodies_of(scene).drop_height_m or None,
    }


def played_scene(scene: Scene, speed_m_s: float) -> Data:
    """Return a scene as the page plays it: at a constant speed over the same track, at one place.

    Settings of the page become its keys. A distance instead of a duration keeps the track, and with
    it the surface, at every speed.
    """
    data = scene.with_auto_steps().to_dict()
    data.pop("sweep", None)
    data["numerics"].pop("slowest_m_s", None)
    data["name"] = f"{scene.name[:57]}-played"  # a name has 64 letters at most
    rolling = data["rolling"]
    rolling.pop("duration_s", None)
    rolling.pop("resistance", None)
    rolling["speed_m_s"] = speed_m_s
    rolling["distance_mm"] = float(f"{1e3 * scene.track.distance:.12g}")
    ends = list(scene.plate.contact_ends_mm.values())
    if ends:
        data["plate"]["contact_mm"] = list(ends[0])
    if len(ends) > 1:
        data["plate"].pop("contact_path", None)
        data["plate"].pop("contact_end_mm", None)
        places = [[round(1e3 * x, 6) for x in place] for place in scene.listeners]
        data["sound"].setdefault("listener_mm", places)  # above the middle of the path
    return data


def _fixed(scene: Scene) -> Data:
    """Return the numbers of a scene that only another march changes."""
    poisson = scene.plate.poissons_ratio
    # The mobility C w^2 / (rho c_T^3) is C where all other factors are one.
    unit = half_space_mobility(0.5 / np.pi, 2 * (1 + poisson), poisson, 1.0)
    return {
        "radius": scene.radius,
        "impactRadius": smooth_contact_of(scene).equivalent_radius_m,
        "young": 1e9 * scene.plate.youngs_modulus_gpa,
        "poisson": poisson,
        "modulus": scene.contact_modulus,
        "halfSpace": unit,
        "weight": scene.rolling.load_n == WEIGHT,
        "rollsOut": scene.rolling.resistance is not None,
        "resistance": _resistance(scene),
        "mass": scene.mass,
        "gravity": GRAVITY,
        "mostModes": MAX_MODES,
        "lossCurve": _loss_curve(scene.plate.loss_factor),
    }


def _resistance(scene: Scene) -> float | None:
    """Return the coefficient with which a ball rolls out on the page; None where none is usual.

    A light ball that something presses would rest at once.
    """
    if scene.rolling.resistance is not None:
        return scene.rolling.resistance
    return USUAL_RESISTANCE if scene.rolling.load_n == WEIGHT else None


class NewRun(NamedTuple):
    """A number of a run that only a new run changes.

    name, value : str. What it is, and the value of the run with its unit.
    command : str. A command that runs the scene with another value.
    """

    name: str
    value: str
    command: str


def needs_of_a_new_run(run: Run) -> list[NewRun]:
    """Return radius, stiffness, hardness and roughness of a run, with commands that change them."""
    needs = []
    for key, name in SOLVED_KEYS.items():
        value = labels.value_at(run.scene, key)
        if not isinstance(value, float):
            continue
        _, unit = labels.named(key)
        other = _other_value(run.scene, key, value)
        change = f"sweep.{key}=[{other}]" if key in run.values else f"{key}={other}"
        name_of_scene = run.scene.name
        command = f'rolling run {name_of_scene}.yaml --set "{change}"'
        command += f" --out outputs/{name_of_scene}-{other}"
        needs.append(NewRun(name, f"{value:g} {unit}".strip(), command))
    return needs


def _other_value(scene: Scene, key: str, value: float) -> str:
    """Return another value of a key that the scene allows: a larger one, or else a smaller one."""
    larger = rounded(CHANGED * value)
    try:
        scene.with_({key: float(larger)})
    except SceneError:  # such as a hardness above a fifth of Young's modulus
        return rounded(value / CHANGED)
    return larger


def _loss_at_middle(loss_factor: LossFactor | None) -> float | None:
    """Return the loss factor that a slider moves, at MIDDLE_HZ."""
    if loss_factor is None:
        return None
    return float(loss_factor_at(loss_factor, MIDDLE_HZ))


def _loss_curve(loss_factor: LossFactor | None) -> list[list[float]] | None:
    """Return pairs of a frequency [Hz] and the loss factor over that at MIDDLE_HZ, or None."""
    if not isinstance(loss_factor, tuple):
        return None
    middle = float(loss_factor_at(loss_factor, MIDDLE_HZ))
    return [[frequency, loss / middle] for frequency, loss in loss_factor]


def _remarks(run: Run, track: Data) -> list[str]:
    """Return sentences on the differences between the run and its play at a constant speed."""
    scene = run.scene
    remarks = list[str]()
    if run.sound.source == "release":
        remarks.append("What sounds here is the released power, and not the vibration.")
    if isinstance(scene.plate.loss_factor, tuple):
        remarks.append("The loss factor of the plate is set at 1 kHz; its curve moves with it.")
    if not scene.motion.is_constant(run.sound.duration):
        remarks.append("The speed of the run changes; the ball begins here at the highest one.")
    if len(scene.plate.contact_ends_mm) > 1:
        remarks.append("The contact stays at the beginning of its path.")
    if track["part"] < 1:
        remarks.append(f"The page holds {100 * track['part']:.0f} % of the track.")
    if not track["closed"]:
        remarks.append("The end of the track is cross-faded with its beginning.")
    return remarks


# ---- vibration


def _add_vibration(data: Data, run: Run, vibration: Vibration) -> None:
    """Add the force law of a run to its data, and the limits that it sets."""
    scene = run.scene
    law = vibration.law
    wave = shortest_wave(law.approach(law.position_m, scene.load), law.spacing_m)
    # Time steps resolve the shortest waves of the contact up to the highest speed. The grid limits
    # the frequency of slow motions alone, to v / (2 spacing).
    fastest = FASTEST_STEPS * SAMPLE_RATE_HZ * wave / 2
    falling = scene.mass * FALL_M_S**2 / (2 * scene.load)
    data["limits"] |= {
        "speed": [0.0, max(fastest, data["settings"]["speed"])],
        "dropHeight": [0.0, max(falling, bodies_of(scene).drop_height_m)],
    }
    if scene.rolling.load_n != WEIGHT:
        data["limits"]["load"] = [float(law.load_n[0]), float(law.load_n[-1])]
    data["fixed"]["shortestWave"] = wave
    body = plate_of(scene.plate).ground
    if isinstance(body, HalfSpaceBody):  # modulus of compression waves [Pa]
        data["fixed"]["compression"] = body.density_kg_m3 * body.compression_m_s**2
    closes = law.period_m is not None and not run.sound.has_seam
    data["kind"] = "vibration"
    data["law"] = stored_law(law, scene.load, closes)


def shortest_wave(approach: Array, spacing: float) -> float:
    """Return the wavelength [m] below which waves hold a small share of a roughness."""
    power = np.abs(np.fft.rfft(approach * np.hanning(len(approach)))) ** 2
    power[:3] = 0.0  # the mean in the window
    beyond = np.cumsum(power[::-1])[::-1]
    line = int(np.sum(beyond > RESOLVED * beyond[0]))
    return float(len(approach) * spacing / max(min(line, len(approach) // 2), 1))


def stored_law(law: ForceLaw, load_n: float, closes: bool = True) -> Data:
    """Return a force law as the page holds it: all of the track, or its largest part that fits.

    A track that takes too many bytes is resampled to fewer rows, as long as the force keeps to
    0.1 % of its fluctuation, and halved otherwise.
    """
    table = law.table
    values = table.values[: len(law.position_m)]
    varying = int(np.sum(np.ptp(values, axis=0) > 0))  # columns
    most = int(LARGEST * 3 / 4 / (2 * varying + 4))  # rows that fit
    part = len(values)
    while True:
        is_whole = part == len(values)
        rows = values if closes and is_whole else _closed(values[:part])
        seam = (part - len(rows)) * table.spacing
        count = min(len(rows), most)
        data, stored = _stored_table(table, load_n, table.start + seam, rows, count)
        if count == len(rows) or law_error(law, load_n, stored, seam) <= FAITHFUL:
            return data | {"closed": closes, "seam": seam, "part": part / len(values)}
        part //= 2


def _closed(rows: Array) -> Array:
    """Return open rows without their first, which are faded into the last ones."""
    count = max(2, len(rows) // SEAM)
    angle = np.linspace(0, np.pi / 2, count + 2)[1:-1, None]
    mean = rows.mean(axis=0)
    faded = rows.copy()
    faded[-count:] = mean + np.cos(angle) * (rows[-count:] - mean)
    faded[-count:] += np.sin(angle) * (rows[:count] - mean)
    least = rows[:, 1:].min(axis=0)  # slopes stay positive
    faded[:, 1:] = np.maximum(faded[:, 1:], least)
    return np.asarray(faded[count:])


def _stored_table(
    table: LawTable, load_n: float, start: float, rows: Array, count: int
) -> tuple[Data, LawTable]:
    """Return closed rows as stored columns, and as the table that they decode to."""
    spacing = table.spacing * len(rows) / count
    weights = slope_weights(table.breaks, load_n ** (2 / 3))
    if count < len(rows):
        rows = np.column_stack([resample_closed(column, count) for column in rows.T])
    columns = []
    decoded = np.empty((count, rows.shape[1]))
    for k in range(1, rows.shape[1]):
        column, decoded[:, k] = packed(rows[:, k], "int16")
        columns.append(column)
    # The lift-off makes up for the rounded slopes, so that the approach under the load is exact.
    lift_off = rows[:, 0] + (rows[:, 1:] - decoded[:, 1:]) @ weights
    column, decoded[:, 0] = packed(lift_off, "float32")
    data = {
        "start": start,
        "spacing": spacing,
        "breaks": table.breaks.tolist(),
        "columns": [column, *columns],
    }
    around = np.concatenate((decoded, decoded[:1]))  # the end meets the beginning
    return data, law_table(start, spacing, True, table.breaks, around)


def packed(values: Array, kind: str) -> tuple[Data, Array]:
    """Return values in base64, a single value if all are equal, and the values that they become."""
    low = float(values.min())
    high = float(values.max())
    offset = (low + high) / 2
    if low == high:
        values = values[:1]
    if kind == "int16":
        scale = (high - low) / 65_000 or 1.0
        stored = np.rint((values - offset) / scale).astype("<i2")
    else:
        scale = 1.0
        stored = (values - offset).astype("<f4")
    text = base64.b64encode(stored.tobytes()).decode()
    data = {"type": kind, "base64": text, "scale": scale, "offset": offset}
    return data, offset + scale * stored.astype(float)


def law_error(law: ForceLaw, load_n: float, table: LawTable, seam: float = 0.0) -> float:
    """Return the rms error of the force before a seam [m] over its departure from the load."""
    length = table.spacing * (len(table.values) - 1) - seam
    x = law.position_m[(law.position_m >= table.start) & (law.position_m < table.start + length)]
    level = law.approach(x, load_n)
    fluctuation = np.std(law.force(x, level.mean()))
    force = np.empty((len(x), 2))  # with its slope
    errors = []
    for load in law.load_n:
        _motion_kernels.evaluate(x, law.approach(x, float(load)), table, force)
        rms_error = np.sqrt(np.mean(np.square(force[:, 0] - load)))
        departure = np.hypot(fluctuation, load - load_n)
        errors.append(rms_error / (departure or load_n))
    return float(max(errors))


# ---- release


def _add_release(data: Data, run: Run) -> None:
    """Add the energy that each step of a lap releases to the data of a run."""
    result = run.result
    scene = run.scene
    energy, _ = released_energy(scene, result)
    energy = energy[: result.solved_steps]
    closes = scene.track.lap_steps <= result.solved_steps and not run.sound.has_seam
    most = LARGEST * 3 // 16  # steps that fit
    count = min(len(energy), most)
    rows = energy[:count, None]
    if not closes or count < len(energy):
        rows = _closed(rows)
    data["limits"]["speed"] = [0.0, max(10.0, data["settings"]["speed"])]
    data["fixed"]["silent"] = not run.sound.pressure.any()
    data["kind"] = "release"
    data["energy"] = {
        "start": result.start + (count - len(rows) + 0.5) * result.step,
        "closed": closes,
        "part": min(most / len(energy), 1.0),
        **release_lines(rows[:, 0], result.step),
        "gain": scene.sound.gain_pa_per_w_m2,
    }


def release_lines(energy: Array, step: float) -> Data:
    """Return the Fourier lines of the release [J/m], with the mean over a step [m] undone."""
    count = len(energy)
    lines = np.fft.rfft(energy) / (count * step * np.sinc(np.fft.rfftfreq(count)))
    lines[0] = 0.0  # only the fluctuation sounds
    if count % 2 == 0:
        lines[-1] = 0.0
    real, _ = packed(lines.real, "float32")
    imaginary, _ = packed(lines.imag, "float32")
    return {"re": real, "im": imaginary, "length": count * step}
