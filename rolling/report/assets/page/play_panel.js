// ---- sliders of the settings ----

import { $, $$, runs } from "./core.js";
import { live, liveOf } from "./play_live.js";
import { SETTINGS, SLIDER_STEP, isLive, roundedIn, shareAt, textOf, valueAt } from "./play_settings.js";
import { askSettings, rollOn, sendVolume } from "./play_sound.js";
import { drawSpectrum, showStrip } from "./play_meter.js";
import { showExport } from "./play_export.js";
import { showBand } from "./play_notes.js";
import { wakeStage } from "./play_view.js";
import { isPlayable } from "../engine/effort.js";

/** Return the lowest and the highest share of a slider whose plate can be played, whatever share it has now. */
function endsOf({ name, si }) {
  const run = liveOf(), isPossible = (share) => isPlayable(run, { ...live.settings, [name]: settingAt(share, name, si) });
  const [first, last] = [0, 1].map(isPossible);
  if (first === last) return [0, 1]; // all are possible, or none
  let [possible, impossible] = first ? [0, 1] : [1, 0]; // a plate is harder the larger, the thinner and the denser it is
  while (Math.abs(possible - impossible) > SLIDER_STEP / 2) {
    const middle = (possible + impossible) / 2;
    if (isPossible(middle)) possible = middle;
    else impossible = middle;
  }
  const step = Math[first ? "floor" : "ceil"](possible / SLIDER_STEP), end = Number((step * SLIDER_STEP).toFixed(3));
  return first ? [0, end] : [end, 1];
}

/** Return the setting at a share of its slider. */
const settingAt = (share, name, si) => roundedIn(valueAt(share, liveOf().limits[name]), si);

/** Connect the sliders with their settings. */
export function listenToSliders() {
  for (const { name, si, input } of SETTINGS) {
    input.addEventListener("input", () => changeSetting(name, settingAt(Number(input.value), name, si)));
  }
  $("#play-volume").addEventListener("input", showVolume);
}

/** Choose the run that is played, with its own settings. */
export function takeRun(number) {
  if (number === live.number || !runs[number].live) return;
  Object.assign(live, { number, fastest: 0 });
  showRun();
}

/** Show the chosen run with the settings of its scene. */
export function showRun() {
  const run = liveOf(), { settings, limits } = run;
  Object.assign(live, { settings: { ...settings }, dropped: settings.dropHeight !== null });
  live.settings.dropHeight ??= limits.dropHeight ? roundedIn(limits.dropHeight[1] / 2, 1e-3) : null;
  for (const setting of SETTINGS) setting.input.parentElement.hidden = !isLive(setting.name, run);
  $("#play-drop").hidden = !isLive("dropHeight", run);
  if ($("#play-contact")) $("#play-contact").hidden = !runs[live.number].maps;
  $("#play-remarks").textContent = run.remarks.join(" ");
  $("#play-out").hidden = run.fixed.resistance === null;
  $("#play-out-words").textContent = "";
  showNeeds(run);
  $("#play-volume").value = 0;
  for (const radio of $$("input[name=play-run]")) radio.checked = Number(radio.value) === live.number;
  showVolume();
  showStrip();
  drawSpectrum();
  takeSettings();
}

/** List the numbers that only a new run changes, each with a command that changes it. */
function showNeeds({ needs }) {
  $("#play-needs").replaceChildren(...needs.map(({ name, value, command }) => {
    const row = document.createElement("div"), [term, words, code] = ["dt", "dd", "code"].map((tag) => document.createElement(tag));
    term.textContent = `${name} ${value}`;
    code.textContent = command;
    words.append("needs a new run: ", code);
    row.append(term, words);
    return row;
  }));
}

/** Show the settings and apply them: the speed glides, and other settings are prepared again. */
function takeSettings() {
  SETTINGS.filter(({ name }) => isLive(name, liveOf())).forEach(showSetting);
  showBand(liveOf().longStep, live.settings.speed);
  rollOn();
  askSettings();
  showExport();
  wakeStage();
}

function showSetting(setting) {
  const { name, input } = setting, { settings, limits } = liveOf();
  const value = live.settings[name], own = settings[name], changed = own !== null && value !== own, row = input.parentElement;
  [input.min, input.max] = endsOf(setting);
  input.value = shareAt(value, limits[name]);
  input.setAttribute("aria-valuetext", textOf(setting, value));
  row.classList.toggle("changed", changed);
  row.querySelector("output").textContent = textOf(setting, value);
  row.querySelector("small").textContent = changed ? `scene: ${textOf(setting, own)}` : "";
}

function changeSetting(name, value) {
  live.settings[name] = value;
  takeSettings();
}

/** Set the speed [m/s] of the ball, within the limits of the run. */
export function giveSpeed(speed) {
  const [low, high] = liveOf().limits.speed;
  changeSetting("speed", roundedIn(Math.min(Math.max(speed, low), high), 1));
}

function showVolume() {
  const { value } = $("#play-volume"), text = `${value > 0 ? "+" : ""}${value} dB`.replace("-", "−");
  $("#play-volume").setAttribute("aria-valuetext", text);
  $("#play-volume-now").textContent = text;
  sendVolume();
}
