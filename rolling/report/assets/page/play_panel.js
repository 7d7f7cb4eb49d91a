// ---- sliders of the settings ----

import { $, $$, runs } from "./core.js";
import { askSettings, live, liveOf, rollOn, sendVolume } from "./play_sound.js";
import { drawSpectrum, showStrip } from "./play_meter.js";
import { showExport } from "./play_export.js";
import { wakeStage } from "./play_view.js";
import { isPlayable } from "../engine/effort.js";

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
const roundedIn = (value, si) => Number((Number((value / si).toPrecision(3)) * si).toPrecision(12));
const SLIDER_STEP = 0.005; // of the whole slider
const textOf = ({ unit, si }, value) => `${Number((value / si).toPrecision(4))} ${unit}`.trim();

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

/** Show the chosen run with the settings of its scene. */
export function showRun() {
  const run = liveOf(), { settings, limits } = run;
  Object.assign(live, { settings: { ...settings }, dropped: settings.dropHeight !== null });
  live.settings.dropHeight ??= limits.dropHeight ? roundedIn(limits.dropHeight[1] / 2, 1e-3) : null;
  for (const setting of SETTINGS) setting.input.parentElement.hidden = !isLive(setting.name, run);
  $("#play-drop").hidden = !isLive("dropHeight", run);
  if ($("#play-contact")) $("#play-contact").hidden = !runs[live.number].maps;
  $("#play-remarks").textContent = run.remarks.join(" ");
  $("#play-volume").value = 0;
  for (const radio of $$("input[name=play-run]")) radio.checked = Number(radio.value) === live.number;
  showVolume();
  showStrip();
  drawSpectrum();
  takeSettings();
}

/** Show the settings and apply them: the speed glides, and other settings are prepared again. */
function takeSettings() {
  SETTINGS.filter(({ name }) => isLive(name, liveOf())).forEach(showSetting);
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
