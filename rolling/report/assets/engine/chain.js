// Ball, contact and plate as a linear chain: mobilities, resonance, and the poles of the approach.
//
// Counted from rest under the load W, a force f = F - W moves the approach by -G(p) f with
// G(p) = 1 / (M p^2) + Y / p, or with a sum of modes in place of Y / p. The contact is a spring k
// beside a source s, F - W = k d - s, so the approach answers the source as H = G / D, D = 1 + k G.
// Its poles p_j and residues G / D' make the motion of d exact. They are found all at once, with the
// damping of the modes: below their critical damping no root is real, and without damping each lies
// between two neighbouring modes.

import { over, plus, times } from "./complex.js";

const ROUNDS = 200; // of the search for poles, which takes about twenty

/** Return the mobility [s/kg] of an infinite plate in bending. */
export function plateMobility(young, poisson, density, thickness) {
  const stiffness = (young * thickness ** 3) / (12 * (1 - poisson ** 2));
  return 1 / (8 * Math.sqrt(stiffness * density * thickness));
}

/** Return the mobility [s/kg] of a half-space at a frequency [rad/s]; C belongs to its Poisson's ratio. */
function halfSpaceMobility(coefficient, young, poisson, density, frequency) {
  const shear = Math.sqrt(young / (2 * (1 + poisson)) / density);
  return (coefficient * frequency ** 2) / (density * shear ** 3);
}

/** Return the chain of a ball [kg], a plate of modes or mobility [s/kg], and a spring [N/m] with viscosity. */
export function chainOf(mass, plate, stiffness, contactTime = 0) {
  const poles = plate.mobility ? plainPoles(mass, plate.mobility, stiffness) : modalPoles(mass, plate, stiffness);
  return { mass, stiffness, contactTime, poles };
}

/** Return the chain of a run at settings over a law. `modes` belong to a plate with edges. */
export function chainAt(run, settings, law, modes = null) {
  const { young, poisson, halfSpace } = run.fixed;
  const mass = ballMass(run, settings);
  const stiffness = law.meanStiffness(loadOf(run, settings));
  const resonance = Math.sqrt(stiffness / mass);
  const plate = [young, poisson, settings.plateDensity];
  const mobility = settings.thickness
    ? plateMobility(...plate, settings.thickness)
    : halfSpaceMobility(halfSpace, ...plate, resonance);
  return chainOf(mass, modes ?? { mobility }, stiffness, (settings.contactLossFactor ?? 0) / resonance);
}

/** Return the mass [kg] of the ball. */
export function ballMass(run, settings) {
  return (4 / 3) * Math.PI * run.fixed.radius ** 3 * settings.ballDensity;
}

/** Return the load [N], the weight of the ball if the scene says so. */
export function loadOf(run, settings) {
  return run.fixed.weight ? ballMass(run, settings) * run.fixed.gravity : settings.load;
}

// ---- poles ----

/** Return {w, loss, gain} of ball and modes by rising frequency, the ball first. */
function elementsOf(mass, { frequency, damping, reach }) {
  const modes = Array.from(frequency, (w, i) => ({ w, loss: damping[i] * w, gain: (w * reach[i]) ** 2 }));
  const elements = [{ w: 0, loss: 0, gain: 1 / mass }];
  for (const mode of modes.sort((a, b) => a.w - b.w)) {
    const last = elements[elements.length - 1];
    if (mode.gain < 1e-9 / mass) continue; // a nodal line at the contact
    if (mode.w - last.w < 1e-9 * mode.w) last.gain += mode.gain; // equal modes are one
    else elements.push(mode);
  }
  return elements;
}

/** Return G and G' at p, and the sum of the logarithmic derivatives of the poles of G. */
function receptance(elements, p) {
  let [value, slope, logarithmic] = [[0, 0], [0, 0], [0, 0]];
  for (const { w, loss, gain } of elements) {
    const inverse = over([1, 0], plus(times(p, plus(p, [2 * loss, 0])), [w * w, 0]));
    const share = times([2 * (p[0] + loss), 2 * p[1]], inverse);
    value = plus(value, inverse, gain);
    slope = plus(slope, times(share, inverse), -gain);
    logarithmic = plus(logarithmic, share);
  }
  return [value, slope, logarithmic];
}

/** Return first guesses of the poles: between each element and the next, the last one beyond all. */
function firstPoles(elements, k) {
  const total = elements.reduce((sum, { gain }) => sum + gain, 0);
  return elements.map(({ w, loss }, j) => {
    const next = elements[j + 1] ?? { w: Math.sqrt(w * w + k * total), loss };
    return [-(loss + next.loss) / 2, Math.sqrt((w * w + next.w ** 2) / 2)];
  });
}

/** Return the step of Aberth's method from one of all poles towards a root. */
function stepOf(elements, k, poles, j) {
  const p = poles[j];
  const [value, slope, logarithmic] = receptance(elements, p);
  let away = logarithmic;
  poles.forEach(([x, y], other) => {
    if (other !== j) away = plus(away, over([1, 0], [p[0] - x, p[1] - y]), -1);
    away = plus(away, over([1, 0], [p[0] - x, p[1] + y]), -1);
  });
  const balance = [1 + k * value[0], k * value[1]];
  return over([-balance[0], -balance[1]], plus(times(balance, away), slope, k));
}

/** Return [pole, residue] of each pole pair of a ball [kg] on a spring [N/m] and modes. */
function modalPoles(mass, modes, k) {
  const elements = elementsOf(mass, modes);
  const poles = firstPoles(elements, k);
  for (let round = 0, largest = 1; round < ROUNDS && largest > 1e-13; round++) {
    largest = 0;
    for (let j = 0; j < poles.length; j++) {
      const step = stepOf(elements, k, poles, j);
      largest = Math.max(largest, Math.hypot(...step) / Math.hypot(...poles[j]));
      const [x, y] = plus(poles[j], step);
      poles[j] = [x, Math.abs(y)];
    }
  }
  return poles.map((p) => {
    const [value, slope] = receptance(elements, p);
    return [p, over([2 * value[0], 2 * value[1]], [k * slope[0], k * slope[1]])];
  });
}

/** Return [pole, residue] of a ball [kg] on a spring [N/m] and a plate of a mobility [s/kg]. */
function plainPoles(mass, mobility, k) {
  const half = (k * mobility) / 2;
  const square = half * half - k / mass;
  const size = Math.sqrt(Math.max(Math.abs(square), (1e-8 * k) / mass)); // two poles, never a double one
  const [root, signs] = square > 0 ? [[size, 0], [1, -1]] : [[0, size], [1]]; // two real ones, or a pair
  return signs.map((sign) => {
    const pole = plus([-half, 0], root, sign);
    return [pole, over(plus([1 / mass, 0], pole, mobility), times(root, [sign * signs.length, 0]))];
  });
}
