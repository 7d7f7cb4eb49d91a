// ---- taking things away ----

import { bytesOf, samplesOf, wavOf } from "./records.js";
import { say } from "./choices.js";

export function download(content, type, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Saves the record of the player beside a button as a WAV. */
export async function saveRecord(button) {
  const line = button.parentElement, record = await samplesOf(line.querySelector("audio"));
  const channels = Array.from({ length: record.numberOfChannels }, (_, c) => record.getChannelData(c));
  download(wavOf(channels, line.querySelector("span").textContent), "audio/wav", `${button.dataset.wav}.wav`);
}

export function save(button) {
  const text = new TextDecoder().decode(bytesOf(button.closest("figure").querySelector("img").src));
  const name = `${button.dataset.file}.${button.dataset.save}`;
  return button.dataset.save === "svg" ? download(text, "image/svg+xml", name) : savePixels(text, name, button);
}

export async function savePixels(text, name, button) {
  const image = Object.assign(new Image(), { src: URL.createObjectURL(new Blob([text], { type: "image/svg+xml" })) });
  try {
    await image.decode();
  } catch { // a browser may refuse a large picture
    say("this browser cannot draw the picture; take the SVG");
    return flash(button, "no PNG here");
  } finally {
    URL.revokeObjectURL(image.src);
  }
  const canvas = document.createElement("canvas");
  canvas.width = 1700; // 2 pixels for each of a page this wide
  canvas.height = Math.round((1700 * image.naturalHeight) / image.naturalWidth);
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return canvas.toBlob((content) => download(content, "image/png", name), "image/png");
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
