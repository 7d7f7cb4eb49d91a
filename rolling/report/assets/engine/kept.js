// Change of the level by the modes that do not move in real time, from the linear chain.

import { linesOfRecord } from "./fft.js";
import { RATE } from "./motion.js";
import { over, plus } from "./poles.js";
import { AUDIBLE, aWeight } from "./radiation.js";

const HEARD_LINES = 8192; // samples of the response
const MOST_LINES = 1200; // of the force

/** Return the square of the receptance [m2/N2] of ball, contact and modes at a frequency [Hz]. */
function squaredReceptance({ mass, stiffness, contactTime }, { frequency, damping, reach }, hertz) {
  const w = 2 * Math.PI * hertz;
  let sum = plus([-1 / (mass * w * w), 0], over([1 / stiffness, 0], [1, contactTime * w]));
  for (let i = 0; i < frequency.length; i++) {
    const ratio = w / frequency[i];
    sum = plus(sum, over([reach[i] ** 2, 0], [1 - ratio * ratio, 2 * damping[i] * ratio]));
  }
  return sum[0] ** 2 + sum[1] ** 2;
}

/** Return the change of LAeq [dB] between two sets of modes over a law, by the linear chain. */
export function costOfModes(law, { chain, load, speed }, response, sets) {
  const rows = 2 ** Math.ceil(Math.log2(law.rows));
  const approach = Float64Array.from({ length: rows }, (_, i) => {
    law.moveTo(law.start + (i * law.length) / rows);
    return law.approach(load);
  });
  const [track, heard] = [linesOfRecord(approach, rows), linesOfRecord(response, HEARD_LINES)];
  const square = ({ re, im }, line) => (line > 0 && 2 * line < re.length ? re[line] ** 2 + im[line] ** 2 : 0);
  const powers = [0, 0];
  const lowest = speed / law.length;
  const stride = Math.max(1, Math.ceil(AUDIBLE[1] / lowest / MOST_LINES));
  for (let k = Math.ceil(AUDIBLE[0] / lowest); k * lowest < AUDIBLE[1]; k += stride) {
    const f = k * lowest;
    const power = square(track, k) * square(heard, Math.round((f * HEARD_LINES) / RATE)) * aWeight(f) ** 2;
    if (power > 0) sets.forEach((modes, i) => (powers[i] += power / squaredReceptance(chain, modes, f)));
  }
  return powers[0] > 0 ? Math.abs(10 * Math.log10(powers[0] / powers[1])) : 0;
}
