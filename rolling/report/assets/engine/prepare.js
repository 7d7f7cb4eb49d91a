// Slow parts of the instrument, for a worker: law table, chain, modes and impulse responses of a run
// at settings, all as plain numbers and arrays.

import { chainAt, loadOf } from "./chain.js";
import { DECIMATION_DELAY } from "./decimate.js";
import { chosenModes } from "./kept.js";
import { ForceLaw, lawTable } from "./law.js";
import { RATE, stepsPerSample } from "./motion.js";
import { EdgedPlate, MODES_HZ } from "./plate.js";
import { ballPressure, compressionSpeed, halfSpacePressure, platePressure } from "./radiation.js";
import { prepareRelease } from "./release.js";
import { impulseResponses } from "./response.js";

export const LIVE_MODES = 100; // that move in real time
const MOST_WORK = 18; // area^1.5 [m3] times the root of the modes: 5 s
let latestPlate = { key: "", plate: null };

/** Return the slow parts of a run at settings; `most` modes move. */
export function prepare(run, settings, most = LIVE_MODES) {
  if (run.kind === "release") return prepareRelease(run);
  const table = lawTable(run.law);
  const law = new ForceLaw(table);
  const load = loadOf(run, settings);
  const plate = edgedPlate(run, settings);
  const { lead, responses } = impulseResponses(...listenersOf(run, settings, plate));
  const own = plate && plate.moving(run.contact);
  const kept = own && chosenModes(law, chainAt(run, settings, law), own, responses[0], load, settings.speed, most);
  const chain = chainAt(run, settings, law, kept && kept.motion);
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
    kept: kept ? { modes: kept.modes, of: kept.of, costDb: kept.costDb } : { modes: 0, of: 0, costDb: 0 },
  };
}

/** Return the plate with edges at settings, the latest again if it is the same; null without edges. */
function edgedPlate(run, settings) {
  const { thickness, length, width, plateDensity, lossFactor } = settings;
  if (!thickness || !length) return null;
  const { young, poisson } = run.fixed;
  const massPerArea = plateDensity * thickness;
  const bendingStiffness = (young * thickness ** 3) / (12 * (1 - poisson ** 2));
  const numbers = { massPerArea, bendingStiffness, lossFactor, length, width };
  const count = (length * width * MODES_HZ) / (2 * Math.sqrt(bendingStiffness / massPerArea));
  if ((length * width) ** 1.5 * Math.sqrt(count) > MOST_WORK) {
    const size = `${(length * width).toPrecision(2)} m2 with about ${Math.round(count)} modes`;
    throw new Error(`This plate (${size}) takes too long to prepare: choose a smaller or a thicker one.`);
  }
  const key = JSON.stringify(numbers);
  if (latestPlate.key !== key) latestPlate = { key, plate: new EdgedPlate(numbers) };
  return latestPlate.plate;
}

/** Return the bodies that each listener hears, and the way [m] of the sound from the contact to the first. */
function listenersOf(run, settings, plate) {
  const { radius, young, poisson } = run.fixed;
  const { distance, plateDensity, ballDensity, thickness } = settings;
  if (!plate) {
    const ground = thickness
      ? platePressure(plateDensity * thickness, distance)
      : halfSpacePressure(plateDensity, compressionSpeed(young, poisson, plateDensity), distance);
    return [[{ bodies: run.hearBall ? [ground, ballPressure(radius, ballDensity, distance)] : [ground] }], distance];
  }
  const end = run.contactEnd ?? run.contact;
  const middle = run.contact.map((value, i) => (value + end[i]) / 2);
  const away = (point, place) => Math.hypot(place[0] - point[0], place[1] - point[1], place[2]);
  const places = run.listeners.map((place) => movedListener(place, middle, distance / run.settings.distance));
  const path = away(run.contact, places[0]);
  const listeners = places.map((place) => {
    const way = away(middle, place);
    const hears = run.hearBall && place[2] > 0;
    const bodies = hears ? [ballPressure(radius, ballDensity, way, place[2] / way, way - path)] : [];
    return { bodies, modes: plate.radiation(run.contact, place) };
  });
  return [listeners, path];
}

/** Return a listener [m] moved along its line from the contact, as the distance of the run changes. */
function movedListener(place, [x, y], factor) {
  return [x, y, 0].map((origin, i) => origin + factor * (place[i] - origin));
}
