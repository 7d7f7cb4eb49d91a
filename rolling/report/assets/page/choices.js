// ---- choices ----

import { $, $$, data, isLong, longest, playbackOf, position, runs, state } from "./core.js";
import { mix, pause, play, seek, setEnd, startVoices, stopVoices } from "./player.js";
import { render } from "./motion.js";
import { showFilm } from "./film.js";
import { showStill } from "./still.js";
import { endTest } from "./abx.js";
import { takeRun } from "./play_sound.js";

export const signed = (value) => (Math.abs(value) < 0.05 ? "0.0" : `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(1)}`);

export function choose(number) {
  if (!(number in runs)) return;
  state.run = number;
  endTest();
  mix();
  for (const radio of $$("input[name=run], input[name=play-run]")) radio.checked = Number(radio.value) === number;
  if ($("#choose")) $("#choose").value = String(number);
  for (const figure of $$("[data-name=release_power]")) figure.hidden = Number(figure.dataset.run) !== number;
  showOnly();
  say(runs[number].label);
  takeRun(number);
  showStill();
  showFilm();
  render();
}

/** Shows the level and the notes of the chosen run; the notes on its computed record only while that is heard. */
export function showOnly() {
  for (const element of $$("[data-only]")) {
    element.hidden = Number(element.dataset.only) !== state.run || ("record" in element.dataset && isLong(state.run));
  }
}

export function setMode(mode) {
  state.mode = mode;
  mix();
  showMode();
  say(mode === "equal" ? "equal loudness" : "calibrated");
}

export function showMode() {
  const equal = state.mode === "equal";
  if ($("#equal")) $("#equal").checked = equal;
  for (const number of runs.keys()) {
    const playback = playbackOf(number);
    if (playback.calibrated_pa === null) continue;
    const gain = $(`[data-gain="${number}"]`); // a single run has none
    if (gain) gain.textContent = signed(equal ? playback.equal_db : 0);
    $(`[data-scale="${number}"]`).textContent = `${Number((playback.full_scale_pa / playback[state.mode]).toPrecision(4))} Pa`;
  }
}

export function setLoop(loop) {
  const changes = state.playing && runs.some((run, number) => isLong(number) || run.buzzes || !run.loops); // records that now go round, or no longer do
  const at = position();
  if (changes) stopVoices();
  state.loop = $("#loop").checked = loop;
  if (changes) startVoices(at);
  else if (state.playing) setEnd();
  say(loop ? "loop" : "no loop");
}

/** Lets the long records be heard, or the computed ones; the playhead goes back to the beginning. */
export function setLong(long) {
  const goesOn = state.wanted;
  if (goesOn) pause();
  state.long = long && data.long;
  if ($("#heard")) $("#heard").value = state.long ? "long" : "record";
  $("#seek").max = longest();
  showMode();
  showOnly();
  seek(0);
  if (goesOn) play();
}

export function say(text) {
  $("#said").textContent = text;
}
