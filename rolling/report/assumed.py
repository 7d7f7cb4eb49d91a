"""The assumptions behind the numbers of a run: sound, bodies, contact and surface, in words."""

import math

from acoustics.numbers import bracketed, rounded
from acoustics.radiation import RHO_C
from acoustics.texts import printable
from rolling.report.text import NOTHING
from rolling.results.run_result import Run
from rolling.scene import surfaces
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT


def assumptions(run: Run) -> dict[str, str]:
    """Return the assumptions of a run by their names."""
    sound = run.sound
    ends = "closes on itself" if sound.loops else sound.ends
    slower = "" if sound.constant_speed else " at the maximum speed, less while it is slower"
    khz = rounded(min(sound.highest, sound.sample_rate / 2) / 1e3, 4)
    record = {"record": f"{rounded(sound.duration, 4)} s, {ends}"}
    record["resolved up to"] = f"{khz} kHz{slower}"
    return _source(run) | record | _bodies(run) | _contact(run)


def _source(run: Run) -> dict[str, str]:
    """Return the assumptions about the source of the sound and its conversion."""
    scene, factor = run.scene, run.sound.factor
    if run.sound.source == "vibration":
        ball = "plate and sphere" if scene.sound.ball else "plate"
        if scene.plate.edges_mm is not None:
            words = (bracketed(place["at_mm"]) for place in run.summary["listeners"])
            return {
                "source": f"vibration of {ball}, the plate in an infinite rigid baffle",
                "listener [mm] from the corner of the plate": "; ".join(words),
                "distance from the contact to the listener": f"{scene.listener_distance_m:.3g} m",
            }
        return {
            "source": f"vibration of {ball}, the pressure on the axis through the contact",
            "distance": f"{scene.sound.distance_m:g} m",
        }
    pressure = f"{rounded(factor, 4)} Pa per W/m²" if factor else "none: silent"
    rule = "mean p² over the impedance is the rms of the intensity's fluctuation"
    if scene.sound.gain_pa_per_w_m2 is not None:
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
    if run.vibration is None:
        return {}
    scene, plate, summary = run.scene, run.scene.plate, run.summary
    bending = "half-space"
    if plate.thickness_mm is not None:
        critical = rounded(summary["critical_hz"], 4)
        size = "infinite plate" if plate.edges_mm is None else "plate of {:g} mm x {:g} mm"
        size = size.format(*plate.edges_mm or ())
        bending = f"{size} {plate.thickness_mm:g} mm thick, coincidence at {critical} Hz"
    quality, error = summary["resonance_q"], summary["force_law_error_n"]
    damping = "undamped" if quality is None else f"Q {rounded(quality, 3)}"
    loads = rounded(summary["force_law_min_n"], 3), rounded(summary["force_law_max_n"], 3)
    law = f"{summary['force_law_loads']} loads from {loads[0]} to {loads[1]} N"
    if error is not None:
        law += f", rms error {rounded(error)} N between them"
    grams = rounded(1e3 * summary["ball_mass_kg"], 3)
    bodies = f"sphere of {grams} g ({scene.sphere.density_kg_m3:g} kg/m³), "
    bodies += f"{bending}, {plate.density_kg_m3:g} kg/m³"
    loss = plate.loss_factor
    return {
        "vibrating bodies": bodies,
        "resonance of the sphere on its contact": (
            f"{rounded(summary['resonance_hz'], 4)} Hz, {damping}"
        ),
        "force law": law,
        "loss factor of bending waves": NOTHING if loss is None else f"{loss:g}",
    }


def _contact(run: Run) -> dict[str, str]:
    """Return the assumptions about bodies, motion and solver."""
    scene, sound = run.scene, run.sound
    plate, sphere, duration = scene.plate, scene.sphere, sound.duration
    elastic, hardness, memory = "rigid", "no hardness: purely elastic", "without memory"
    if sphere.youngs_modulus_gpa and sphere.poissons_ratio is not None:
        elastic = _elastic(sphere.youngs_modulus_gpa, sphere.poissons_ratio)
    if math.isfinite(plate.cap_gpa):
        hardness = f"hardness {plate.cap_gpa:g} GPa"
    if scene.is_permanent:
        memory = f"permanent indentation, {scene.passes} passes"
    bends = _elastic(plate.youngs_modulus_gpa, plate.poissons_ratio)
    load = "the weight of the sphere" if scene.rolling.load_n == WEIGHT else "constant"
    across = f" x {sphere.radius_across_mm:g}" if sphere.radius_across_mm else ""
    ends = scene.motion.slowest(duration), scene.motion.fastest(duration)
    speeds = " to ".join(dict.fromkeys(rounded(speed, 4) for speed in ends))
    return {
        "load": f"{rounded(scene.load, 6)} N, {load}",
        "speed": f"{speeds} m/s",
        "sphere": f"R {sphere.radius_mm:g}{across} mm, {_of(sphere.material)}{elastic}",
        "plate": f"{_of(plate.material)}{bends}, {hardness}, {memory}",
        "surface": surface_words(scene),
        "spacing and step": f"{scene.spacing * 1e6:g} µm, {scene.step * 1e6:g} µm",
        "solver": (
            f"tolerance {rounded(scene.tolerance, 6)}, {scene.numerics.edges} edges, "
            f"{scene.numerics.precision} precision"
        ),
    }


def _elastic(youngs_modulus_gpa: float, poissons_ratio: float) -> str:
    """Write the elastic constants of a body."""
    return f"{youngs_modulus_gpa:g} GPa, Poisson's ratio {poissons_ratio:g}"


def _of(material: str | None) -> str:
    """Return the beginning of the words for a body of a material."""
    return f"{material}, " if material else ""


def surface_words(scene: Scene) -> str:
    """Describe the surface of a scene."""
    ball = scene.sphere.surface
    if ball is None:
        return _words(scene.surface)
    turn = scene.track.turn_nodes * scene.spacing
    rolled = f"{rounded(turn * 1e3, 6)} mm, {rounded(scene.track.turns, 3)} turns rolled"
    return f"{_words(scene.surface)}; the sphere: {_words(ball)}, once round in {rolled}"


def _words(surface: surfaces.Surface | surfaces.BallSurface) -> str:
    """Describe the surface of plate or sphere."""
    faults = sum(fault.count or 1 for fault in surface.faults or ())
    text = _kind_words(surface)
    if isinstance(surface, surfaces.RoundSurface) and surface.waviness:
        orders = ", ".join(f"{k} ({a:g} µm)" for k, a in surface.waviness.items())
        text += f", waves of order {orders}"
    return f"{text}, {faults} fault{'s' * (faults > 1)}" if faults else text


def _kind_words(surface: surfaces.Surface | surfaces.BallSurface) -> str:
    """Describe a surface without waviness and faults."""
    if isinstance(surface, surfaces.HeightFile | surfaces.BallHeightFile):
        profile = ", a profile that is the same all across"
        laid = isinstance(surface, surfaces.HeightFile) and surface.width_um is not None
        return f"heights of {printable(surface.path)}{profile * laid}"
    if isinstance(surface, surfaces.GradedBall):
        deviation = f"{surfaces.GRADES[surface.grade].deviation_um:g} µm from spherical form"
        return f"of grade {surface.grade}, {deviation}, {surface.law.words}"
    finish = _of(getattr(surface, "finish", None))
    return "smooth" if surface.law is None else f"{finish}{surface.law.words}"
