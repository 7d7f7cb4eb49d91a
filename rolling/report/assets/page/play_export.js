// ---- export: the played scene as YAML, and a record as WAV ----

import { $, runs } from "./core.js";
import { download } from "./chart_save.js";
import { live, liveOf } from "./play_live.js";
import { sayPlayed } from "./play_notes.js";
import { SETTINGS, isLive } from "./play_settings.js";
import { engineUrl, openWorker } from "./play_sound.js";
import { copy } from "./copy.js";
import { wavOf } from "./records.js";
import { ballMass, loadOf } from "../engine/chain.js";
import { renderedRecord } from "../engine/graph.js";

const RECORD_S = 60;
const FALLS = 3.5; // times that a record lasts over a fall: the second impact comes after three at most, and the end fades
const ROUNDED = 1e-9; // of a length
const PEAK = 10 ** (-1 / 20); // of full scale

/** Return the keys of a scene that differ from the run, with their values; null removes a key. */
function changedKeys(run, settings, dropped) {
  const { scene } = run, differs = (name) => settings[name] !== run.settings[name];
  const isChanged = ({ name }) => isLive(name, run) && differs(name) && (name !== "dropHeight" || dropped);
  const changed = SETTINGS.filter(isChanged).map(({ name, si, key }) => {
    if (name === "distance" && scene.sound.listener_mm) return ["sound.listener_mm", movedListeners(run, settings)];
    if (name === "dropHeight" && settings.dropHeight === 0) return [key, null]; // a scene without a fall
    const value = Number((settings[name] / si).toPrecision(6)), { lossCurve } = run.fixed;
    if (name === "lossFactor" && lossCurve) return [key, lossCurve.map(([hz, ratio]) => [hz, Number((value * ratio).toPrecision(6))])];
    return [key, value];
  });
  const { sideRatio } = run.fixed;
  if (sideRatio && differs("length")) changed.push(["plate.width_mm", Number(((1e3 * settings.length) / sideRatio).toPrecision(6))]);
  if (scene.plate.contact_mm && (differs("length") || differs("width"))) changed.push(["plate.contact_mm", scene.plate.contact_mm]); // it stays
  const length = dropped && settings.dropHeight > 0 ? trackOfFall(run, settings) : 0;
  if (1e3 * length > (1 + ROUNDED) * scene.rolling.distance_mm) changed.push(["rolling.distance_mm", Number((1e3 * length).toPrecision(4))]);
  return changed;
}

/** Return the track [m] on which a fall is heard to its second impact at least, and as far as the fall of the run. */
function trackOfFall(run, settings) {
  const fallTime = (at) => Math.sqrt((2 * (at.dropHeight ?? 0) * ballMass(run, at)) / loadOf(run, at));
  const own = fallTime(run.settings), fall = fallTime(settings);
  const lasted = (1e-3 * run.scene.rolling.distance_mm) / run.settings.speed;
  if (fall === own && own < lasted) return settings.speed * lasted; // the fall of the run, which is heard in it
  return settings.speed * Math.max(FALLS * fall, own > 0 ? (lasted * fall) / own : 0);
}

/** Return the places of the listeners [mm], scaled from the middle of the path as in the engine. */
function movedListeners({ middle, listeners, settings: own }, { distance }) {
  const inMm = (length) => Number((1e3 * length).toPrecision(6));
  return listeners.map((place) => place.map((value, i) => inMm(middle[i] + (distance / own.distance) * (value - middle[i]))));
}

/** Write a value of a scene in YAML, which holds JSON but for some letters. */
function yamlValue(value) {
  if (value && typeof value === "object" && !Array.isArray(value)) {
    return `{${Object.entries(value).map(([name, part]) => `${name}: ${yamlValue(part)}`).join(", ")}}`;
  }
  if (Array.isArray(value)) return `[${value.map(yamlValue).join(", ")}]`;
  const escaped = (letter) => `\\u${letter.charCodeAt(0).toString(16).padStart(4, "0")}`;
  return JSON.stringify(value).replace(/[\u007f-\u009f\u2028\u2029\ufeff]/g, escaped);
}

/** Return the whole scene of what is played; a comment names the command that changes the stored run. */
function yamlOf(run, settings, dropped) {
  if (settings.speed === 0) return "# A scene needs a speed above 0.\n";
  const changed = changedKeys(run, settings, dropped), scene = structuredClone(run.scene);
  for (const [key, value] of changed) {
    const [section, name] = key.split(".");
    if (value === null) delete scene[section][name];
    else scene[section][name] = value;
  }
  return [...headOf(run, changed), ...Object.entries(scene).map(([name, value]) => `${name}: ${yamlValue(value)}`), ""].join("\n");
}

/** Return the comments above a scene. */
function headOf(run, changed) {
  const words = changed.map(([key, value]) => ` --set '${key}=${JSON.stringify(value)}'`).join("");
  const isMarched = changed.some(([key]) => isSolvedAgain(key, run));
  const head = [`# ${run.label}${words && !isMarched ? `, changed: rolling resound RUN${words}` : ""}`];
  const files = [run.scene.surface.path, run.scene.sphere.surface?.path].filter(Boolean);
  if (files.length > 0) head.push(`# Keep it in the folder of the scene that was run, from which it reads ${files.map((path) => JSON.stringify(path)).join(" and ")}.`);
  return head;
}

/** Tell whether a key requires another march of the contact. */
function isSolvedAgain(key, { fixed: { weight, rollsOut } }) {
  if (key === "sphere.density_kg_m3") return weight || rollsOut;
  return key === "rolling.load_n" || key === "rolling.distance_mm" || (key === "rolling.speed_m_s" && rollsOut);
}

export function showExport() {
  $("#play-yaml").textContent = yamlOf(liveOf(), live.settings, live.dropped);
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
    $("#play-saved").textContent = `${RECORD_S} s at 48 kHz, 24 bit; full scale is ${fullScale} Pa.`;
  } catch (error) {
    sayPlayed(`No record: ${error.message}.`);
  } finally {
    button.disabled = false;
  }
}
