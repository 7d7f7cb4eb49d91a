// Impulse responses at 48 kHz from the contact force to the pressure at a listener. Time counts from
// the arrival of the sound from the contact; the responses begin a lead earlier.

import { recordOfLines } from "./fft.js";
import { times } from "./poles.js";
import { RATE } from "./motion.js";
import { AUDIBLE, SOUND } from "./radiation.js";

const TAPER = 500; // [Hz] beyond hearing in which the band ends
const LEAD = 192; // samples in which the band limit fades in: -80 dB
const SHORT = 1024; // samples of bodies that do not ring
const FIRST = 8192; // samples that come from lines; later ones are modes that ring alone
const WRAPPED = 0.1; // part of the ringing beyond that is left in the lines, and taken off again
const LEFT = 1e-6; // energy of the ringing that is cut at the end
const FADED = 0.25; // part of a response that fades at its end, so that the cut makes no noise
const INAUDIBLE = 1e-7; // part of a mode at which its ringing ends
const LONGEST = 20; // [s]

/** Return the share of a frequency [Hz] that passes the upper end of the band. */
function passed(frequency) {
  const place = (frequency - AUDIBLE[1]) / TAPER;
  return place <= 0 ? 1 : place >= 1 ? 0 : Math.cos((Math.PI / 2) * place) ** 2;
}

/** Return the response (SHORT samples, middle at half) of bodies by functions that add to a line. */
function shortResponse(bodies) {
  const [re, im] = [new Float64Array(SHORT / 2 + 1), new Float64Array(SHORT / 2 + 1)];
  for (let line = 0; line < re.length; line++) {
    const frequency = (line * RATE) / SHORT;
    const sum = [0, 0];
    for (const add of bodies) add(frequency, sum);
    const share = passed(frequency) * (line % 2 ? -1 : 1); // the sign moves the origin to the middle
    [re[line], im[line]] = [sum[0] * share, sum[1] * share];
  }
  return recordOfLines({ re, im }, SHORT);
}

/** Return the first samples of the sound of modes, FIRST from `lead` samples before the arrival. */
function firstSamples(radiation, rings, path, lead) {
  const growth = (-Math.log(WRAPPED) * RATE) / FIRST;
  const step = RATE / FIRST;
  const lines = radiation.lines(step, AUDIBLE[1] + TAPER, growth, path);
  for (let i = 0; i < lines.re.length; i++) {
    const share = passed(i * step);
    lines.re[i] *= share;
    lines.im[i] *= share;
  }
  const record = recordOfLines(lines, FIRST);
  const samples = new Float64Array(FIRST);
  for (let i = 0; i < FIRST; i++) samples[i] = record[(i - lead + FIRST) % FIRST] * Math.exp((growth * (i - lead)) / RATE);
  for (const ring of rings) {
    // The ringing beyond FIRST wraps round, once and again: a geometric series, here without its first term.
    const size = WRAPPED * Math.exp((-ring.decay * FIRST) / RATE);
    const phase = (ring.w * FIRST) / RATE;
    const [qr, qi] = [size * Math.cos(phase), size * Math.sin(phase)];
    const norm = (1 - qr) ** 2 + qi * qi;
    const [re, im] = times([ring.re, ring.im], [(qi * qi - qr * (1 - qr)) / norm, -qi / norm]);
    addRing(samples, { ...ring, re, im }, lead, 0);
  }
  return samples;
}

/** Add a ringing mode to a response from a sample on. */
function addRing(samples, { w, decay, re, im }, lead, begin) {
  const [size, angle] = [(passed(w / (2 * Math.PI)) / RATE) * Math.hypot(re, im), Math.atan2(im, re)];
  const valueAt = (time) => size * Math.exp(-decay * time) * Math.cos(w * time + angle);
  let [before, value] = [valueAt((begin - 1 - lead) / RATE), valueAt((begin - lead) / RATE)];
  const [turn, fall] = [2 * Math.exp(-decay / RATE) * Math.cos(w / RATE), Math.exp((-2 * decay) / RATE)];
  const end = Math.min(samples.length, begin + (Math.log(INAUDIBLE) / -decay) * RATE);
  for (let i = begin; i < end; i++) {
    samples[i] += value;
    [before, value] = [value, turn * value - fall * before];
  }
}

/** Return the number of samples after which a share LEFT of the energy of ringing modes is left at most. */
function ringingLength(rings) {
  const energies = rings.map(({ re, im, decay }) => (re * re + im * im) / decay);
  const least = (LEFT * energies.reduce((sum, energy) => sum + energy, 0)) / rings.length;
  const times = energies.map((energy, i) => Math.log(energy / least) / (2 * rings[i].decay));
  return Math.ceil(RATE * Math.min(Math.max(...times), LONGEST)) || 0; // silent at a node of all modes
}

/** Return the whole response of modes, from `lead` samples before the arrival. */
function modalResponse(radiation, path, lead) {
  const rings = radiation.rings(path);
  const samples = new Float64Array(Math.max(FIRST, lead + ringingLength(rings)));
  samples.set(firstSamples(radiation, rings, path, lead));
  for (const ring of rings) addRing(samples, ring, lead, FIRST);
  const begin = Math.floor((1 - FADED) * samples.length);
  for (let i = begin; i < samples.length; i++) samples[i] *= Math.cos((Math.PI / 2) * ((i - begin) / (samples.length - begin))) ** 2;
  return samples;
}

/**
 * Return responses [Pa/N] of listeners, and their common lead in samples. A listener has bodies that
 * do not ring, as functions that add to a line, and the radiation of modes or none.
 */
export function impulseResponses(listeners, path) {
  const early = Math.max(0, ...listeners.map(({ modes }) => (modes ? path - modes.nearest : 0)));
  const lead = LEAD + Math.ceil((early / SOUND) * RATE);
  const responses = listeners.map(({ bodies, modes }) => {
    const short = shortResponse(bodies);
    const samples = modes ? modalResponse(modes, path, lead) : new Float64Array(LEAD + SHORT / 2);
    for (let i = 0; i < samples.length; i++) samples[i] += short[i - lead + SHORT / 2] ?? 0;
    return samples;
  });
  return { lead, responses };
}
