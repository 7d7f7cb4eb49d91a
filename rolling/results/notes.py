"""Notes: standing properties of the numbers of a run, in whole sentences.

They say what a level is, what its uncertainty covers, and how record and load are meant.
"""

from collections.abc import Iterator

from acoustics.numbers import rounded
from acoustics.plate_modes import FREE
from rolling.check import level_doubts
from rolling.dynamics.comb import NEAR_SPEEDS
from rolling.marches.result import MovingRelease
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.quantity import PART_WORDS, RELEASED_POWER
from rolling.results.description import listed
from rolling.results.long_record import ends_within
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

UNVALIDATED = "No level has been validated against a microphone."
SHORT_S = 0.3  # a shorter period of repetition is heard as a tone

# Doubts that stand beside every level, and beside every player, by their keys.
HEADLINE = (
    *level_doubts.SOURCES,
    "on_axis",
    "infinite_plate",
    "at_listener",
    "plate_edges",
    "unvalidated",
    "uncertainty",
)
REPEATS = ("short_loop", "short_track")
TURNS = "turns_unknown"


def rules(
    scene: Scene,
    sound: ContactSound,
    numbers: RunNumbers,
    vibration: Vibration | None,
    moving: MovingRelease | None,
) -> Iterator[Doubt]:
    """Yield the notes on a run, and the bound or the assumption that its level is."""
    yield from _level(scene, sound, numbers, vibration)
    yield from _record(scene, sound)
    yield from _load(scene, moving)
    yield from _passes(scene)
    yield from _turns(sound, numbers)


def note(key: str, text: str) -> Doubt:
    """Return a standing property of the numbers."""
    return Doubt(key, text, Severity.NOTE)


def _level(
    scene: Scene, sound: ContactSound, numbers: RunNumbers, vibration: Vibration | None
) -> Iterator[Doubt]:
    """Say what the levels are, and what their uncertainty covers; a silent run has none."""
    if sound.steady_level is None and sound.levels.level_db is None:
        return
    if sound.source == "vibration":
        yield from _radiation(scene)
    else:
        yield from _release(scene, sound)
    yield note("unvalidated", UNVALIDATED)
    if sound.uncertainty.level_db is not None or sound.steady_uncertainty is not None:
        yield _uncertainty(numbers, vibration)


def _release(scene: Scene, sound: ContactSound) -> Iterator[Doubt]:
    """Say which bound the levels of a release are; of silence, or a gain, the steady level is."""
    gain = scene.sound.gain_pa_per_w_m2
    q = scene.sound.q
    if gain is not None or sound.levels.level_db is None:
        if q == 1:
            yield note(
                "upper_bound",
                "The steady level is an upper bound: all released energy counts as radiated "
                "(q = 1).",
            )
        else:
            yield note(
                "assumed_q",
                f"The steady level is that of the released power times {q:g}, which is an "
                "assumption.",
            )
    if sound.levels.level_db is not None:
        yield from level_doubts.of_source(scene)


def _radiation(scene: Scene) -> Iterator[Doubt]:
    """Say where and of which bodies the pressure of a vibration is."""
    sources = "plate and sphere" if scene.sound.ball else "plate"
    if scene.plate.edges_mm is None:
        yield note(
            "on_axis",
            f"Levels are the pressure of {sources} on the axis through the contact, at one "
            f"listener at {scene.sound.distance_m:g} m without a room.",
        )
        body = "an infinite plate without modes, edges or supports"
        if scene.plate.thickness_mm is None:
            body = "a half-space"
        yield note(
            "infinite_plate",
            f"The sphere rolls on {body}, pressed by a constant force without mass; friction, "
            "rocking and rotation are left out.",
        )
        return
    place = scene.listener_place
    if scene.sound.listener_mm is None:
        place += " above the contact"
    yield note("at_listener", f"Levels are the pressure of {sources} at {place}, without a room.")
    path = "stays at its point of the plate"
    if len(scene.plate.contact_ends_mm) > 1:
        path = "moves to and fro on a straight line"
    yield note(
        "plate_edges",
        f"The plate is {_held(scene)} in an infinite rigid baffle, {_baffle(scene)}; the contact "
        f"{path}. A constant force without mass presses the sphere; friction, rocking and rotation "
        "are left out.",
    )


def _baffle(scene: Scene) -> str:
    """Write what the baffle changes."""
    if set(scene.plate.edge_pair) != {FREE}:
        return "which makes a plate smaller than the wavelength too loud"
    return "which a free plate in the open does not have"


def _held(scene: Scene) -> str:
    """Write how the edges of a plate are held."""
    words = {"simply_supported": "simply supported", "free": "free", "clamped": "clamped"}
    ends, sides = (words[kind] for kind in scene.plate.edge_pair)
    text = f"{ends} at its edges"
    if ends != sides:
        text = f"{ends} at the ends of its length, {sides} at those of its width,"
    if ends == sides == "free":
        text += ", lies on something so soft that it moves freely,"
    return text


