// Sound of bodies that a force moves: pressure per force on the axis above the contact, after
// acoustics/radiation.py. Phasors of exp(i w t); the delay from the contact is left out.

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

/** Return a function that adds the pressure of an infinite plate per force [Pa/N] to a line. */
export function platePressure(massPerArea, distance) {
  const pressure = -AIR / (2 * Math.PI * distance * massPerArea);
  return (frequency, sum) => {
    sum[0] += pressure;
  };
}

/** Return a function that adds the pressure of an elastic half-space per force [Pa/N] to a line. */
export function halfSpacePressure(density, compressionSpeed, distance) {
  const pressure = -AIR / (distance * density * compressionSpeed);
  return (frequency, sum) => {
    sum[1] += pressure * frequency;
  };
}

/**
 * Return a function that adds the pressure of a ball and its image per force [Pa/N] to a line, at a
 * distance [m] and cosine from the axis, later than the sound from the contact by a way [m].
 */
export function ballPressure(radius, density, distance, cosine = 1, further = 0) {
  return (frequency, sum) => {
    const k = (2 * Math.PI * frequency) / SOUND;
    const ka = k * radius;
    const small = ((3 * AIR * frequency) / (distance * density * SOUND)) * cosine * Math.sin(ka * cosine);
    const [cr, ci] = [2 - ka * ka, 2 * ka];
    const phase = ka - k * further;
    const size = -small / (cr * cr + ci * ci);
    const [re, im] = [Math.cos(phase), Math.sin(phase)];
    sum[0] += size * (re * cr + im * ci);
    sum[1] += size * (im * cr - re * ci);
  };
}

/** Return the speed [m/s] of compression waves in an elastic body; none is quite incompressible. */
export function compressionSpeed(young, poisson, density) {
  const nu = Math.min(poisson, 0.499);
  return Math.sqrt((young * (1 - nu)) / ((1 + nu) * (1 - 2 * nu)) / density);
}
