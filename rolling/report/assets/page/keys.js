// ---- the user ----

import { $, $$, longest, runs, sharedTime, state } from "./core.js";
import { glide, pause, play, seek } from "./player.js";
import { choose, setLong, setLoop, setMode } from "./choices.js";
import { seekByClick } from "./motion.js";
import { stepMap } from "./contact.js";
import { seekFilm, seekFilmTo, showRate } from "./film.js";
import { playFilm, realTime, stopFilm } from "./film_sound.js";
import { copy, saveRecord } from "./downloads.js";
import { showDifference } from "./compare.js";
import { ABX, beginTest, endTest } from "./abx.js";

export const toggle = () => (state.wanted ? pause() : play());
export const KEYS = {
  " ": toggle,
  ArrowLeft: () => seek(sharedTime() - longest() / 20),
  ArrowRight: () => seek(sharedTime() + longest() / 20),
  Home: () => seek(0),
  g: () => runs.length > 1 && setMode(state.mode === "equal" ? "calibrated" : "equal"),
  n: () => choose((state.run + 1) % runs.length),
  p: () => choose((state.run + runs.length - 1) % runs.length),
  l: () => setLoop(!state.loop),
  "?": () => { $(".singles").open = true; $("#keys").scrollIntoView(); $("#keys").focus(); },
};

export function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
  const on = event.target;
  const { key } = event;
  if (on.matches("select, textarea, audio, [contenteditable], input:not([type=radio], [type=checkbox], [type=range])")) return;
  // Keys that the focused control has a use of its own for.
  if (key === " " && on.matches("button, summary, a, [type=checkbox], [type=radio]:not(:checked)")) return;
  if ((key.startsWith("Arrow") || key === "Home") && on.matches("[type=range], [type=radio], pre, .scroll")) return;
  if (on.id === "map" && key.startsWith("Arrow")) stepMap(key === "ArrowLeft" || key === "ArrowUp" ? -1 : 1);
  else if (/^[1-9]$/.test(key) && runs.length > 1) choose(Number(key) - 1);
  else if (Object.hasOwn(KEYS, key.toLowerCase())) KEYS[key.toLowerCase()]();
  else if (Object.hasOwn(KEYS, key)) KEYS[key]();
  else return;
  event.preventDefault();
}

export function listen() {
  const on = (selector, type, act) => $$(selector).forEach((element) => element.addEventListener(type, (event) => act(element, event)));
  document.addEventListener("keydown", onKey);
  on("[data-play]", "click", toggle);
  on("#seek", "input", (slider) => seek(Number(slider.value)));
  on("#loop", "change", (box) => setLoop(box.checked));
  on("#volume", "input", (slider) => state.master && glide(state.master.gain, Number(slider.value)));
  on("#choose, input[name=run], input[name=play-run]", "change", (choice) => choose(Number(choice.value)));
  on("#equal", "change", (box) => setMode(box.checked ? "equal" : "calibrated"));
  on("#heard", "change", (choice) => setLong(choice.value === "long"));
  on("#compare-a, #compare-b", "change", () => { endTest(); showDifference(); });
  on("#abx-begin", "click", beginTest);
  on("[data-abx]", "click", (button) => ABX[button.dataset.abx]());
  on("#film-play", "click", playFilm);
  on("#film-real", "click", realTime);
  on("#film-rate", "change", showRate);
  on("#film-seek", "input", (slider) => { stopFilm(); seekFilm(Number(slider.value)); });
  on(".film", "chart-seek", (_, event) => seekFilmTo(event));
  on("#before", "click", () => stepMap(-1));
  on("#after", "click", () => stepMap(1));
  on("[data-wav]", "click", saveRecord);
  on("[data-copy]", "click", (button) => copy($(`#${button.dataset.copy}`).textContent, button));
  document.addEventListener("chart-seek", seekByClick);
  for (const player of $$("audio")) player.addEventListener("play", () => playAlone(player));
}

/** Boxes that hold more than they show can be scrolled by keyboard, the others are no stop of Tab. */
export function markScrolling() {
  for (const box of $$(".scroll")) {
    const wide = box.scrollWidth > box.clientWidth + 1;
    const long = box.scrollHeight > box.clientHeight + 1;
    const label = !long ? "scrolls sideways" : wide ? "scrolls" : "scrolls down";
    for (const [name, value] of [["tabindex", "0"], ["role", "group"], ["aria-label", label]]) {
      if (wide || long) box.setAttribute(name, value);
      else box.removeAttribute(name);
    }
  }
}

export function playAlone(player) {
  if (state.wanted) pause();
  for (const other of $$("audio")) if (other !== player) other.pause();
}
