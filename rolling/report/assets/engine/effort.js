// Plates with edges whose modes take too long to prepare, or are more than a scene may have.

export const MODES_HZ = 30e3; // highest natural frequency of the modes that move
const MAX_WORK = 18; // area^1.5 [m3] times the root of the modes: 5 s

/** Return mass per area [kg/m2], bending stiffness [N m], area [m2] and about how many modes a plate has. */
export function plateNumbers({ young, poisson, sideRatio }, { thickness, length, width: own, plateDensity }) {
  const width = sideRatio ? length / sideRatio : own; // computed modes belong to a side ratio
  const massPerArea = plateDensity * thickness;
  const bendingStiffness = (young * thickness ** 3) / (12 * (1 - poisson ** 2));
  const area = length * width;
  const count = (area * MODES_HZ) / (2 * Math.sqrt(bendingStiffness / massPerArea));
  const highest = (2 * Math.PI * MODES_HZ * area) / Math.sqrt(bendingStiffness / massPerArea); // number of a mode
  return { massPerArea, bendingStiffness, width, area, count, highest };
}

/** Tell whether the modes of a plate at settings can be played, and stand in a scene. */
export function isPlayable({ fixed }, settings) {
  if (!settings.thickness || !settings.length) return true;
  const { area, count, highest } = plateNumbers(fixed, settings);
  if (highest > (fixed.highestNumber ?? Infinity)) return false; // the page holds fewer modes
  return area ** 1.5 * Math.sqrt(count) <= MAX_WORK && count <= (fixed.mostModes ?? Infinity);
}
