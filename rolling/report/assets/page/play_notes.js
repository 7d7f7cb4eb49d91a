// ---- notes of the instrument ----

import { $ } from "./core.js";

/** State how many modes of a plate with edges move, and the change of level by the others. */
export function showModes({ modes, of, costDb } = { modes: 0, of: 0, costDb: 0 }) {
  const kept = `The lowest ${modes} of ${of} modes of the plate move, the others in bands`;
  const cost = costDb < 0.1 ? "less than 0.1" : `about ${costDb.toFixed(1)}`;
  $("#play-modes").textContent = modes < of ? `${kept}: the level changes by ${cost} dB.` : "";
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
