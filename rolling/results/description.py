"""Runs in words: what rolls on what, and what is special about the sound of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES, EDGES_HZ
from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.dynamics import drop
from rolling.in_si.physics_of_scene import bodies_of
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results.labels import named, value_at
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT, Plate
from rolling.scene.surfaces import BallHeightFile, GradedBall, HeightFile
from rolling.scene.values_in_si import STEEL_DENSITY, STEEL_GPA

MAX_SENTENCES = 3  # of the scenes of a page; more are counted
MAX_LISTED = 4  # values of a quantity that a sentence lists; of more it names the ends
_NUMBERS = (
    "no",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
)


def listed(texts: Iterable[str]) -> str:
    """Join texts as a sentence does: 5, 20 and 100."""
    *others, last = texts
    if not others:
        return last
    return f"{', '.join(others)} and {last}"


def number_word(count: int) -> str:
    """Write a count, up to twelve as a word."""
    return _NUMBERS[count] if 0 <= count < len(_NUMBERS) else f"{count}"


# ---- what rolls on what


def runs_sentence(runs: Sequence[RunFolder]) -> str:
    """Say what rolls on what in runs: one sentence for each of up to three scenes, else a count.

    Runs of a scene whose ball falls have a sentence of their own beside those that roll.
    """
    by_scene: dict[tuple[str, bool], list[Scene]] = {}
    for run in runs:
        scene = run.scene
        by_scene.setdefault((scene.name, scene.is_one_event), []).append(scene)
    if len(by_scene) > MAX_SENTENCES:
        return f"{len(runs)} runs of {len({name for name, _ in by_scene})} scenes."
    swept = dict.fromkeys(key for run in runs for key in run.values)
    return " ".join(_sentence(scenes, [*swept]) for scenes in by_scene.values())


def _sentence(scenes: Sequence[Scene], swept: Sequence[str]) -> str:
    """Say what rolls on what in the runs of one scene."""
    moves = f"{_rolls(scenes)} over {_plate(scenes)}"
    if scenes[0].rolling.drop_mm is not None:
        heights = values_text([scene.rolling.drop_mm for scene in scenes])
        moves = f"falls {heights} mm onto {_plate(scenes)}, bounces and rolls {_speed(scenes)}"
    ending = _also_varied(scenes, swept)
    if any(scene.is_permanent for scene in scenes):
        ending += ", and the plate keeps its dents"
    return f"{_ball(scenes)} {moves} {_load(scenes)}{ending}."


def subject(scenes: Sequence[Scene]) -> str:
    """Say what rolls on what under which loads in the runs of one scene, for a title."""
    ball = _ball(scenes).partition(" ")[2]
    loads = [scene.load for scene in scenes]
    words = f"{rounded(min(loads), 3)} N"
    if all(scene.rolling.load_n == WEIGHT for scene in scenes):
        words = "under its own weight"
    elif min(loads) < max(loads):
        words = f"{rounded(min(loads), 3)} to {rounded(max(loads), 3)} N"
    return f"{ball[0].upper()}{ball[1:]} on {_plate(scenes)}, {words}"


def different_words(scenes: Sequence[Scene], word: Callable[[Scene], str]) -> list[str]:
    """Return the different words for scenes, without empty ones, in their order."""
    return [text for text in dict.fromkeys(map(word, scenes)) if text]


def values_text(values: Sequence[float | None]) -> str:
    """Write the different values of a quantity: all, or how many and the ends of many."""
    known = [*dict.fromkeys(value for value in values if value is not None)]
    if len(known) > MAX_LISTED:
        return f"{rounded(min(known), 3)} to {rounded(max(known), 3)}"
    return listed(rounded(value, 3) for value in known)


def _ball(scenes: Sequence[Scene]) -> str:
    """Name the ball: its material, diameter and surface."""
    materials = different_words(scenes, ball_material)
    material = listed(materials) if materials else ""
    material = material.replace("bearing steel", "bearing-steel")
    diameters = values_text([2 * scene.sphere.radius_mm for scene in scenes])
    words = f"{material} {_shape(scenes[0])}".strip()
    if words.endswith("wheel"):
        words = f"crowned {words}"
    article = "An" if words[0] in "aeiou" else "A"
    return f"{article} {words} of {diameters} mm{ball_surface(scenes)}"


def _shape(scene: Scene) -> str:
    """Name the shape of the body that rolls."""
    across = scene.sphere.radius_across_mm
    if across is None or across == scene.sphere.radius_mm:
        return "ball"
    return "wheel"


def ball_material(scene: Scene) -> str:
    """Name the material of the ball in a word; a body without values is taken as steel."""
    sphere = scene.sphere
    if sphere.material is not None:
        return material_word(sphere.material)
    return _kind_of_material(sphere.youngs_modulus_gpa, sphere.density_kg_m3) or ""


def plate_material(plate: Plate) -> str:
    """Name the material of a plate in a word; empty for values of no common one."""
    if plate.material is not None:
        return material_word(plate.material)
    return _kind_of_material(plate.youngs_modulus_gpa, plate.density_kg_m3) or ""


def material_word(name: str) -> str:
    """Return the word for a material of the library: steel-100cr6 is bearing steel."""
    if name == "steel-100cr6":
        return "bearing steel"
    words = {"pmma": "PMMA", "pom": "POM", "cast-iron-gjl-250": "cast iron"}
    if name in words:
        return words[name]
    if name in ("tungsten-carbide", "silicon-nitride"):
        return name.replace("-", " ")
    return name.partition("-")[0]


# Modulus [GPa] and density [kg/m3] by which a body without a name is called steel or glass, and
# how far, relative, a value may lie from them.
_COMMON = {"steel": (STEEL_GPA, STEEL_DENSITY), "glass": (70.0, 2500.0)}
_NEAR = 0.05


def _kind_of_material(young_gpa: float | None, density: float | None) -> str | None:
    """Name a material by its modulus and density; None for values of neither steel nor glass.

    The program takes a ball without both as rigid, and as heavy as steel where it needs a mass.
    """
    if young_gpa is None and density is None:
        return "steel"
    for name, (usual_gpa, usual_density) in _COMMON.items():
        fits_modulus = young_gpa is None or abs(young_gpa / usual_gpa - 1) <= _NEAR
        fits_density = density is None or abs(density / usual_density - 1) <= _NEAR
        if fits_modulus and fits_density:
            return name
    return None


def ball_surface(scenes: Sequence[Scene]) -> str:
    """Describe the surface of the ball; nothing for a smooth one."""
    grades = []
    for scene in scenes:
        if isinstance(scene.sphere.surface, GradedBall):
            grades.append(scene.sphere.surface.grade)
    words = ""
    if grades:
        names = [*dict.fromkeys(grades)]
        words = f" (grade{'s' if len(names) > 1 else ''} {listed(names)})"
    texts = different_words(scenes, _ball_roughness)
    if texts:
        words += f" ({listed(texts)})"
    faults = different_words(scenes, ball_faults)
    if faults:
        words += f" with {faults[0]}"
    return words


def _ball_roughness(scene: Scene) -> str:
    """Describe roughness and waviness of a ball without a grade."""
    surface = scene.sphere.surface
    if surface is None or isinstance(surface, GradedBall):
        return ""
    parts = []
    if isinstance(surface, BallHeightFile):
        parts.append(f"heights of {printable(surface.path)}")
    elif surface.law is not None:
        parts.append(_roughness_of_law(surface.law))
    if surface.waviness:
        parts.append("wavy")
    return ", ".join(parts)


def _roughness_of_law(law: Any) -> str:
    """Write the height parameter of a law that the scene gives."""
    if getattr(law, "roughness_ra_um", None) is not None:
        return f"Ra {law.roughness_ra_um:g} µm"
    if getattr(law, "rq_um", None) is not None:
        return f"Sq {law.rq_um:g} µm"
    return f"Sdq {law.rdq:g}"


def ball_faults(scene: Scene) -> str:
    """Name the faults of the ball."""
    surface = scene.sphere.surface
    return "" if surface is None else faults_in_words(surface.faults or ())


def faults_in_words(faults: Sequence[Any]) -> str:
    """Name faults: a pit of 80 µm, or three scratches."""
    count = sum(fault.count or 1 for fault in faults)
    if count == 0:
        return ""
    kinds = [*dict.fromkeys(fault.kind for fault in faults)]
    if count == 1:
        return f"a {kinds[0]} of {faults[0].size_um:g} µm"
    if len(kinds) > 1:
        return f"{number_word(count)} faults"
    return f"{number_word(count)} {_plural(kinds[0])}"


def _plural(noun: str) -> str:
    """Return the plural of the kind of a fault."""
    return f"{noun}es" if noun.endswith("ch") else f"{noun}s"


def _rolls(scenes: Sequence[Scene]) -> str:
    """Say how the ball rolls: at a speed, at changing speed, rolling out, or to and fro."""
    first = scenes[0]
    to_and_fro = " to and fro" if len(first.plate.contact_ends_mm) > 1 else ""
    passes = values_text([float(scene.passes) for scene in scenes])
    again = ""
    if passes != "1":
        again = " twice"
        if passes != "2":
            again = f" {number_word(int(passes)) if passes.isdecimal() else passes} times"
    if first.rolling.resistance:
        speeds = values_text([_start_speed(scene) for scene in scenes])
        out = f"rolls out from {speeds} m/s"
        return f"{out},{to_and_fro}" if to_and_fro else out
    return f"rolls{to_and_fro}{again} {_speed(scenes)}"


def _start_speed(scene: Scene) -> float:
    """Return the first speed [m/s] of a scene."""
    return scene.motion.speeds[0]


def _speed(scenes: Sequence[Scene]) -> str:
    """Write the speed of the ball, or how it changes."""
    profiles = [scene for scene in scenes if len(scene.motion.speeds) > 1]
    if not profiles:
        return f"at {values_text([_start_speed(scene) for scene in scenes])} m/s"
    speeds = [speed for scene in scenes for speed in scene.motion.speeds]
    return f"at speeds from {rounded(min(speeds), 3)} to {rounded(max(speeds), 3)} m/s"


def _plate(scenes: Sequence[Scene]) -> str:
    """Name the plate: its finish, material, size and roughness."""
    finishes = listed(different_words(scenes, finish_word) or [""])
    materials = different_words(scenes, lambda scene: plate_material(scene.plate))
    sizes = [*dict.fromkeys(plate_size(scene.plate) for scene in scenes)]
    if sizes == [""] and materials:
        body = f"{finishes} {listed(materials)}"
    elif len(materials) > 1:
        body = f"{finishes} plates of {listed(materials)}{_sizes(scenes)}"
    elif len(sizes) > 1 or len(different_words(scenes, finish_word)) > 1:
        material = "".join(materials).replace(" ", "-")
        body = f"{finishes} {material} plates{_sizes(scenes)}"
    else:
        material = "".join(materials).replace(" ", "-")
        body = _with_article(f"{finishes} {material} plate{_sizes(scenes)}")
    words = " ".join(body.split())
    brackets = _brackets(scenes)
    if brackets:
        words += f" ({', '.join(brackets)})"
    faults = different_words(scenes, plate_faults)
    if faults:
        words += f" with {faults[0]}"
    return words


def _with_article(words: str) -> str:
    """Put the article before the words for a plate."""
    words = words.strip()
    return f"an {words}" if words[0] in "aeiou" else f"a {words}"


def _sizes(scenes: Sequence[Scene]) -> str:
    """Write the sizes of plates that bend; nothing for half-spaces."""
    sizes = different_words(scenes, lambda scene: plate_size(scene.plate))
    return f" of {listed(sizes)}" if sizes else ""


def _brackets(scenes: Sequence[Scene]) -> list[str]:
    """Return what stands in brackets behind a plate: its roughness, and the number of surfaces."""
    brackets = _shortened(different_words(scenes, roughness_text))
    if len(brackets) > MAX_LISTED:
        brackets = [f"{len(brackets)} different surfaces"]
    seeds = {getattr(scene.surface, "seed", None) for scene in scenes}
    if len(seeds) > 1:
        brackets.append(f"{number_word(len(seeds))} random surfaces")
    return brackets


def plate_faults(scene: Scene) -> str:
    """Name the faults of the plate."""
    return faults_in_words(scene.surface.faults or ())


def _shortened(texts: list[str]) -> list[str]:
    """Join texts that begin with the same word and end with the same unit: Ra 0.1 and 0.2 µm."""
    heads = {text.partition(" ")[0] for text in texts if text.startswith("Ra ")}
    roughnesses = [text for text in texts if text.startswith("Ra ")]
    if len(heads) != 1 or len(roughnesses) < 2:
        return texts
    values = [text.split()[1] for text in roughnesses]
    others = [text for text in texts if not text.startswith("Ra ")]
    return [f"Ra {listed(values)} µm", *others]


def finish_word(scene: Scene) -> str:
    """Name the finish of the plate in a word."""
    surface = scene.surface
    if isinstance(surface, HeightFile):
        return "measured"
    finish = getattr(surface, "finish", None)
    if finish is not None:
        return str(finish)
    return "smooth" if surface.law is None else ""


def roughness_text(scene: Scene) -> str:
    """Write the roughness of the plate that the scene gives, or the file of its heights."""
    surface = scene.surface
    if isinstance(surface, HeightFile):
        return printable(surface.path.replace("\\", "/").rpartition("/")[2])
    return "" if surface.law is None else _roughness_of_law(surface.law)


def plate_size(plate: Plate) -> str:
    """Write the size of a plate that bends; empty for a half-space."""
    if plate.thickness_mm is None:
        return ""
    if plate.edges_mm is None:
        return f"{plate.thickness_mm:g} mm"
    length, width = plate.edges_mm
    return f"{length:g} x {width:g} x {plate.thickness_mm:g} mm"


def _load(scenes: Sequence[Scene]) -> str:
    """Write the load of the ball."""
    if all(scene.rolling.load_n == WEIGHT for scene in scenes):
        return "under its own weight"
    return f"under {values_text([scene.load for scene in scenes])} N"


# Swept keys that the other parts of a sentence show.
_SHOWN = (
    "rolling.load_n",
    "rolling.speed_m_s",
    "rolling.drop_mm",
    "rolling.passes",
    "plate.material",
    "plate.thickness_mm",
    "surface",
    "surface.finish",
    "surface.roughness_ra_um",
    "surface.rq_um",
    "surface.rdq",
    "surface.path",
    "surface.seed",
    "sphere.radius_mm",
    "sphere.material",
    "sphere.surface.grade",
    "sphere.surface.roughness_ra_um",
)


def _also_varied(scenes: Sequence[Scene], swept: Sequence[str]) -> str:
    """Name swept quantities that the sentence does not show, with their values if they are few."""
    texts = []
    for key in swept:
        if key in _SHOWN or len(scenes) < 2:
            continue
        word, unit = named(key)
        values = [value_at(scene, key) for scene in scenes]
        numbers = [value for value in values if isinstance(value, float)]
        if len(numbers) == len(values):
            texts.append(f"{word} {values_text(numbers)} {unit}".rstrip())
        else:
            texts.append(f"different {word}")
    return f", with {listed(texts)}" if texts else ""


# ---- what is special about a run

HIGH_HZ = 12e3  # many ears and loudspeakers reproduce nothing above
HEARD_RING_HZ = 16e3  # a higher resonance of the ball on its contact is not heard
RINGS = 3.0  # quality factor from which a resonance rings
MAX_SPECIAL = 2  # sentences on what is special
MOST = 0.5  # share of the sound that is called most
_HIGH = "Most of its energy lies above 12 kHz, which many ears and loudspeakers do not reproduce."


def special(scene: Scene, numbers: RunNumbers) -> str:
    """Say in one or two sentences what is special about the sound of a run; empty for nothing."""
    if numbers.of_record.laeq_db is None:
        return ""
    texts = [
        rule(scene, numbers)
        for rule in (_fall, _ticks, _rests, _modes, _ringing, _lost_contact, _repeats, _high)
    ]
    return " ".join([sentence for sentence in texts if sentence][:MAX_SPECIAL])


def _fall(scene: Scene, numbers: RunNumbers) -> str:
    """Tell how long a ball that falls bounces, in the long record if there is one."""
    restitution = None if numbers.motion is None else numbers.motion.restitution
    if scene.rolling.drop_mm is None or restitution is None:
        return ""
    sentence = f"The first impact leaves the ball {100 * restitution:.0f} % of its speed"
    long = numbers.listening
    if long is None or not long.impacts:
        return f"{sentence}."
    seconds = (long.seconds or 0.0) * (long.flight_share or 0.0) - drop.fall_s(bodies_of(scene))
    return f"{sentence}. It bounces for about {rounded(seconds, 1)} s, and then rolls."


def _ticks(scene: Scene, numbers: RunNumbers) -> str:
    """Tell how often faults of the ball, which meet the plate once in a turn, tick."""
    surface = scene.sphere.surface
    if surface is None or not surface.faults or not scene.motion.is_constant(scene.duration):
        return ""
    count = sum(fault.count or 1 for fault in surface.faults)
    turns_per_second = scene.motion.speeds[0] / (2 * math.pi * scene.radius)
    kinds = [*dict.fromkeys(fault.kind for fault in surface.faults)]
    times = _times(count * turns_per_second)
    if count == 1:
        return f"The {kinds[0]} ticks {times} a second."
    noun = _plural(kinds[0]) if len(kinds) == 1 else "faults"
    return f"The {number_word(count)} {noun} tick {times} a second."


def _times(rate: float) -> str:
    """Write how often something happens in a second."""
    whole = round(rate)
    if whole >= 2 and abs(rate / whole - 1) <= 0.02:
        return f"{number_word(whole)} times"
    return f"{rounded(rate)} times"


def _rests(scene: Scene, numbers: RunNumbers) -> str:
    """Tell when a ball that rolls out rests, if that is heard."""
    rest_s = scene.motion.rest_time
    heard_s = max(numbers.record.duration_s, scene.sound.listen_s or 0.0)
    if not scene.rolling.resistance or not rest_s < heard_s:
        return ""
    return f"The ball rolls out, and rests after {rounded(rest_s)} s."


def _lost_contact(scene: Scene, numbers: RunNumbers) -> str:
    """Tell of a ball that loses contact with the plate."""
    motion = numbers.motion
    if motion is None or not motion.flight_share or not motion.impacts:
        return ""
    percent = rounded(100 * motion.flight_share)
    times = _times(motion.impacts / numbers.record.duration_s)
    return (
        f"The ball loses contact for {percent} % of the time, and hits the plate {times} a second."
    )


def _repeats(scene: Scene, numbers: RunNumbers) -> str:
    """Tell of a track that is so short that its repetition is heard as a tone."""
    is_long = numbers.listening is not None and bool(numbers.listening.seconds)
    if numbers.heard is not None:
        is_long = numbers.heard.long_s is not None
    keys = {doubt.key for doubt in numbers.doubts}
    if is_long or not keys & {"short_loop", "short_track"}:
        return ""
    return "The track is so short that one hears its repetition as a hum, beside the contact."


def _modes(scene: Scene, numbers: RunNumbers) -> str:
    """Tell where a plate with edges rings."""
    motion = numbers.motion
    if motion is None or not motion.plate_modes or numbers.record.source != "vibration":
        return ""
    loudest_hz = _loudest_band_hz(numbers)
    if loudest_hz is None or loudest_hz > HEARD_RING_HZ:
        return ""
    return f"The plate rings at its modes, loudest near {_frequency(loudest_hz)}."


def _ringing(scene: Scene, numbers: RunNumbers) -> str:
    """Tell at which frequency the ball rings on its contact, if that is heard."""
    motion = numbers.motion
    if motion is None or motion.resonance_hz > HEARD_RING_HZ:
        return ""
    if numbers.record.source != "vibration":
        return ""
    if motion.resonance_q is not None and motion.resonance_q < RINGS:
        return ""
    return f"The ball rings on its contact at {_frequency(motion.resonance_hz)}."


def _frequency(hertz: float) -> str:
    """Write a frequency with two digits."""
    return f"{rounded(hertz)} Hz" if hertz < 995 else f"{rounded(hertz / 1e3)} kHz"


def _loudest_band_hz(numbers: RunNumbers) -> float | None:
    """Return the middle of the loudest A-weighted third octave [Hz]; None in silence."""
    levels = {name: level for name, level in _a_weighted(numbers).items() if level is not None}
    if not levels:
        return None
    return float(max(levels, key=lambda name: levels[name]))


def _a_weighted(numbers: RunNumbers) -> dict[str, float | None]:
    """Return the A-weighted third octaves of the record that is measured [dB(A)]."""
    bands = numbers.bands_a_of_record
    return {} if bands is None else bands.by_name


def _high(scene: Scene, numbers: RunNumbers) -> str:
    """Tell of a sound that many ears and loudspeakers do not reproduce."""
    return _HIGH if _high_share(numbers) > MOST else ""


def _high_share(numbers: RunNumbers) -> float:
    """Return the share of the A-weighted energy above HIGH_HZ."""
    bands = _a_weighted(numbers)
    levels = [bands.get(name) for name in BAND_NAMES]
    power = np.array([0.0 if level is None else 10 ** (level / 10) for level in levels])
    if not power.sum() > 0:
        return 0.0
    edges = np.log(EDGES_HZ)
    above = np.clip((edges[1:] - math.log(HIGH_HZ)) / np.diff(edges), 0.0, 1.0)
    return float(power @ above / power.sum())
