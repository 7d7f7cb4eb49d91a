// ---- sliders of the settings ----

import { $, $$, runs } from "./core.js";
import { askSettings, live, liveOf, rollOn, sendVolume } from "./play_sound.js";
import { drawSpectrum, showStrip } from "./play_meter.js";
import { showExport } from "./play_export.js";
import { wakeStage } from "./play_view.js";

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
const textOf = ({ unit, si }, value) => `${Number((value / si).toPrecision(4))} ${unit}`.trim();

/** Connect the sliders with their settings. */
export function listenToSliders() {
  for (const { name, si, input } of SETTINGS) {
    input.addEventListener("input", () => changeSetting(name, roundedIn(valueAt(Number(input.value), liveOf().limits[name]), si)));
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
