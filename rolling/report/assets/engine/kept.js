// Choice of the modes that move in real time: the lowest, as many as time allows. Above them modes
// stand together in bands, which costs a part of the level.

import { linesOfRecord } from "./fft.js";
import { RATE } from "./motion.js";
import { TAIL_DAMPING, TAIL_RATIO } from "./plate.js";
import { AUDIBLE, aWeight } from "./radiation.js";

const MOST_LINES = 1200; // of the force
const HEARD_LINES = 8192; // samples of the response

/** Return modes with a band of the tail for each ratio 1.5 in place of own modes above a frequency [rad/s]. */
function keptModes({ frequency, damping, reach, own }, highest) {
  const kept = { frequency: [], damping: [], reach: [] };
  const bands = new Map();
  frequency.forEach((w, i) => {
    const band = Math.floor(Math.log(w / highest) / Math.log(TAIL_RATIO));
    if (w > highest && i < own) bands.set(band, (bands.get(band) ?? 0) + reach[i] ** 2);
    else [kept.frequency, kept.damping, kept.reach].forEach((list, k) => list.push([w, damping[i], reach[i]][k]));
  });
  for (const [band, square] of bands) {
    kept.frequency.push(highest * TAIL_RATIO ** (band + 0.5));
    kept.damping.push(TAIL_DAMPING);
    kept.reach.push(Math.sqrt(square));
  }
  return kept;
}

/** Return the roughness of a track under a load as waves: frequencies [Hz] at a speed and squares [m2]. */
function roughnessLines(law, load, speed) {
  const rows = 2 ** Math.ceil(Math.log2(law.rows));
  const approach = Float64Array.from({ length: rows }, (_, i) => {
    law.moveTo(law.start + (i * law.length) / rows);
    return law.approach(load);
  });
  const { re, im } = linesOfRecord(approach, rows);
  const lowest = speed / law.length;
  const last = Math.min(re.length - 1, Math.floor(AUDIBLE[1] / lowest));
  const stride = Math.max(1, Math.ceil(last / MOST_LINES));
  const lines = [];
  for (let k = Math.max(1, Math.ceil(AUDIBLE[0] / lowest)); k <= last; k += stride) {
    lines.push({ frequency: k * lowest, square: re[k] ** 2 + im[k] ** 2 });
  }
  return lines;
}

/** Return the square of the receptance [m2/N2] of ball, contact and modes at a frequency [Hz]. */
function squaredReceptance({ mass, stiffness, contactTime }, modes, frequency) {
  const w = 2 * Math.PI * frequency;
  const damping = contactTime * w;
  let re = -1 / (mass * w * w) + 1 / (stiffness * (1 + damping ** 2));
  let im = -damping / (stiffness * (1 + damping ** 2));
  for (let i = 0; i < modes.frequency.length; i++) {
    const ratio = w / modes.frequency[i];
    const [cr, ci] = [1 - ratio * ratio, 2 * modes.damping[i] * ratio];
    const share = modes.reach[i] ** 2 / (cr * cr + ci * ci);
    re += share * cr;
    im -= share * ci;
  }
  return re * re + im * im;
}

/**
 * Return the modes that move, how many of all they are, and the change of LAeq [dB] by the linear
 * chain: {motion, modes, of, costDb}. `chain` has mass, stiffness and viscosity of the contact.
 */
export function chosenModes(law, chain, modes, response, load, speed, most) {
  const own = modes.frequency.slice(0, modes.own); // they rise
  const whole = { motion: modes, modes: own.length, of: own.length, costDb: 0 };
  const lines = roughnessLines(law, load, speed);
  if (own.length <= most || !lines.length) return whole;
  const { re, im } = linesOfRecord(response, HEARD_LINES);
  const power = ({ frequency, square }, set) => {
    const line = Math.round((frequency * HEARD_LINES) / RATE);
    const transfer = (re[line] ** 2 + im[line] ** 2) * aWeight(frequency) ** 2;
    return (square * transfer) / squaredReceptance(chain, set, frequency);
  };
  const total = lines.reduce((sum, line) => sum + power(line, modes), 0);
  const highest = own[most - 1] * (1 + 1e-9);
  const motion = keptModes(modes, highest);
  const reduced = lines.reduce((sum, line) => sum + power(line, motion), 0);
  return { motion, modes: most, of: own.length, costDb: Math.abs(10 * Math.log10(reduced / total)) };
}