def _uncertainty(numbers: RunNumbers, vibration: Vibration | None) -> Doubt:
    """Say what the uncertainties of the two numbers cover."""
    texts = []
    for words, quantity in (
        ("vibration", numbers.vibration),
        ("released power", numbers.released_power),
    ):
        covered = [PART_WORDS[source] for source, part in quantity.parts.items() if part]
        if covered and quantity.value is not None:
            texts.append(f"± of the {words} covers {listed(covered)}.")
    if not texts:  # a silent release has a steady level alone
        texts.append(f"± covers {PART_WORDS['record']}.")
    texts += ["It holds no error of the model.", _rule_of_length(numbers, vibration)]
    if numbers.errors.is_asked and numbers.errors.reason is None:
        texts.append("Levels are not corrected for their errors of grid and solver.")
    return note("uncertainty", " ".join(texts))


def _rule_of_length(numbers: RunNumbers, vibration: Vibration | None) -> str:
    """Say how the length of the record that is measured becomes an uncertainty."""
    vibrating = vibration if numbers.record.source == "vibration" else None
    if vibrating is not None and vibrating.is_mean_of_comb:
        return f"Its comb is the spread of LAeq over speeds within {100 * NEAR_SPEEDS:g} %."
    if vibrating is not None and vibrating.once:
        return "The record is one fall, whose LAE (re 1 s) holds what sounds within the record."
    if vibrating is not None and vibrating.motion.flight_share:
        return (
            "The length counts by the scatter between thirds of the record, because impacts are "
            "not Gaussian noise."
        )
    if vibrating is not None and vibrating.excess is not None:
        return "The record is taken as stationary noise whose unevenness it shows."
    return "The record is taken as stationary Gaussian noise."


def _record(scene: Scene, sound: ContactSound) -> Iterator[Doubt]:
    """Tell of a record that does not loop, or whose repetition is heard."""
    if ends_within(sound, scene.motion, sound.duration):
        yield note("not_loopable", f"The record ends: it is {sound.ends}, and does not go round.")
        return
    if not sound.loops and sound.closed:
        text = "The ends of the record do not fit together: a loop of it is cross-faded."
        yield note("not_loopable", text)
    elif not sound.loops:
        yield note(
            "not_loopable",
            f"The record does not close on itself: it is {sound.ends}, and a loop of it is "
            "cross-faded.",
        )
    if sound.levels.level_db is None:
        return
    lap = scene.track.lap_steps * scene.track.step
    period = sound.duration * min(1.0, lap / float(scene.motion.distance(sound.duration)))
    if sound.duration < SHORT_S:
        period = min(period, len(sound.lap) / sound.sample_rate)
        yield note(
            "short_loop",
            f"When it loops, the record of {rounded(sound.duration, 3)} s repeats "
            f"{_per_second(period)} times a second: the pitch that is heard is the repetition, not "
            "the contact.",
        )
    elif period < min(SHORT_S, 0.999 * sound.duration):
        yield note(
            "short_track",
            f"The track repeats in the record every {rounded(period, 3)} s, "
            f"{_per_second(period)} times a second: the pitch that is heard is the repetition, not "
            "the contact.",
        )


def _per_second(period: float) -> str:
    """Write how often a period [s] repeats in a second."""
    rate = 1 / period
    return rounded(rate) if rate < 10 else f"{rate:.0f}"


def _load(scene: Scene, moving: MovingRelease | None) -> Iterator[Doubt]:
    """Tell under which load the release was computed."""
    if scene.dynamics is None:
        yield note(
            "quasi_static",
            "The load is held constant: the sphere neither bounces nor rings on its contact.",
        )
    elif moving is not None and moving.failure:
        yield Doubt(
            "no_moving_release",
            "release: of the constant load, because there is none under the moving load",
            Severity.INDICATIVE,
            advice=moving.failure,
            about=(RELEASED_POWER,),
        )
    elif moving is not None:
        yield note(
            "moving_load_release",
            "The release is computed under the moving load; the series along the track are of the "
            "constant load.",
        )
    elif not scene.keeps_its_load:
        yield note(
            "constant_load_release",
            "The release is computed under the constant load, as if the sphere rolled from the "
            "start.",
        )
    else:
        yield note(
            "constant_load_release",
            "The release is computed under the constant load; dynamics.release: true computes it "
            "under the moving load.",
        )


def _passes(scene: Scene) -> Iterator[Doubt]:
    """Tell of which pass over a plate with memory the record is."""
    if scene.is_permanent:
        yield note(
            "permanent",
            f"The record is of pass {scene.passes} over a plate that keeps its plastic overlap, "
            "without pile-up, hardening or residual stress.",
        )


def _turns(sound: ContactSound, numbers: RunNumbers) -> Iterator[Doubt]:
    """Tell why a record cannot say whether the turns of the sphere are heard."""
    reason = None if numbers.turns is None else numbers.turns.reason
    if reason and sound.levels.laeq_db is not None and not sound.once:
        text = "turns of the sphere: the record cannot tell whether they are heard, because "
        yield note(TURNS, text + reason)
