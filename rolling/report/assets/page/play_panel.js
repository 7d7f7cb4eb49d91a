// ---- what can be set while the ball rolls ----

import { $, $$, runs } from "./core.js";
import { askSettings, isPlayed, live, liveOf, rollOn, sendVolume } from "./play_sound.js";
import { showExport } from "./play_export.js";
import { drawStage } from "./play_view.js";

/** Everything that a slider may set: name in the engine, label, unit and its number in SI units, and key of a scene. */
export const SETTINGS = [
  ["speed", "Speed", "m/s", 1, "rolling.speed_m_s"],
  ["load", "Load", "N", 1, "rolling.load_n"],
  ["ballDensity", "Density of the ball", "kg/m³", 1, "sphere.density_kg_m3"],
  ["thickness", "Thickness of the plate", "mm", 1e-3, "plate.thickness_mm"],
  ["length", "Length of the plate", "mm", 1e-3, "plate.length_mm"],
  ["width", "Width of the plate", "mm", 1e-3, "plate.width_mm"],
  ["plateDensity", "Density of the plate", "kg/m³", 1, "plate.density_kg_m3"],
  ["lossFactor", "Loss factor of the plate", "", 1, "plate.loss_factor"],
  ["contactLossFactor", "Loss factor of the contact", "", 1, "plate.contact_loss_factor"],
  ["distance", "Distance of the listener", "m", 1, "sound.distance_m"],
  ["q", "Share q of the energy that sounds", "", 1, "sound.q"],
  ["dropHeight", "Drop height", "mm", 1e-3, "rolling.drop_mm"],
].map(([name, label, unit, si, key]) => ({ name, label, unit, si, key }));

const RELEASED = ["speed", "distance", "q"];

/** Tells whether a setting means something for a run. */
export function isLive(name, { kind, settings, limits, fixed }) {
  if (!limits[name] || limits[name][0] >= limits[name][1]) return false;
  if (name === "dropHeight") return kind === "vibration";
  if (settings[name] === null) return false;
  if (kind === "release") return RELEASED.includes(name);
  if (name === "lossFactor") return settings.length !== null;
  return name !== "q" && !(name === "load" && fixed.weight);
}

/** Returns the value at a share of a slider: even steps, even ratios over wide ranges, or from zero by growing steps. */
export function valueAt(share, [low, high]) {
  if (low === 0) return (high * (1000 ** share - 1)) / 999;
  return high / low > 5 ? low * (high / low) ** share : low + (high - low) * share;
}

/** Returns the share of a slider at a value: the inverse of `valueAt`. */
export function shareAt(value, [low, high]) {
  if (low === 0) return Math.log(1 + (999 * value) / high) / Math.log(1000);
  return high / low > 5 ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

/** Rounds a value to three digits in its unit, as slider, engine and scene share it. */
export const roundedIn = (value, si) => Number((Number((value / si).toPrecision(3)) * si).toPrecision(12));
export const textOf = ({ unit, si }, value) => `${Number((value / si).toPrecision(4))}${unit && ` ${unit}`}`;

/** Builds the sliders of the chosen run. */
export function showSettings() {
  const run = liveOf();
  const rows = SETTINGS.filter(({ name }) => isLive(name, run)).map((setting) => {
    const { name, label } = setting, id = `play-${name}`;
    const row = Object.assign(document.createElement("div"), { className: "slider" });
    row.innerHTML = `<label for="${id}">${label}</label><output for="${id}"></output><input type="range" id="${id}" min="0" max="1" step="0.005"><small></small>`;
    const input = row.querySelector("input");
    input.addEventListener("input", () => changeSetting(setting, roundedIn(valueAt(Number(input.value), run.limits[name]), setting.si)));
    return row;
  });
  $("#play-settings").replaceChildren(...rows.filter((row) => !row.querySelector("#play-dropHeight")));
  $("#play-fall").replaceChildren(...rows.filter((row) => row.querySelector("#play-dropHeight")));
  $("#play-drop").hidden = !isLive("dropHeight", run);
  live.settings.dropHeight ??= run.limits.dropHeight ? roundedIn(run.limits.dropHeight[1] / 2, 1e-3) : null;
  const { radius } = run.fixed;
  $("#play-fixed").textContent = `The radius of ${Number((1e3 * radius).toPrecision(4))} mm, the modulus, the hardness and the roughness belong to the solved contact${run.kind === "release" ? ", and so does the load" : ""}: another one takes another run. ${run.remarks.join(" ")}`;
  for (const setting of SETTINGS) showSetting(setting);
  for (const radio of $$("input[name=play-run]")) radio.checked = Number(radio.value) === live.number;
}

function showSetting(setting) {
  const { name } = setting, input = $(`#play-${name}`);
  if (!input) return;
  const value = live.settings[name], own = liveOf().settings[name];
  const changed = own !== null && value !== own;
  input.value = shareAt(value, liveOf().limits[name]);
  input.setAttribute("aria-valuetext", textOf(setting, value));
  const row = input.parentElement;
  row.classList.toggle("changed", changed);
  row.querySelector("output").textContent = textOf(setting, value);
  row.querySelector("small").textContent = changed ? `scene: ${textOf(setting, own)}` : "";
}

/** Takes a new value of a setting: a speed is a glide, everything else another instrument. */
export function changeSetting(setting, value) {
  live.settings[setting.name] = value;
  showSetting(setting);
  if (setting.name === "speed") rollOn();
  if (setting.name !== "dropHeight" || live.dropped) askSettings();
  showExport();
  drawStage();
}

/** Sets the speed that a hand gave the ball, within the limits of the run. */
export function giveSpeed(speed) {
  const [setting] = SETTINGS, [low, high] = liveOf().limits.speed;
  changeSetting(setting, roundedIn(Math.min(Math.max(speed, low), high), 1));
}

/** Goes back to the settings of the scene. */
export function backToScene() {
  const { settings } = liveOf();
  Object.assign(live, { settings: { ...settings }, dropped: settings.dropHeight !== null });
  live.volume = 0;
  $("#play-volume").value = 0;
  showVolume();
  showSettings();
  askSettings();
  if (isPlayed()) rollOn();
  showExport();
}

export function showVolume() {
  const text = `${live.volume > 0 ? "+" : ""}${live.volume} dB`.replace("-", "−");
  $("#play-volume").setAttribute("aria-valuetext", text);
  $("#play-volume-now").textContent = text;
  if (live.number >= 0) sendVolume();
}

export function showRolling() {
  const button = $("#play-roll");
  button.querySelector("span").textContent = live.rolling ? "Stop" : "Roll";
  button.toggleAttribute("data-playing", live.rolling);
}

/** Says how many modes of a plate with edges move, and what the others cost. */
export function showModes(kept) {
  const { modes, of, costDb } = kept ?? { modes: 0, of: 0 };
  $("#play-modes").textContent = modes < of ? `Of ${of} modes of the plate the lowest ${modes} move; the others stand together in bands, which changes the level by about ${costDb < 0.1 ? "less than 0.1" : costDb.toFixed(1)} dB.` : "";
}

/** Says in a sentence what the engine cannot do; nothing takes the sentence away. */
export function sayPlayed(text) {
  $("#play-note").textContent = text;
  $("#play-note").hidden = !text;
}

export const playedRuns = () => [...runs.keys()].filter((number) => runs[number].live);
