// Record of a run at settings, rendered as fast as it goes: for files, and to compare with the program.

import { BLOCK, Convolver, LONG } from "./convolver.js";
import { DECIMATION_DELAY } from "./decimate.js";
import { RATE } from "./motion.js";
import { prepare } from "./prepare.js";
import { ReleaseSource } from "./release.js";
import { Travel } from "./travel.js";
import { ForceSource } from "./vibration.js";

const SETTLED = 1e-4; // change of the force from lap to lap over its rms
const LEAST_S = 0.3; // of a run-in, for the high-pass
const LONGEST_S = 12; // of a run-in

/** Return a function that gives the next samples of the source. */
function reader(source, travel) {
  const block = new Float64Array(BLOCK);
  let read = BLOCK;
  return (count) => {
    const samples = new Float64Array(count);
    for (let i = 0; i < count; i++) {
      if (read === BLOCK) {
        source.block(travel, block);
        read = 0;
      }
      samples[i] = block[read++];
    }
    return samples;
  };
}

/** Return the samples of a source once it repeats from lap to lap, and whether it does. */
function settledLap(next, lapSamples) {
  const least = Math.ceil(LEAST_S * RATE);
  next(Math.ceil(least / lapSamples) * lapSamples);
  let before = next(lapSamples);
  for (let done = 0; done < LONGEST_S * RATE; done += lapSamples) {
    const lap = next(lapSamples);
    let [change, square] = [0, 0];
    for (let i = 0; i < lapSamples; i++) {
      change = Math.max(change, Math.abs(lap[i] - before[i]));
      square += lap[i] ** 2;
    }
    before = lap;
    if (change <= SETTLED * Math.sqrt(square / lapSamples)) return { lap, settled: true };
  }
  return { lap: before, settled: false };
}

/** Return the pressure [Pa] of a number of samples that `next` gives, after some that run in. */
function radiatedSamples(prepared, next, runIn, samples, tell) {
  const convolver = new Convolver(prepared.responses);
  const blocks = prepared.responses.map(() => new Float64Array(BLOCK));
  const channels = prepared.responses.map(() => new Float64Array(samples));
  for (let done = -runIn; done < samples; done += BLOCK) {
    if (done % RATE < BLOCK) tell(Math.max(done, 0) / samples);
    convolver.process(next(BLOCK), blocks);
    for (let i = Math.max(0, -done); i < Math.min(BLOCK, samples - done); i++) {
      channels.forEach((channel, k) => (channel[done + i] = blocks[k][i]));
    }
  }
  return channels;
}

/**
 * Return channels of pressure [Pa] at 48 kHz of a run at settings: of the steady state, or of a fall
 * from its beginning. Samples have the time of the sound from the contact, without its delay;
 * `tell` hears the share that is done.
 */
export function record(run, settings, seconds, prepared = prepare(run, settings, Infinity), tell = () => {}) {
  const samples = Math.round(seconds * RATE);
  const vibrates = prepared.kind === "vibration";
  const source = new (vibrates ? ForceSource : ReleaseSource)(run, settings, prepared);
  const length = vibrates ? source.law.length : prepared.length;
  const lapSamples = Math.max(Math.round((length / settings.speed) * RATE), 1);
  // The speed that makes a lap a whole number of samples differs by half a sample in a lap at most.
  const speed = settings.speed > 0 ? (length * RATE) / lapSamples : 0;
  const begin = vibrates ? source.law.start : prepared.start;
  const travel = new Travel(begin, speed, Infinity);
  const next = reader(source, travel);
  if (settings.dropHeight) {
    source.lift(settings.dropHeight);
    source.held.share = source.rest = 0;
    source.drop();
    next(DECIMATION_DELAY);
    return radiatedSamples(prepared, next, prepared.lead, samples, tell);
  }
  if (!(speed > 0)) return [new Float64Array(samples)];
  const { lap, settled } = lapSamples < LONGEST_S * RATE ? settledLap(next, lapSamples) : { settled: false };
  let place = 0;
  const again = (count) => Float64Array.from({ length: count }, () => lap[place++ % lapSamples]);
  const read = settled ? again : next;
  if (!vibrates) return [read(samples)];
  const frames = Math.max(...prepared.responses.map(({ short, long }) => short.length * BLOCK + long.length * LONG));
  return radiatedSamples(prepared, read, frames, samples, tell);
}
