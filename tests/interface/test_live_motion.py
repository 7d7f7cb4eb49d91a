"""The engine of the page moves ball and plate as the program does, and reads its data of a run."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from live_engine import EDGES, force_law, node, roughness, scene, vibration, vibration_data
from report_runs import runs_of

from acoustics.arrays import Array
from acoustics.bands import EDGES_HZ
from rolling.dynamics import drop
from rolling.dynamics.bodies import Modes
from rolling.dynamics.force_law import ForceLaw, law_table
from rolling.dynamics.motion import BodyMotion, Stepping, move
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.in_si.physics_of_scene import bodies_of
from rolling.report import leading_numbers, live
from rolling.report.assumed import assumptions
from rolling.scene.scene import Scene

HALF_SPACE = {"plate.thickness_mm": None, "plate.loss_factor": None}
# Changes of a scene, and settings of the engine by which its page reaches them.
SETTINGS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "own": ({}, {}),
    "fast": ({"rolling.speed_m_s": 0.25}, {"speed": 0.25}),
    "thin": ({"plate.thickness_mm": 1}, {"thickness": 1e-3}),
    "light": ({"sphere.density_kg_m3": 2500}, {"ballDensity": 2500}),
    "damped": ({"plate.contact_loss_factor": 0.1}, {"contactLossFactor": 0.1}),
    "half-space": (HALF_SPACE, {"thickness": None}),
    "edges": (EDGES, {}),
    "small": (
        EDGES | {"plate.length_mm": 200, "plate.loss_factor": 0.05},
        {},
    ),
}
MOVE = """
  const { run, cases } = data;
  const table = law.lawTable(run.law);
  done(cases.map(({ settings, modes, laps, samples, height }) => {
    const places = new law.ForceLaw(table);
    const chosen = { ...run.settings, ...settings };
    const bodies = chain.chainAt(run, chosen, places, modes);
    const steps = motion.stepsPerSample(run, chosen, bodies);
    const lap = places.length / chosen.speed;
    const count = samples ? samples * steps : Math.round(lap * 48000 * steps);
    const step = samples ? 1 / (48000 * steps) : lap / count;
    const ball = new motion.Motion(places, bodies, chain.loadOf(run, chosen), step);
    if (height !== undefined) ball.release(height);
    const force = new Float64Array(count);
    for (let taken = 0; taken < laps * count; taken++) {
      force[taken % count] = ball.advance(places.start + (taken + 1) * step * chosen.speed);
    }
    return { force, step, impacts: ball.impacts };
  }));
"""


def modes_data(modes: Modes | None) -> dict[str, list[float]] | None:
    """Return modes as the engine takes them, with their shapes at the contact."""
    if modes is None:
        return None
    reach = modes.reach * np.sqrt(modes.weight)
    numbers = {"frequency": modes.angular_frequency, "damping": modes.damping_ratio, "reach": reach}
    return {name: values.tolist() for name, values in numbers.items()}


def moved(begun: Scene, law: ForceLaw, cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the motions of the engine over a law at settings."""
    run = vibration_data(begun, law, vibration(begun, law))
    return node(MOVE, {"run": run, "cases": [{"laps": 1} | case for case in cases]})


def lines(force: Array, first_s: float, step_s: float) -> Array:
    """Return the lines of a closed lap of force, as phasors from the time 0, but for its mean."""
    frequency = np.fft.rfftfreq(len(force), step_s)
    return (np.fft.rfft(force) / len(force) * np.exp(-2j * np.pi * frequency * first_s))[1:]


def compare(reference: BodyMotion, moved: dict[str, Any]) -> tuple[float, float, float]:
    """Return error, difference of the level and of the worst third octave [dB], within hearing."""
    step = moved["step"]
    force = np.array(moved["force"])
    lap = len(force) * step
    own = lines(reference.force_n, reference.time_step_s / 2, reference.time_step_s)
    got = lines(force, step, step)
    count = min(len(own), len(got), int(20e3 * lap))
    own = own[:count]
    got = got[:count]
    square = np.square(np.abs([own, got]))
    frequency = np.arange(1, count + 1) / lap
    bands = [
        square[:, (frequency > a) & (frequency <= b)].sum(axis=1) for a, b in pairwise(EDGES_HZ)
    ]
    heard = [band for band in bands if band[0] > 1e-6 * square[0].sum()]
    whole = square.sum(axis=1)
    error = np.sum(np.square(np.abs(got - own))) / whole[0]
    decibels = 10 * np.log10([error, whole[1] / whole[0], *(band[1] / band[0] for band in heard)])
    return decibels[0], abs(decibels[1]), np.abs(decibels[2:]).max()


