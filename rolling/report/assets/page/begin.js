// ---- the beginning ----

import { $, longest, runs, state } from "./core.js";
import { decode } from "./player.js";
import { choose, say } from "./choices.js";
import { drawFilm, filmOf } from "./film.js";
import { showDifference } from "./compare.js";
import { listen, markScrolling } from "./keys.js";

export function begin() {
  document.documentElement.classList.add("scripted");
  $("#transport").hidden = false;
  $(".singles").open = runs.length === 1;
  $("#seek").max = longest;
  $("#loop").checked = state.loop;
  listen();
  for (const colours of ["(prefers-color-scheme: dark)", "print"]) matchMedia(colours).addEventListener("change", recolour);
  new ResizeObserver(markScrolling).observe(document.body);
  choose(Math.max(0, runs.findIndex((run) => run.playback.calibrated_pa !== null))); // one that can be heard
  showDifference();
  say("");
  (window.requestIdleCallback ?? setTimeout)(decode); // so that the first play is not late
}

/** Draws the canvases again in the colours of the screen, light or dark, or of paper. */
export function recolour() {
  showDifference();
  if (filmOf()) drawFilm();
}

begin();
