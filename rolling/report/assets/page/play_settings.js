// ---- the settings of the instrument, and the scales of their sliders ----

import { $$ } from "./core.js";

/** The sliders: name in the engine, unit and its number in SI units, and key of a scene. */
export const SETTINGS = $$(".slider input").map((input) => ({ ...input.dataset, name: input.name, si: Number(input.dataset.si), input }));

/** Tell whether a run has a slider for a setting. */
export const isLive = (name, { limits }) => Boolean(limits[name]) && limits[name][0] < limits[name][1];

/** Return the value at a share of a slider: by even ratios, or from zero by growing steps. */
export const valueAt = (share, [low, high]) => (low > 0 ? low * (high / low) ** share : (high * (1000 ** share - 1)) / 999);

/** Return the share of a slider at a value: the inverse of `valueAt`. */
export const shareAt = (value, [low, high]) =>
  low > 0 ? Math.log(value / low) / Math.log(high / low) : Math.log1p((999 * value) / high) / Math.log(1000);

/** Round a value to three digits in its unit, as slider, engine and scene share it. */
export const roundedIn = (value, si) => Number((Number((value / si).toPrecision(3)) * si).toPrecision(12));
export const SLIDER_STEP = 0.005; // of the whole slider
export const textOf = ({ unit, si }, value) => `${Number((value / si).toPrecision(4))} ${unit}`.trim();
