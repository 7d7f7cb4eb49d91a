// ---- what moves ----

import { $, $$, data, longest, motionUnwanted, ownTime, runs, sharedTime, state } from "./core.js";
import { seek } from "./player.js";
import { choose } from "./choices.js";
import { showMap } from "./contact.js";

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
  timelines.forEach(movePlayhead);
  if (data.view && !(state.playing && motionUnwanted.matches)) showMap();
}

export const timelines = $$(".timeline").map((figure) => {
  const { run, ...rest } = figure.dataset;
  const [begin, end, left, right] = ["begin", "end", "left", "right"].map((name) => Number(rest[name]));
  return { figure, run: Number(run), begin, end, left, right, line: figure.querySelector(".playhead") };
});

export function movePlayhead({ run, begin, end, left, right, line }) {
  const share = (ownTime(run) - begin) / (end - begin);
  line.hidden = false;
  line.style.left = `${left + (right - left) * Math.min(1, Math.max(0, share))}%`;
}

export function seekByClick(event, { figure, run, begin, end, left, right }) {
  const sheet = figure.querySelector(".sheet").getBoundingClientRect();
  const share = ((100 * (event.clientX - sheet.left)) / sheet.width - left) / (right - left);
  if (run !== state.run) choose(run);
  seek(Math.min(Math.max(begin + share * (end - begin), 0), runs[run].seconds));
}
