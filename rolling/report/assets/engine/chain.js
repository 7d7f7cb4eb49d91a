// Ball, contact and plate as a linear chain: mobilities, resonance, and the poles of the approach.
//
// Counted from rest under the load W, a force f = F - W moves the approach by -G(p) f with
// G(p) = 1 / (M p^2) + Y / p, or with a sum of modes in place of Y / p. The contact is a spring k and
// a damper k tau beside a source s, F - W = k (1 + tau p) d - s, so the approach answers the source
// as H = G / D, D = 1 + k (1 + tau p) G. Its poles p_j and residues G / D' make the motion of d exact.

import { elementsOf, modalPoles } from "./poles.js";

const ATTEMPTS = 5; // of the search with other springs

/** Return the mobility [s/kg] of an infinite plate in bending. */
export function plateMobility(young, poisson, density, thickness) {
  const stiffness = (young * thickness ** 3) / (12 * (1 - poisson ** 2));
  return 1 / (8 * Math.sqrt(stiffness * density * thickness));
}

/** Return the mobility [s/kg] of a half-space at a frequency [rad/s]; C belongs to its Poisson's ratio. */
export function halfSpaceMobility(coefficient, young, poisson, density, frequency) {
  const shear = Math.sqrt(young / (2 * (1 + poisson)) / density);
  return (coefficient * frequency ** 2) / (density * shear ** 3);
}

/** Return the chain of a ball [kg] on modes, with spring [N/m] and viscosity over stiffness [s]. */
export function modalChain(mass, modes, stiffness, contactTime = 0) {
  const elements = elementsOf(mass, modes);
  const numbers = { mass, contactTime, mobility: 0, modes: elements.w.length - 1 };
  // The motion may split off any spring; another one parts poles that coincide.
  for (let attempt = 0, spring = stiffness; ; attempt++, spring *= 1.01) {
    const poles = modalPoles(elements, spring, contactTime);
    let compliance = 0;
    for (const [x, y, r, i] of poles) compliance -= (r * x + i * y) / (x * x + y * y);
    const exact = Math.abs(compliance * spring - 1) < 1e-7;
    if (exact || attempt === ATTEMPTS) return chainOf(poles, { ...numbers, stiffness: spring });
  }
}

/** Return the chain of a ball [kg] on a plate of a mobility [s/kg]: one pair of poles in closed form. */
export function plainChain(mass, mobility, stiffness, contactTime = 0) {
  const lead = mass * (1 + stiffness * contactTime * mobility);
  const half = (stiffness * (contactTime + mass * mobility)) / (2 * lead);
  const square = stiffness / lead;
  const turn = half * half - square;
  const root = Math.sqrt(Math.max(Math.abs(turn), 1e-8 * square)); // two poles, never a double one
  // H = (1 + M Y p) / (lead (p - p1) (p - p2))
  const poles = [];
  if (turn > 0) {
    const slow = -square / (half + root);
    for (const [p, other] of [[slow, -half - root], [-half - root, slow]]) {
      poles.push([p, 0, (1 + mass * mobility * p) / (lead * (p - other)), 0]);
    }
  } else {
    poles.push([-half, root, (mass * mobility) / lead, -(1 - mass * mobility * half) / (lead * root)]);
  }
  return chainOf(poles, { mass, stiffness, contactTime, mobility, modes: 0 });
}

/** Return a chain as arrays that a worker can transfer. */
function chainOf(poles, numbers) {
  const [re, im, residueRe, residueIm] = [0, 1, 2, 3].map((i) => Float64Array.from(poles, (pole) => pole[i]));
  return { ...numbers, re, im, residueRe, residueIm };
}

/**
 * Return the chain of a run at settings over a law. `modes` belong to a plate with edges.
 */
export function chainAt(run, settings, law, modes = null) {
  const { radius, young, poisson, halfSpace } = run.fixed;
  const mass = ballMass(run, settings);
  const stiffness = law.meanStiffness(loadOf(run, settings));
  const resonance = Math.sqrt(stiffness / mass);
  const contactTime = (settings.contactLossFactor ?? 0) / resonance;
  if (modes) return modalChain(mass, modes, stiffness, contactTime);
  const plate = [young, poisson, settings.plateDensity];
  const mobility = settings.thickness
    ? plateMobility(...plate, settings.thickness)
    : halfSpaceMobility(halfSpace, ...plate, resonance);
  return plainChain(mass, mobility, stiffness, contactTime);
}

/** Return the mass [kg] of the ball. */
export function ballMass(run, settings) {
  return (4 / 3) * Math.PI * run.fixed.radius ** 3 * settings.ballDensity;
}

/** Return the load [N], the weight of the ball if the scene says so. */
export function loadOf(run, settings) {
  return run.fixed.weight ? ballMass(run, settings) * run.fixed.gravity : settings.load;
}
