// ---- choices ----

import { $, $$, data, position, runs, state } from "./core.js";
import { mix, setEnd, startVoices, stopVoices } from "./player.js";
import { render } from "./motion.js";
import { showFilm } from "./film.js";
import { endTest } from "./abx.js";

export const signed = (value) => (Math.abs(value) < 0.05 ? "0.0" : `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(1)}`);

export function choose(number) {
  if (!(number in runs)) return;
  state.run = number;
  endTest();
  mix();
  for (const radio of $$("input[name=run]")) radio.checked = Number(radio.value) === number;
  if ($("#choose")) $("#choose").value = String(number);
  for (const figure of $$("[data-name=release_power]")) figure.hidden = Number(figure.dataset.run) !== number;
  for (const note of $$("[data-repeats]")) note.hidden = Number(note.dataset.repeats) !== number;
  say(runs[number].label);
  showFilm();
  render();
}

export function setMode(mode) {
  state.mode = mode;
  mix();
  showMode();
  say(mode === "equal" ? "equal LAeq" : "calibrated");
}

export function showMode() {
  const { mode } = state;
  for (const radio of $$("input[name=mode]")) radio.checked = radio.value === mode;
  for (const [number, { playback }] of runs.entries()) {
    if (playback.calibrated_pa === null) continue;
    const equal = mode === "equal";
    const gain = $(`[data-gain="${number}"]`); // a single run has none
    if (gain) gain.textContent = signed(equal ? playback.equal_db : 0);
    $(`[data-scale="${number}"]`).textContent = `${Number(playback[`${mode}_pa`].toPrecision(4))} Pa`;
  }
}

export function setLoop(loop) {
  const changes = state.playing && runs.some((run) => run.buzzes || !run.loops); // records that now go round, or no longer do
  const at = position();
  if (changes) stopVoices();
  state.loop = $("#loop").checked = loop;
  if (changes) startVoices(at);
  else if (state.playing) setEnd();
  say(loop ? "loop" : "no loop");
}

export function say(text) {
  $("#said").textContent = text;
}