@pytest.mark.parametrize("name", SETTINGS)
def test_force_over_a_lap(name: str) -> None:
    """The program at 240 steps in a period: -46 dB on 1 mm, -50 dB and less elsewhere."""
    changes, settings = SETTINGS[name]
    begun = scene((changes | {"rolling.distance_mm": 2}) if "plate.length_mm" in changes else {})
    law = force_law(begun)
    changed = begun.with_(changes)
    chain = bodies_of(changed).chain_over(law)
    speed = changed.motion.fastest(1)
    reference = move(law, chain, changed.load, speed, stepping=Stepping(per_period=240))
    assert law.period_m is not None and reference.flight_share == 0
    laps = min(200, 3 + int(14 * chain.decay_s * speed / law.period_m))
    case = {"settings": settings, "modes": modes_data(chain.modes)}
    case["laps"] = 40 if chain.modes else laps
    error, level, band = compare(reference, moved(begun, law, [case])[0])
    assert error < -45 and level < 0.1 and band < 0.3
    if name == "own":  # the record of a run takes 40 steps in a period
        own = motion_of_ball(bodies_of(changed), changed.travel, law)
        error, level, band = compare(own, moved(begun, law, [case])[0])
        assert error < -40 and level < 0.1 and band < 0.3


def impacts(force: Array, step: float) -> Array:
    """Return time [s] and impulse [N s] of each whole impact, (n, 2)."""
    edges = np.diff((force > 0).astype(int))
    starts = np.flatnonzero(edges > 0) + 1
    ends = np.flatnonzero(edges < 0) + 1
    return np.array(
        [(a * step, force[a:b].sum() * step) for a, b in zip(starts, ends, strict=False)]
    )


@pytest.mark.parametrize("changes", [{}, EDGES])
def test_impacts_of_a_fall(changes: dict[str, Any]) -> None:
    """The program at a third of its steps: times and impulses of five impacts within 1 %."""
    fall = {"rolling.load_n": "weight", "rolling.drop_mm": 1, "rolling.speed_m_s": 0.02}
    begun = scene(changes | fall | {"rolling.distance_mm": 3, "plate.thickness_mm": 10})
    law = force_law(begun)
    chain = bodies_of(begun).chain_over(law)
    step = drop.time_step_s(bodies_of(begun), law, chain, 0.02) / 3
    reference = motion_of_ball(bodies_of(begun), begun.travel, law, step)
    case = {"modes": modes_data(chain.modes), "samples": round(0.15 * 48000), "height": 1e-3}
    engine = moved(begun, law, [case])[0]
    own = impacts(reference.force_n, reference.time_step_s)[:5]
    got = impacts(np.array(engine["force"]), engine["step"])[:5]
    assert len(own) == 5 and got == pytest.approx(own, rel=0.01)
    assert engine["impacts"] == pytest.approx(reference.impacts, abs=2)


def test_statistics_of_a_ball_that_bounces() -> None:
    """Chaotic flights: rms within 0.5 dB and flown time within a fifth of the program's."""
    begun = scene({"rolling.speed_m_s": 1, "plate.thickness_mm": 10, "rolling.load_n": 1})
    rough = force_law(begun)
    law = replace(
        rough, approach_m=rough.approach_m + 3 * (rough.approach_m[1] - rough.approach_m[1].mean())
    )
    chain = bodies_of(begun).chain_over(law)
    seconds = 1.0
    reference = move(law, chain, begun.load, 1.0, seconds)
    engine = moved(begun, law, [{"samples": round(48000 * seconds)}])[0]
    force = np.array(engine["force"])
    assert 0.03 < reference.flight_share < 0.6
    assert 20 * np.log10(force.std() / reference.force_n.std()) == pytest.approx(0, abs=0.5)
    assert np.mean(force == 0) == pytest.approx(reference.flight_share, rel=0.2)
    assert engine["impacts"] == pytest.approx(reference.impacts, rel=0.2)


