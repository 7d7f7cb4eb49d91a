// Impulse responses at 48 kHz from the contact force to the pressure at a listener. Time counts from
// the arrival of the sound from the contact; the responses begin a lead earlier.
//
// A mode answers with -p^2 / (p^2 + loss w p + w^2) = (loss w p + w^2) / (p^2 + loss w p + w^2) - 1. The
// fraction is a resonator with two poles at 48 kHz behind a short filter, which has all of the rest.

import { over, plus, recordOfLines, times } from "./complex.js";
import { RATE } from "./rate.js";
import { AUDIBLE, SOUND } from "./radiation.js";

const TAPER = 500; // [Hz] beyond hearing in which the band ends
const LEAD = 192; // samples in which the band limit fades in and out: -80 dB
const [MIN_SAMPLES, PLAIN_SAMPLES] = [256, 1024]; // samples of a filter at least, with a plate that has edges and without
const RUNG = 1e-5; // of a mode at which its ringing ends
const LEFT = 1e-6; // energy that is cut at the end
const FADED = 0.25; // part of a response that fades at its end, so that the cut makes no noise
const LONGEST = 20; // [s]

/** Return the share of a frequency [Hz] that passes the upper end of the band. */
function passed(frequency) {
  const place = (frequency - AUDIBLE[1]) / TAPER;
  return place <= 0 ? 1 : Math.cos((Math.PI / 2) * place) ** 2;
}

/** Return the filter with a response [re, im] over frequency [Hz], from `lead` samples before the time 0. */
function filterOf(responseAt, { frequencies, lead, count }) {
  const lines = { re: new Float64Array(frequencies.length), im: new Float64Array(frequencies.length) };
  frequencies.forEach((frequency, i) => {
    const [re, im] = responseAt(frequency, i);
    lines.re[i] = re * passed(frequency);
    lines.im[i] = im * passed(frequency);
  });
  const record = recordOfLines(lines, count);
  return record.map((_, i) => record[(i - lead + count) % count]);
}

/** Return a mode {w, loss} as a filter and its resonator, by its radiation [re, im] at each line. */
function resonatorOf({ w, loss }, radiationAt, grid) {
  const decay = (loss * w) / 2;
  const within = w < 2 * Math.PI * (AUDIBLE[1] + TAPER); // others do not ring in the band
  const fall = within ? Math.exp((-2 * decay) / RATE) : 0;
  const turn = 2 * Math.sqrt(fall) * Math.cos((w * Math.sqrt(Math.max(1 - loss * loss / 4, 0))) / RATE);
  const filter = filterOf((frequency, i) => {
    const x = 2 * Math.PI * frequency;
    const back = [Math.cos(x / RATE), -Math.sin(x / RATE)];
    const inverse = plus([1, 0], times(back, plus([-turn, 0], back, fall)));
    const answer = over([w * w, loss * w * x], [w * w - x * x, loss * w * x]);
    return times(times(answer, inverse), radiationAt(i));
  }, grid);
  const rings = within ? Math.min(-Math.log(RUNG) / decay, LONGEST) : 0;
  return { filter, turn, fall, length: filter.length + Math.ceil(RATE * rings) };
}

/** Add the response of a resonator to samples. */
function addResonator(samples, { filter, turn, fall, length }) {
  let [before, value] = [0, 0];
  for (let i = 0; i < length; i++) {
    [before, value] = [value, turn * value - fall * before + (i < filter.length ? filter[i] : 0)];
    samples[i] += value;
  }
}

/** Return samples without an end that has little energy, faded out. */
function ended(samples) {
  const most = LEFT * samples.reduce((sum, sample) => sum + sample * sample, 0);
  let count = samples.length;
  for (let left = 0; count > MIN_SAMPLES && left <= most; count--) left += samples[count - 1] ** 2;
  const begin = (1 - FADED) * count;
  return samples.slice(0, count).map((sample, i) => (i < begin ? sample : sample * Math.cos((Math.PI / 2) * ((i - begin) / (count - begin))) ** 2));
}

// A listener has bodies, as functions of frequency, and the radiation of the modes of a plate or none.
/** Return responses [Pa/N] of listeners, and their common lead in samples. */
export function impulseResponses(listeners, path) {
  const samplesTo = (distance) => Math.ceil((Math.abs(distance - path) / SOUND) * RATE);
  const ends = listeners.flatMap(({ radiation }) => radiation?.distances ?? [path]);
  const lead = LEAD + samplesTo(Math.min(...ends));
  const least = ends.length > listeners.length ? MIN_SAMPLES : PLAIN_SAMPLES;
  const count = Math.max(least, 2 ** Math.ceil(Math.log2(lead + samplesTo(Math.max(...ends)) + LEAD)));
  const frequencies = Array.from({ length: ((AUDIBLE[1] + TAPER) * count) / RATE }, (_, i) => (i * RATE) / count);
  const grid = { frequencies, lead, count };
  const responses = listeners.map(({ bodies, radiation }) => {
    const { modes, at } = radiation ?? { modes: [], at: () => [] };
    const rows = frequencies.map((frequency) => at(frequency, path));
    const direct = rows.map((row) => row.reduce((sum, pressure) => plus(sum, pressure, -1), [0, 0]));
    const filter = filterOf((frequency, i) => bodies.reduce((sum, pressureAt) => plus(sum, pressureAt(frequency)), direct[i]), grid);
    const resonators = modes.map((mode, k) => resonatorOf(mode, (i) => rows[i][k], grid));
    const samples = new Float64Array(Math.max(count, ...resonators.map(({ length }) => length)));
    samples.set(filter);
    for (const resonator of resonators) addResonator(samples, resonator);
    return radiation ? ended(samples) : samples;
  });
  return { lead, responses };
}
