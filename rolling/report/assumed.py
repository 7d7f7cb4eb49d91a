"""The assumptions behind the numbers of a run: sound, bodies, contact and surface, in words."""

import math

from acoustics.numbers import bracketed, rounded, rounded_up
from acoustics.radiation import RHO_C
from acoustics.texts import printable
from rolling.numbers.ball_numbers import MotionNumbers
from rolling.numbers.views import NOTHING
from rolling.results.run_result import Run
from rolling.scene import surfaces
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT, loss_text


def assumptions(run: Run) -> dict[str, str]:
    """Return the assumptions of a run by their names."""
    return _source(run) | _record(run) | of_machine(run)


def of_machine(run: Run) -> dict[str, str]:
    """Return the assumptions about bodies and contact by their names."""
    return _bodies(run) | _contact(run)


def _record(run: Run) -> dict[str, str]:
    """Return length, ends and highest frequency of the record."""
    sound = run.sound
    ends = "closes on itself" if sound.loops else sound.ends
    highest = f"{rounded(min(sound.highest, sound.sample_rate / 2) / 1e3, 4)} kHz"
    if not sound.constant_speed:
        highest += " at the maximum speed, less while it is slower"
    return {
        "record": f"{rounded(sound.duration, 4)} s, {ends}",
        "resolved up to": highest,
    }


def _source(run: Run) -> dict[str, str]:
    """Return the assumptions about the source of the sound and its conversion."""
    scene = run.scene
    if run.sound.source == "vibration":
        ball = "plate and sphere" if scene.sound.ball else "plate"
        if scene.plate.edges_mm is not None:
            places = [bracketed(listener.at_mm) for listener in run.numbers.levels.listeners or ()]
            return {
                "source": f"vibration of {ball}, the plate in an infinite rigid baffle",
                "listener [mm] from the corner of the plate": "; ".join(places),
                "distance from the contact to the listener": f"{scene.listener_distance_m:.3g} m",
            }
        return {
            "source": f"vibration of {ball}, the pressure on the axis through the contact",
            "distance": f"{scene.sound.distance_m:g} m",
        }
    factor = run.sound.factor
    pressure = f"{rounded(factor, 4)} Pa per W/m²" if factor else "none: silent"
    if scene.sound.gain_pa_per_w_m2 is None:
        rule = "mean p² over the impedance is the rms of the intensity's fluctuation"
    else:
        rule = "fixed by the scene"
    return {
        "radiated share q": f"{scene.sound.q:g}",
        "distance": f"{scene.sound.distance_m:g} m, spherical spreading",
        "impedance of air": f"{RHO_C:g} Pa s/m (20 °C)",
        "sound pressure per intensity": pressure,
        "rule of that factor": rule,
    }


def _bodies(run: Run) -> dict[str, str]:
    """Return the assumptions about the vibration; none without dynamics."""
    motion = run.numbers.motion
    if motion is None:
        return {}
    scene = run.scene
    plate = scene.plate
    grams = rounded(1e3 * motion.ball_mass_kg, 3)
    ball = f"sphere of {grams} g ({scene.sphere.density_kg_m3:g} kg/m³)"
    quality = motion.resonance_q
    damping = "undamped" if quality is None else f"Q {rounded(quality, 3)}"
    loss = plate.loss_factor
    return {
        "vibrating bodies": f"{ball}, {_bending(scene, motion)}, {plate.density_kg_m3:g} kg/m³",
        "resonance of the sphere on its contact": (
            f"{rounded(motion.resonance_hz, 4)} Hz, {damping}"
        ),
        "force law": _force_law(motion),
        "loss factor of bending waves": NOTHING if loss is None else loss_text(loss),
    }


def _force_law(motion: MotionNumbers) -> str:
    """Describe the loads of the force law, and its error between them."""
    if motion.force_law_min_n is None or motion.force_law_max_n is None:
        return NOTHING
    least = rounded(motion.force_law_min_n, 3)
    most = rounded(motion.force_law_max_n, 3)
    law = f"{motion.force_law_loads} loads from {least} to {most} N"
    if motion.force_law_error_n is not None:
        law += f", rms error {rounded(motion.force_law_error_n)} N between them"
    return law


def _bending(scene: Scene, motion: MotionNumbers) -> str:
    """Describe the bending of the plate."""
    plate = scene.plate
    if plate.thickness_mm is None:
        return "half-space"
    size = "infinite plate"
    if plate.edges_mm is not None:
        length, width = plate.edges_mm
        size = f"plate of {length:g} mm x {width:g} mm"
    words = f"{size} {plate.thickness_mm:g} mm thick"
    if motion.critical_hz is not None:
        words += f", coincidence at {rounded(motion.critical_hz, 4)} Hz"
    return words


