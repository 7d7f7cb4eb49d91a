// ---- taking things away ----

import { samplesOf, wavOf } from "./records.js";
import { download } from "./chart_save.js";
import { say } from "./choices.js";

/** Saves the record of the player beside a button as a WAV. */
export async function saveRecord(button) {
  const line = button.parentElement, record = await samplesOf(line.querySelector("audio"));
  const channels = Array.from({ length: record.numberOfChannels }, (_, c) => record.getChannelData(c));
  download(wavOf(channels, line.querySelector("span").textContent), "audio/wav", `${button.dataset.wav}.wav`);
}

export async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
  } catch { // not every browser lets a file use the clipboard
    const area = document.body.appendChild(document.createElement("textarea"));
    area.value = text;
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  say("copied");
  flash(button, "Copied");
}

/** Show a text on a button for a while. */
export function flash(button, text) {
  const before = button.dataset.label ??= button.textContent;
  button.textContent = text;
  setTimeout(() => { button.textContent = before; }, 2000);
}
