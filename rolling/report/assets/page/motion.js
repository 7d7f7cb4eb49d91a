// ---- what moves ----

import { $, $$, data, longest, motionUnwanted, ownTime, runs, sharedTime, state } from "./core.js";
import { seek } from "./player.js";
import { choose } from "./choices.js";
import { showMap } from "./contact.js";
import { setPlayhead } from "./chart_touch.js";

export function tick() {
  if (!state.playing) return;
  render();
  requestAnimationFrame(tick);
}

export function showButton() {
  for (const button of $$("[data-play]")) {
    button.querySelector("span").textContent = state.wanted ? "Pause" : "Play";
    button.toggleAttribute("data-playing", state.wanted);
  }
}

export const seconds = (time) => `${time.toFixed(longest() < 1 ? 3 : 2)} s`;

export function render() {
  const time = sharedTime();
  $("#seek").value = time;
  $("#seek").setAttribute("aria-valuetext", seconds(time));
  $("#time").textContent = `${seconds(time)} / ${seconds(longest())}`;
  showPlayheads();
  if (data.view && !(state.playing && motionUnwanted.matches)) showMap();
}

/** Charts over time move their playheads, and a click on them seeks. */
export function showPlayheads() {
  for (const { plot } of $$("figure.timeline")) if (plot) setPlayhead(plot, ownTime(plot.chart.run));
}

export function seekByClick({ detail: { run, time } }) {
  if (run !== state.run) choose(run);
  seek(Math.min(Math.max(time, 0), runs[run].seconds));
}