def _contact(run: Run) -> dict[str, str]:
    """Return the assumptions about bodies, motion and solver."""
    scene = run.scene
    plate = scene.plate
    sphere = scene.sphere
    radius = f"{sphere.radius_mm:g}"
    if sphere.radius_across_mm:
        radius += f" x {sphere.radius_across_mm:g}"
    elastic = "rigid"
    if sphere.youngs_modulus_gpa and sphere.poissons_ratio is not None:
        elastic = _elastic(sphere.youngs_modulus_gpa, sphere.poissons_ratio)
    hardness = "no hardness: purely elastic"
    if math.isfinite(plate.cap_gpa):
        hardness = f"hardness {plate.cap_gpa:g} GPa"
    memory = "without memory"
    if scene.is_permanent:
        memory = f"permanent indentation, {scene.passes} passes"
    bends = _elastic(plate.youngs_modulus_gpa, plate.poissons_ratio)
    load = "the weight of the sphere" if scene.rolling.load_n == WEIGHT else "constant"
    slowest = rounded(scene.motion.slowest(run.sound.duration), 4)
    fastest = rounded(scene.motion.fastest(run.sound.duration), 4)
    speeds = slowest if slowest == fastest else f"{slowest} to {fastest}"
    return {
        "load": f"{rounded(scene.load, 6)} N, {load}",
        "speed": f"{speeds} m/s",
        "sphere": f"R {radius} mm, {_of(sphere.material)}{elastic}",
        "plate": f"{_of(plate.material)}{bends}, {hardness}, {memory}",
        "surface": surface_words(scene),
        "spacing and step": f"{scene.spacing * 1e6:g} µm, {_step(scene)}",
        "solver": (
            f"tolerance {rounded(scene.tolerance, 6)}, {scene.numerics.edges} edges, "
            f"{scene.numerics.precision} precision"
        ),
    }


def _step(scene: Scene) -> str:
    """Write the length of the steps, and the lowest speed that they allow where auto chose them."""
    text = f"{scene.step * 1e6:g} µm"
    choice = scene.step_choice
    if choice is None or not choice.lowest:
        return text
    return f"{text} (auto, which hold hearing from {rounded_up(choice.lowest)} m/s on)"


def _elastic(youngs_modulus_gpa: float, poissons_ratio: float) -> str:
    """Write the elastic constants of a body."""
    return f"{youngs_modulus_gpa:g} GPa, Poisson's ratio {poissons_ratio:g}"


def _of(material: str | None) -> str:
    """Return the beginning of the words for a body of a material."""
    return f"{material}, " if material else ""


def surface_words(scene: Scene) -> str:
    """Describe the surface of a scene."""
    text = _words(scene.surface)
    ball = scene.sphere.surface
    if ball is None:
        return text
    turn_mm = rounded(scene.track.turn_nodes * scene.spacing * 1e3, 6)
    turns = rounded(scene.track.turns, 3)
    return f"{text}; the sphere: {_words(ball)}, once round in {turn_mm} mm, {turns} turns rolled"


def _words(surface: surfaces.Surface | surfaces.BallSurface) -> str:
    """Describe the surface of plate or sphere."""
    text = _kind_words(surface)
    if isinstance(surface, surfaces.RoundSurface) and surface.waviness:
        waves = [f"{order} ({height:g} µm)" for order, height in surface.waviness.items()]
        text += f", waves of order {', '.join(waves)}"
    faults = sum(fault.count or 1 for fault in surface.faults or ())
    if faults == 1:
        text += ", 1 fault"
    elif faults > 1:
        text += f", {faults} faults"
    return text


def _kind_words(surface: surfaces.Surface | surfaces.BallSurface) -> str:
    """Describe a surface without waviness and faults."""
    if isinstance(surface, surfaces.HeightFile | surfaces.BallHeightFile):
        text = f"heights of {printable(surface.path)}"
        if isinstance(surface, surfaces.HeightFile) and surface.width_um is not None:
            text += ", a profile that is the same all across"
        return text
    if isinstance(surface, surfaces.GradedBall):
        deviation_um = surfaces.GRADES[surface.grade].deviation_um
        deviation = f"{deviation_um:g} µm from spherical form"
        return f"of grade {surface.grade}, {deviation}, {surface.law.words}"
    if surface.law is None:
        return "smooth"
    return f"{_of(getattr(surface, 'finish', None))}{surface.law.words}"