FUZZ = """
  let seed = data;
  const random = () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const between = (a, b) => a * (b / a) ** random();
  const faults = [];
  for (let trial = 0; trial < 40; trial++) {
    const [radius, modulus] = [between(1e-3, 0.02), between(1e9, 3e11)];
    const settings = { ballDensity: between(900, 19300), speed: between(1e-3, 3), dropHeight: 0 };
    const run = { fixed: { radius, impactRadius: radius, modulus, shortestWave: 4e-6 } };
    const mass = chain.ballMass(run, settings);
    settings.load = mass * 9.81 * (trial % 2 ? 1 : between(1, 1e4));
    settings.dropHeight = (between(1e-6, 1) * mass) / (2 * settings.load);
    const smooth = trial % 3 === 0;
    const s = settings.load ** (2 / 3);
    const hertz = (9 / (16 * radius * modulus ** 2)) ** (1 / 3);
    const rough = smooth ? 0 : between(1e-3, 1e2) * hertz * s;
    const values = Float64Array.from({ length: 400 }, (_, i) =>
      i % 4 ? hertz * (smooth ? 1 : 0.5 + random()) : rough * (random() - 0.5));
    const places = new law.ForceLaw({ start: 0, spacing: 2e-6, breaks: [0, s / 2, 2 * s], values,
      slopes: new Float64Array(400) });
    const k = places.meanStiffness(settings.load);
    const [thickness, density] = [between(5e-4, 0.05), between(900, 19300)];
    const young = modulus * between(1, 10);
    const mobility = chain.plateMobility(young, 0.3, density, thickness);
    const tau = trial % 2 ? 0 : between(1e-3, 0.3) * Math.sqrt(mass / k);
    const sides = [0, 1].map(() => Math.max(between(0.03, 0.5), 20 * thickness));
    let bodies = chain.chainOf(mass, { mobility }, k, tau);
    if (trial % 4 > 1) {
      const rectangle = new plate.EdgedPlate({
        massPerArea: density * thickness, bendingStiffness: (young * thickness ** 3) / 10.92,
        lossFactor: between(5e-4, 0.3), length: sides[0], width: sides[1],
      });
      const modes = rectangle.moving(sides.map((side) => side * random()));
      if (modes.frequency.length < 100) bodies = chain.chainOf(mass, modes, k, tau);
    }
    const step = 1 / (48000 * motion.stepsPerSample(run, settings, bodies));
    const ball = new motion.Motion(places, bodies, settings.load, step);
    ball.release(settings.dropHeight);
    let [highest, met, position] = [0, false, 0];
    for (let i = 0; i < 5000; i++) {
      position += settings.speed * step * (i % 1000 < 500 ? 1 : -1.5);
      const force = ball.advance(position);
      if (!(force >= 0 && Number.isFinite(force + ball.approach))) faults.push([trial, force]);
      met = met || force > 0;
      if (met) highest = Math.max(highest, ball.height);
      if (faults.length) break;
    }
    highest /= settings.dropHeight;
    if (smooth && highest > 1.03) faults.push([trial, highest]);
  }
  done(faults);
"""


@pytest.mark.parametrize("seed", [1, 2])
def test_random_bodies(seed: int) -> None:
    """Forces are numbers, not negative, and a ball does not rise above its fall by 3 %."""
    assert node(FUZZ, seed) == []


# ---- data of a run


def test_runs_are_data() -> None:
    """Runs of the page with and without vibration, silent, open, braking, or with memory."""
    kinds = set()
    for run in runs_of("one", "smooth", "flying", "braking", "memory"):
        data = live.live_of(run)
        assert data is not None
        json.dumps(data, allow_nan=False)
        kinds.add(data["kind"])
        changing = not run.scene.motion.is_constant(run.sound.duration)
        assert changing == any("speed of the run changes" in text for text in data["remarks"])
        for name, (least, most) in data["limits"].items():
            assert least <= (data["settings"][name] or 0.0) <= most, name
    assert kinds == {"vibration", "release"}


def test_the_distance_is_that_of_the_listener() -> None:
    """It is hypot(31.6, 7, 250) = 252.1 mm, and the place of a release is sound.distance_m."""
    (placed,) = runs_of("placed")
    data = live.live_of(placed)
    assert data is not None
    assert data["settings"]["distance"] == pytest.approx(0.25209, rel=1e-4)
    assert data["limits"]["distance"][0] <= data["settings"]["distance"]
    assert "0.252 m from the contact" in leading_numbers.units([placed])
    assert "0.252 m" in assumptions(placed)["distance from the contact to the listener"]
    released = placed.scene.with_({"sound.source": "release"})
    assert released.listener_distance_m == 1.0


@pytest.mark.parametrize(("count", "share"), [(24_000, 1.0), (60_000, 0.5)])
def test_a_long_law_fits(count: int, share: float) -> None:
    """A law whose rows would be too coarse is kept in part; the force is off by 0.1 % at most."""
    rng = np.random.default_rng(1)
    loads = np.array([14.0, 20.0, 28.0])
    hertz = np.cbrt(loads**2) * 1e-7
    x = 2e-6 * np.arange(count)
    lift = roughness(count, 1e-8, rng)
    slope = 1 + roughness(count, 0.02, rng)
    approach = hertz[1] + lift + (hertz - hertz[1])[:, None] * slope
    law = ForceLaw(x, loads, approach, period_m=2e-6 * count, smooth_slope=1e-7)
    stored = live.stored_law(law, 20.0)
    assert sum(len(column["base64"]) for column in stored["columns"]) <= live.LARGEST
    table = node("done(law.lawTable(data))", stored)
    values = np.reshape(table["values"], (-1, 5))
    rows = np.vstack((values, values[:1]))
    decoded = law_table(table["start"], table["spacing"], True, law.table.breaks, rows)
    # Its cubic splines are the program's, to rounding.
    assert np.reshape(table["slopes"], (-1, 5)) / table["spacing"] == pytest.approx(
        decoded.slopes[:-1], rel=1e-9, abs=1e-9 * np.abs(decoded.slopes).max()
    )
    assert live.law_error(law, 20.0, decoded, stored["seam"]) < live.FAITHFUL
    assert stored["part"] == share
