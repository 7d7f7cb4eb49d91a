// Slow parts of the instrument, for a worker: law table, chain, modes and impulse responses of a run
// at settings, all as plain numbers and arrays.

import { chainAt, loadOf } from "./chain.js";
import { DECIMATION_DELAY } from "./vibration.js";
import { ForceLaw, lawTable } from "./law.js";
import { stepsPerSample } from "./motion.js";
import { RATE } from "./rate.js";
import { isPlayable, plateNumbers } from "./effort.js";
import { costOfModes, EdgedPlate } from "./plate.js";
import { ballPressure, halfSpacePressure, platePressure } from "./radiation.js";
import { prepareRelease } from "./release.js";
import { computedModes, ComputedPlate } from "./ritz.js";
import { impulseResponses } from "./response.js";

const LIVE_MODES = 100; // that move in real time
let latestPlate = { key: "", run: "", plate: null };

/** Return the slow parts of a run at settings; `most` modes move. */
export function prepare(run, settings, most = LIVE_MODES) {
  if (run.kind === "release") return prepareRelease(run);
  const table = lawTable(run.law);
  const law = new ForceLaw(table);
  const load = loadOf(run, settings);
  const plate = edgedPlate(run, settings);
  const { lead, responses } = impulseResponses(...listenersOf(run, settings, plate));
  const modes = plate && plate.moving(run.contact, most);
  const chain = chainAt(run, settings, law, modes);
  const of = plate ? plate.modes.length : 0;
  const cost = () => costOfModes(law, { chain, load, speed: settings.speed }, responses[0], [modes, plate.moving(run.contact)]);
  return {
    kind: "vibration",
    table,
    load,
    chain,
    steps: stepsPerSample(run, settings, chain),
    start: law.start,
    length: law.length,
    rate: RATE,
    delay: lead + DECIMATION_DELAY,
    responses,
    kept: { modes: Math.min(most, of), of, costDb: of > most ? cost() : 0 },
  };
}

/** Return the plate with edges at settings, the latest again if it is the same; null without edges. */
function edgedPlate(run, settings) {
  const { thickness, length, lossFactor } = settings;
  if (!thickness || !length) return null;
  const { massPerArea, bendingStiffness, width, area, count } = plateNumbers(run.fixed, settings);
  if (!isPlayable(run, settings)) {
    const size = `${area.toPrecision(2)} m2 with about ${Math.round(count)} modes`;
    throw new Error(`This plate (${size}) takes too long to prepare, or has more modes than the page holds: choose a smaller or a thicker one.`);
  }
  const numbers = { massPerArea, bendingStiffness, lossFactor, lossCurve: run.fixed.lossCurve, length, width };
  const key = JSON.stringify(numbers);
  if (latestPlate.key !== key || latestPlate.run !== run.label) {
    const plate = run.modes ? new ComputedPlate({ ...numbers, computed: computedModes(run.modes) }) : new EdgedPlate(numbers);
    latestPlate = { key, run: run.label, plate };
  }
  return latestPlate.plate;
}

/** Return bodies and radiation for each listener, and the path [m] from the contact to the first. */
function listenersOf(run, settings, plate) {
  const { distance, plateDensity, ballDensity, thickness } = settings;
  const { radius, compression } = run.fixed;
  const ball = (way, cosine, further) => (run.hearBall && cosine > 0 ? [ballPressure(radius, ballDensity, way, cosine, further)] : []);
  if (!plate) {
    const ground = thickness ? platePressure(plateDensity * thickness, distance) : halfSpacePressure(plateDensity, compression, distance);
    return [[{ bodies: [ground, ...ball(distance, 1, 0)] }], distance];
  }
  const away = (point, place) => Math.hypot(...place.map((value, i) => value - point[i]));
  const factor = distance / run.settings.distance;
  const places = run.listeners.map((place) => place.map((value, i) => run.middle[i] + factor * (value - run.middle[i])));
  const path = away([...run.contact, 0], places[0]);
  const listeners = places.map((place) => {
    const way = away(run.middle, place);
    return { bodies: ball(way, place[2] / way, way - path), radiation: plate.radiation(run.contact, place) };
  });
  return [listeners, path];
}
