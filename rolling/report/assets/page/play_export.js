// ---- taking settings and sound away ----

import { $, runs } from "./core.js";
import { copy, download } from "./downloads.js";
import { SETTINGS, isLive, sayPlayed } from "./play_panel.js";
import { live, liveOf, openWorker } from "./play_sound.js";

export const RECORD_S = 60;
const SOLVED_AGAIN = ["rolling.load_n"]; // keys that stored marches do not allow to change

/** Returns the keys of a scene that differ from the run, with their values. */
export function changedKeys(run, settings, dropped = false) {
  const changed = SETTINGS.filter(({ name }) => isLive(name, run) && (name !== "dropHeight" || dropped || run.settings.dropHeight !== null));
  return changed
    .filter(({ name }) => settings[name] !== run.settings[name])
    .map(({ name, si, key }) => [key, Number((settings[name] / si).toPrecision(6))]);
}

/** Returns the settings as keys of a scene file, with the commands that reproduce them. */
export function yamlOf(run, swept, settings, dropped = false) {
  const changed = changedKeys(run, settings, dropped);
  if (changed.length === 0 && Object.keys(swept).length === 0) return "# as the scene has it\n";
  const sections = {};
  for (const [key, value] of [...Object.entries(swept), ...changed]) {
    const [section, name] = key.split(".");
    (sections[section] ??= {})[name] = value;
  }
  if (Object.keys(swept).length > 0) sections.sweep = {};
  const again = changed.some(([key]) => SOLVED_AGAIN.includes(key) || run.fixed.bound?.includes(key));
  const words = changed.map(([key, value]) => ` --set ${key}=${value}`).join("");
  const lines = Object.entries(sections).map(([section, values]) => `${section}: {${Object.entries(values).map(([name, value]) => `${name}: ${JSON.stringify(value)}`).join(", ")}}`);
  const command = again ? "needs a new march: rolling run SCENE.yaml" : "rolling resound RUN";
  return [`# ${run.label}${words ? `; ${command}${words}` : ""}`, ...lines, ""].join("\n");
}

export function showExport() {
  $("#play-yaml").textContent = yamlOf(liveOf(), runs[live.number].swept ?? {}, live.settings, live.dropped);
}

export const copyYaml = (button) => copy($("#play-yaml").textContent, button);

/** Lets the worker render a record of the present settings. */
export function saveWav() {
  openWorker();
  $("#play-wav").disabled = true;
  showProgress({ task: "progress", share: 0 });
  const own = liveOf().settings.dropHeight !== null;
  const settings = { ...live.settings, dropHeight: own || live.dropped ? live.settings.dropHeight : null };
  live.worker.postMessage({ task: "record", number: live.number, settings, seconds: RECORD_S });
}

/** Shows how far a record is, and hands it over when it is done. */
export function showProgress({ task, share, wav, fullScale, message }) {
  const bar = $("#play-progress");
  bar.hidden = task !== "progress";
  if (task === "progress") bar.value = share;
  else $("#play-wav").disabled = false;
  if (task === "failed") sayPlayed(`No record: ${message}.`);
  if (task !== "record") return;
  const name = `${runs[live.number].label.replace(/[^\w.=-]+/g, "_")}_played_full_scale_${fullScale}_Pa.wav`;
  download(wav, "audio/wav", name);
  $("#play-saved").textContent = `${RECORD_S} s at 48 kHz, 16 bit; full scale is ${fullScale} Pa.`;
}
