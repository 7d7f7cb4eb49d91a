// ---- what can be set while the ball rolls ----

import { $, $$, runs } from "./core.js";
import { askSettings, isPlayed, live, liveOf, rollOn, sendVolume } from "./play_sound.js";
import { showExport } from "./play_export.js";
import { drawStage } from "./play_view.js";

/** The sliders: name in the engine, unit and its number in SI units, and key of a scene. */
export const SETTINGS = $$(".slider input").map((input) => ({ name: input.name, unit: input.dataset.unit, si: Number(input.dataset.si), key: input.dataset.key, input }));

/** Tells whether a setting means something for a run. */
export const isLive = (name, { limits }) => Boolean(limits[name]) && limits[name][0] < limits[name][1];

/** Returns the value at a share of a slider: by even ratios, or from zero by growing steps. */
export const valueAt = (share, [low, high]) => (low > 0 ? low * (high / low) ** share : (high * (1000 ** share - 1)) / 999);

/** Returns the share of a slider at a value: the inverse of `valueAt`. */
export const shareAt = (value, [low, high]) => (low > 0 ? Math.log(value / low) / Math.log(high / low) : Math.log(1 + (999 * value) / high) / Math.log(1000));

/** Rounds a value to three digits in its unit, as slider, engine and scene share it. */
export const roundedIn = (value, si) => Number((Number((value / si).toPrecision(3)) * si).toPrecision(12));
const textOf = ({ unit, si }, value) => `${Number((value / si).toPrecision(4))} ${unit}`.trim();

/** Lets a slider change its setting. */
export function listenToSlider({ name, si, input }) {
  input.addEventListener("input", () => changeSetting(name, roundedIn(valueAt(Number(input.value), liveOf().limits[name]), si)));
}

/** Shows the sliders of the chosen run. */
export function showSettings() {
  const run = liveOf();
  live.settings.dropHeight ??= run.limits.dropHeight ? roundedIn(run.limits.dropHeight[1] / 2, 1e-3) : null;
  for (const setting of SETTINGS) {
    setting.input.parentElement.hidden = !isLive(setting.name, run);
    showSetting(setting);
  }
  $("#play-drop").hidden = !isLive("dropHeight", run);
  $("#play-remarks").textContent = run.remarks.join(" ");
  for (const radio of $$("input[name=play-run]")) radio.checked = Number(radio.value) === live.number;
}

function showSetting(setting) {
  const { name, input } = setting, run = liveOf();
  if (!isLive(name, run)) return;
  const value = live.settings[name], own = run.settings[name], changed = own !== null && value !== own;
  const row = input.parentElement;
  input.value = shareAt(value, run.limits[name]);
  input.setAttribute("aria-valuetext", textOf(setting, value));
  row.classList.toggle("changed", changed);
  row.querySelector("output").textContent = textOf(setting, value);
  row.querySelector("small").textContent = changed ? `scene: ${textOf(setting, own)}` : "";
}

/** Takes a new value of a setting: a speed is a glide, everything else another instrument. */
export function changeSetting(name, value) {
  live.settings[name] = value;
  showSetting(SETTINGS.find((setting) => setting.name === name));
  if (name === "speed") rollOn();
  if (name !== "dropHeight" || live.dropped) askSettings();
  showExport();
  drawStage();
}

/** Sets the speed [m/s] of the ball, within the limits of the run. */
export function giveSpeed(speed) {
  const [low, high] = liveOf().limits.speed;
  changeSetting("speed", roundedIn(Math.min(Math.max(speed, low), high), 1));
}

/** Goes back to the settings of the scene. */
export function backToScene() {
  const { settings } = liveOf();
  Object.assign(live, { settings: { ...settings }, dropped: settings.dropHeight !== null });
  setVolume(0);
  showSettings();
  askSettings();
  if (isPlayed()) rollOn();
  showExport();
}

/** Sets the volume [dB]. */
export function setVolume(volume) {
  live.volume = volume;
  const text = `${volume > 0 ? "+" : ""}${volume} dB`.replace("-", "−");
  $("#play-volume").value = volume;
  $("#play-volume").setAttribute("aria-valuetext", text);
  $("#play-volume-now").textContent = text;
  if (live.number >= 0) sendVolume();
}

export function showRolling() {
  $("#play-roll span").textContent = live.rolling ? "Stop" : "Roll";
  $("#play-roll").toggleAttribute("data-playing", live.rolling);
}

/** Says how many modes of a plate with edges move, and what the others cost. */
export function showModes({ modes, of, costDb } = { modes: 0, of: 0 }) {
  $("#play-modes").hidden = modes >= of;
  if (modes < of) $("#play-modes").textContent = `The lowest ${modes} of ${of} modes of the plate move, the others in bands: the level changes by ${costDb < 0.1 ? "less than 0.1" : `about ${costDb.toFixed(1)}`} dB.`;
}

/** Says in a sentence what the engine cannot do; nothing takes the sentence away. */
export function sayPlayed(text) {
  $("#play-note").textContent = text;
  $("#play-note").hidden = !text;
}

export const playedRuns = () => [...runs.keys()].filter((number) => runs[number].live);
