// Sound of bodies that a force moves: pressure per force [Pa/N] on the axis above the contact as a
// function of frequency [Hz], after acoustics/radiation.py. The delay from the contact is left out.

import { over } from "./complex.js";

export const AIR = 1.204; // [kg/m3]
export const SOUND = 343.2; // [m/s]
export const IMPEDANCE = 413.3; // [Pa s/m] of air
export const AUDIBLE = [10 ** 1.25, 10 ** 4.35]; // [Hz] edges of the third octaves at 20 Hz and 20 kHz
const WEIGHTING_HZ = [20.598997, 107.65265, 737.86223, 12194.217]; // poles of the A-weighting

/** Return the factor of the A-weighting on a pressure at a frequency [Hz], after IEC 61672-1. */
export function aWeight(frequency) {
  const [f1, f2, f3, f4] = WEIGHTING_HZ.map((pole) => pole ** 2);
  const weight = (f) => (f * f * f4) / ((f + f1) * Math.sqrt((f + f2) * (f + f3)) * (f + f4));
  return weight(frequency ** 2) / weight(1e6);
}

/** Return the pressure of an infinite plate at a distance [m]. */
export function platePressure(massPerArea, distance) {
  return () => [-AIR / (2 * Math.PI * distance * massPerArea), 0];
}

/** Return the pressure of an elastic half-space by its modulus of compression waves [Pa]. */
export function halfSpacePressure(density, modulus, distance) {
  return (frequency) => [0, (-AIR * frequency) / (distance * Math.sqrt(density * modulus))];
}

/** Return the pressure of a ball and its image at a cosine off the axis, later by a path [m]. */
export function ballPressure(radius, density, distance, cosine, further) {
  return (frequency) => {
    const k = (2 * Math.PI * frequency) / SOUND;
    const ka = k * radius;
    const size = ((-3 * AIR * frequency) / (distance * density * SOUND)) * cosine * Math.sin(ka * cosine);
    const phase = ka - k * further;
    return over([size * Math.cos(phase), size * Math.sin(phase)], [2 - ka * ka, 2 * ka]);
  };
}
