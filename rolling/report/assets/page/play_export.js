// ---- export: settings as YAML, and a record as WAV ----

import { $, runs } from "./core.js";
import { download } from "./chart_save.js";
import { SETTINGS, isLive, sayPlayed } from "./play_panel.js";
import { engineUrl, live, liveOf, openWorker } from "./play_sound.js";
import { copy, wavOf } from "./records.js";
import { renderedRecord } from "../engine/graph.js";

const RECORD_S = 60;
const PEAK = 10 ** (-1 / 20); // of full scale

/** Return the keys of a scene that differ from the run, with their values. */
function changedKeys(run, settings, dropped = false) {
  const differs = (name) => settings[name] !== run.settings[name];
  const changed = SETTINGS.filter(({ name }) => isLive(name, run) && differs(name) && (name !== "dropHeight" || dropped))
    .map(({ name, si, key }) => [key, keyValue(name, settings[name] / si)]);
  if (!run.listeners) return changed;
  const placed = changed.filter(([key]) => key !== "sound.distance_m");
  if (differs("length") || differs("width")) placed.push(["plate.contact_mm", run.contact.map(inMm)]); // it does not move with the edges
  if (differs("distance")) placed.push(["sound.listener_mm", movedListeners(run, settings)]);
  return placed;
}

/** Return a setting as the value of its key: a scene without a fall has null. */
const keyValue = (name, value) => (name === "dropHeight" && value === 0 ? null : Number(value.toPrecision(6)));

const inMm = (length) => Number((1e3 * length).toPrecision(6));

/** Return the places of the listeners [mm], scaled from the middle of the path as in the engine. */
function movedListeners({ middle, listeners, settings: own }, { distance }) {
  return listeners.map((place) => place.map((value, i) => inMm(middle[i] + (distance / own.distance) * (value - middle[i]))));
}

/** Return the settings as keys of a scene file, with a command that reproduces them. */
function yamlOf(run, swept, settings, dropped = false) {
  if (settings.speed === 0) return "# a scene needs a speed above 0\n";
  const changed = changedKeys(run, settings, dropped);
  if (changed.length === 0 && Object.keys(swept).length === 0) return "# unchanged from the scene\n";
  const sections = {};
  for (const [key, value] of [...Object.entries(swept), ...changed]) {
    const [section, name] = key.split(".");
    (sections[section] ??= {})[name] = value;
  }
  if (Object.keys(swept).length > 0) sections.sweep = {};
  const words = changed.map(([key, value]) => ` --set '${key}=${JSON.stringify(value)}'`).join("");
  const flow = (values) => Object.entries(values).map(([name, value]) => `${name}: ${JSON.stringify(value)}`).join(", ");
  const lines = Object.entries(sections).map(([section, values]) => `${section}: {${flow(values)}}`);
  const command = changed.some(([key]) => isSolvedAgain(key, run)) ? "rolling run SCENE" : "rolling resound RUN";
  return [`# ${run.label}${words ? `, changed: ${command}${words}` : ""}`, ...lines, ""].join("\n");
}

/** Tell whether a key requires another march of the contact. */
function isSolvedAgain(key, { fixed: { weight, rollsOut } }) {
  if (key === "sphere.density_kg_m3") return weight || rollsOut;
  return key === "rolling.load_n" || (key === "rolling.speed_m_s" && rollsOut);
}

export function showExport() {
  $("#play-yaml").textContent = yamlOf(liveOf(), runs[live.number].swept ?? {}, live.settings, live.dropped);
}

export const copyYaml = (button) => copy($("#play-yaml").textContent, button);

/** Render a record of the present settings once they are prepared, with its peak at -1 dB. */
export async function saveWav() {
  const button = $("#play-wav");
  button.disabled = true;
  openWorker();
  await live.preparing;
  try {
    if (live.refused) return;
    const { number, settings, prepared } = live.latest, speed = live.settings.speed;
    const channels = await renderedRecord(engineUrl(), runs[number].live, { ...settings, speed }, prepared, RECORD_S);
    const peak = channels.reduce((most, channel) => channel.reduce((top, sample) => Math.max(top, Math.abs(sample)), most), 0);
    const fullScale = Number((peak / PEAK || 1).toPrecision(4));
    const file = wavOf(channels.map((channel) => channel.map((sample) => sample / fullScale)), `full scale = ${fullScale} Pa`);
    const name = runs[number].label.replace(/[^\w.=-]+/g, "_");
    download(file, "audio/wav", `${name}_played_full_scale_${fullScale}_Pa.wav`);
    $("#play-saved").textContent = `${RECORD_S} s at 48 kHz, 16 bit; full scale is ${fullScale} Pa.`;
  } catch (error) {
    sayPlayed(`No record: ${error.message}.`);
  } finally {
    button.disabled = false;
  }
}
