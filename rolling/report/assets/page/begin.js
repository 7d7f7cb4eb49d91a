// ---- the beginning ----

import { $, data, longest, runs, state } from "./core.js";
import { recordOf } from "./records.js";
import { choose, say } from "./choices.js";
import { showStill } from "./still.js";
import { drawFilm, filmOf } from "./film.js";
import { openCharts } from "./chart.js";
import { showDifference } from "./compare.js";
import { beginPlaying } from "./play_hand.js";
import { listen, markScrolling } from "./keys.js";

export function begin() {
  document.documentElement.classList.add("scripted");
  $("#transport").hidden = false;
  $(".singles").open = false;
  $("#seek").max = longest();
  $("#loop").checked = state.loop;
  listen();
  openCharts(data.charts, runs.map((run) => run.label));
  for (const colours of ["(prefers-color-scheme: dark)", "print"]) matchMedia(colours).addEventListener("change", recolour);
  new ResizeObserver(markScrolling).observe(document.body);
  new IntersectionObserver(([hero]) => document.documentElement.classList.toggle("beyond", !hero.isIntersecting)).observe($("header"));
  choose(Math.max(0, runs.findIndex((run) => run.playback.calibrated_pa !== null))); // one that can be heard
  beginPlaying();
  showDifference();
  say("");
  decodeInTurn();
}

/** Decodes the record that Play begins with at once, and the others while nothing else is to do. */
export async function decodeInTurn() {
  const idle = window.requestIdleCallback ?? setTimeout;
  await recordOf(state.run);
  for (const number of runs.keys()) {
    await new Promise((done) => idle(done));
    await recordOf(number);
  }
}

/** Draws the canvases again in the colours of the screen, light or dark, or of paper. */
export function recolour() {
  showStill();
  if (filmOf()) drawFilm();
}

begin();
