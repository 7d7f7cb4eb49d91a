"""The assumptions behind the numbers of a run: sound, bodies, contact and surface, in words."""

from __future__ import annotations

from acoustics.radiation import RHO_C
from rolling.check import findings, height_files, validity
from rolling.report.numbers import NOTHING, significant
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian, HeightFile
from rolling.simulation.labels import printable
from rolling.simulation.run_result import RunResult
from rolling.surface.scene_surface import scene_surface


def of_run(run: RunResult) -> dict[str, str]:
    """Return the assumptions of a run by their names."""
    return _assumed_sound(run) | _assumed_bodies(run) | _assumed_contact(run)


def _assumed_sound(run: RunResult) -> dict[str, str]:
    """Return the assumptions between release and listener, by quantity."""
    sound = run.sound
    return _assumed_source(run) | {
        "record": f"{sound.duration:.4g} s"
        + f", {'closes on itself' if sound.loops else sound.ends}",
        "resolved up to": f"{min(sound.highest, sound.sample_rate / 2) / 1e3:.4g} kHz"
        + ("" if sound.constant_speed else " at the maximum speed, less while it is slower"),
    }


def _assumed_source(run: RunResult) -> dict[str, str]:
    """Return the assumptions about the source of the sound and its conversion, by quantity."""
    scene, factor = run.scene, run.sound.factor
    if run.sound.source == "vibration":
        ball = "plate and sphere" if scene.sound.ball else "plate"
        return {
            "source": f"vibration of {ball}, the pressure on the axis through the contact",
            "distance": f"{scene.sound.distance_m:g} m",
        }
    fixed = scene.sound.gain_pa_per_w_m2 is not None
    return {
        "radiated share q": f"{scene.sound.q:g}",
        "distance": f"{scene.sound.distance_m:g} m, spherical spreading",
        "impedance of air": f"{RHO_C:g} Pa s/m (20 °C)",
        "sound pressure per intensity": f"{significant(factor)} Pa per W/m²"
        if factor
        else "none: silent",
        "rule of that factor": "fixed by the scene"
        if fixed
        else "mean p² over the impedance is the rms of the intensity's fluctuation",
    }


def _assumed_bodies(run: RunResult) -> dict[str, str]:
    """Return the assumptions about the vibration, by quantity; none without dynamics."""
    if run.vibration is None:
        return {}
    scene, plate, summary = run.scene, run.scene.plate, run.summary
    bending = (
        "half-space"
        if plate.thickness_mm is None
        else f"infinite plate {plate.thickness_mm:g} mm thick, coincidence at"
        f" {significant(summary['critical_hz'])} Hz"
    )
    quality = summary["resonance_q"]
    damping = "undamped" if quality is None else f"Q {quality:.3g}"
    error = summary["force_law_error_n"]
    judged = "" if error is None else f", off by {error:.2g} N rms between them"
    return {
        "vibrating bodies": f"sphere of {1e3 * summary['ball_mass_kg']:.3g} g"
        f" ({scene.sphere.density_kg_m3:g} kg/m³), {bending}, {plate.density_kg_m3:g} kg/m³",
        "resonance of the sphere on its contact": f"{significant(summary['resonance_hz'])} Hz,"
        f" {damping}",
        "force law": f"{summary['force_law_loads']} loads from {summary['force_law_min_n']:.3g} to"
        f" {summary['force_law_max_n']:.3g} N{judged}",
        "loss factor of bending waves": NOTHING
        if plate.loss_factor is None
        else f"{plate.loss_factor:g}",
    }


def _assumed_contact(run: RunResult) -> dict[str, str]:
    """Return the assumptions about bodies, motion and solver, by quantity."""
    scene, sound = run.scene, run.sound
    plate, sphere = scene.plate, scene.sphere
    elastic = (
        f", {sphere.youngs_modulus_gpa:g} GPa, Poisson's ratio {sphere.poissons_ratio:g}"
        if sphere.youngs_modulus_gpa
        else ""
    )
    hardness = (
        f"hardness {plate.hardness_gpa:g} GPa"
        if plate.hardness_gpa
        else "no hardness: purely elastic"
    )
    slowest, fastest = (
        f"{v:.4g}"
        for v in (scene.motion.slowest(sound.duration), scene.motion.fastest(sound.duration))
    )
    speed = f"{fastest} m/s" if sound.constant_speed else f"{slowest} to {fastest} m/s"
    return {
        "load": f"{scene.load:g} N, constant",
        "speed": speed,
        "sphere": f"R {sphere.radius_mm:g} mm" + (elastic or ", rigid"),
        "plate": f"{plate.youngs_modulus_gpa:g} GPa, Poisson's ratio {plate.poissons_ratio:g}, "
        f"{hardness}, without memory",
        "surface": surface_words(scene),
        "spacing and step": f"{scene.spacing * 1e6:g} µm, {scene.step * 1e6:g} µm",
        "half-space": _half_space(scene),
        "solver": f"tolerance {scene.tolerance:g}{_chosen(run)}, {scene.numerics.edges} edges, "
        f"{scene.numerics.precision} precision",
        "release of a node": {
            "mean": "mean pressure of a step's ends",
            "left_end": "pressure at a step's beginning (the article's)",
        }[scene.recovery.rule],
    }


def _chosen(run: RunResult) -> str:
    """Write the choice of the tolerance in brackets; nothing where the scene gave a number."""
    trial = run.result.trial
    if trial is None:
        return ""
    if trial.grid_signal_db is None or trial.solver_signal_db is None:
        return f" (chosen without trial: {trial.reason})"
    return (
        f" (chosen by a trial of {trial.stretches} stretches: grid {trial.grid_signal_db:.0f} dB,"
        f" solver {trial.solver_signal_db:.0f} dB of the fluctuation)"
    )


def _half_space(scene: Scene) -> str:
    """Compare slope and contact radius with the limits of a half-space."""
    values = {finding.key: finding.value for finding in findings.findings(scene)}
    return (
        f"rms slope {values['slope']} (holds up to {validity.MAX_SLOPE:g}),"
        f" contact radius over the sphere's {values['contact_radius']} (up to "
        f"{validity.MAX_CONTACT:g})"
    )


def surface_words(scene: Scene) -> str:
    """Describe the surface of a scene."""
    s = scene.surface
    if isinstance(s, Gaussian):
        across = s.correlation_length_across_um
        length = f"{s.correlation_length_um:g} µm" + (
            f" along, {across:g} µm across" if across else ""
        )
        law = s.autocorrelation.replace("_", " ")
        return (
            f"random, Ra {s.roughness_ra_um:g} µm, correlation length {length} ({law}), "
            f"seed {s.seed}"
        )
    if not isinstance(s, HeightFile):
        return "smooth"
    levelling = scene_surface(scene).levelling
    tilt = f", {height_files.tilt_text(levelling)}" if levelling and any(levelling.taken) else ""
    profile = "" if s.width_um is None else ", a profile that is the same all across"
    return f"heights of {printable(s.path)}{profile}{tilt}"
