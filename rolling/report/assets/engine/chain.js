// Ball, contact and plate as a linear chain: mobilities, resonance, and the poles of the approach.
//
// Counted from rest under the load W, a force f = F - W moves the approach by -G(p) f with
// G(p) = 1 / (M p^2) + Y / p, or with a sum of modes in place of Y / p. The contact is a spring k
// beside a source s, F - W = k d - s, so the approach answers the source as H = G / D, D = 1 + k G.
// Its poles p_j and residues G / D' make the motion of d exact.

import { modalPoles, plainPoles } from "./poles.js";

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
