// ---- notes of the instrument ----

import { $ } from "./core.js";

/** State how many modes of a plate with edges move, and the change of level by the others. */
export function showModes({ modes, of, costDb } = { modes: 0, of: 0, costDb: 0 }) {
  const kept = `The lowest ${modes} of ${of} modes of the plate move, the others in bands`;
  const cost = costDb < 0.1 ? "less than 0.1" : `about ${costDb.toFixed(1)}`;
  $("#play-modes").textContent = modes < of ? `${kept}: the level changes by ${cost} dB.` : "";
}

/** Say up to which frequency long steps [m] hold at a speed [m/s]; nothing for steps of a node, or at rest. */
export function showBand(longStep, speed) {
  const hertz = speed / (2 * longStep), um = Number((1e6 * longStep).toPrecision(4));
  const band = hertz < 1000 ? `${Number(hertz.toPrecision(3))} Hz` : `${Number((1e-3 * hertz).toPrecision(3))} kHz`;
  const text = `Steps of ${um} µm hold up to ${band} at ${Number(speed.toPrecision(3))} m/s.`;
  $("#play-band").textContent = longStep && speed > 0 ? text : "";
}

/** Show a message of the engine; an empty one hides the note. */
export function sayPlayed(text) {
  $("#play-note").textContent = text;
  $("#play-note").hidden = !text;
}

/** Say that settings are prepared, wherever the reader is in the instrument; an empty text hides it. */
export function sayPreparing(text) {
  $("#play-preparing").textContent = text;
  $("#play-preparing").classList.toggle("late", Boolean(text));
}
