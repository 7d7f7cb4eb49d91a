// ---- start of the page, and its events ----

import { $, $$, data, lengthOf, ownTime, runs, say, state } from "./core.js";
import { glide, soundAlone } from "./audio.js";
import { hear, mix, pause, play, render, seek } from "./player.js";
import { listenToHeard, showHeard, showLoudness } from "./heard.js";
import { roundOf, saveRecord } from "./records.js";
import { showRoom } from "./room.js";
import { listenToCopying } from "./copy.js";
import { showStill, timeOfMap } from "./contact.js";
import { playFilm, realTime, seekFilm, seekFilmTo, showFilm, showRate, stopFilm } from "./film.js";
import { openCharts } from "./chart.js";
import { playPatch } from "./places.js";
import { beginTest, endTest, pressTest, showDifference } from "./compare.js";
import { takeRun } from "./play_panel.js";
import { beginPlaying } from "./play_hand.js";

function begin() {
  document.documentElement.classList.add("scripted");
  $("#transport").hidden = false;
  $(".singles").open = false;
  listen();
  openCharts(data.charts, runs.map((run) => run.label));
  new IntersectionObserver(([hero]) => document.documentElement.classList.toggle("beyond", !hero.isIntersecting)).observe($("header"));
  choose(Math.max(0, runs.findIndex((run) => run.playback.calibrated_pa !== null))); // one that can be heard
  beginPlaying();
  showDifference();
  say("");
  roundOf(state.run); // so that Play sounds at once
}

/** Choose the run to hear, and show its parts of the page. */
export function choose(number) {
  if (!(number in runs)) return;
  stopFilm();
  state.run = number;
  endTest();
  mix();
  for (const radio of $$("input[name=run], input[name=play-run]")) radio.checked = Number(radio.value) === number;
  if ($("#choose")) $("#choose").value = number;
  for (const element of $$("[data-only]")) element.hidden = !element.dataset.only.split(" ").includes(String(number));
  say(runs[number].label);
  takeRun(number);
  showHeard();
  showStill();
  showFilm();
  render();
}

const toggle = () => (state.wanted ? pause() : play());

/** Play or pause the sound of a button, what plays first or the released power. */
function pressPlay({ dataset }) {
  const released = dataset.play === "released";
  if (state.released === released) return toggle();
  hear(released);
  play();
}

const step = (share) => seek(ownTime(state.run) + share * lengthOf(state.run));
const KEYS = { " ": toggle, ArrowLeft: () => step(-0.05), ArrowRight: () => step(0.05) };

/** Act on a key that the focused control does not use. */
function onKey(event) {
  const { key, target } = event;
  if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
  if (target.matches("select, textarea, audio, [contenteditable], input:not([type=radio], [type=checkbox], [type=range])")) return;
  if (key === " " && target.matches("button, summary, a, [type=checkbox]")) return;
  if (key.startsWith("Arrow") && target.matches("[type=range], [type=radio], pre, .scroll")) return;
  if (Object.hasOwn(KEYS, key)) KEYS[key]();
  else if (/^[1-9]$/.test(key)) choose(Number(key) - 1);
  else return;
  event.preventDefault();
}

/** Move the playhead, or the slow motion, to a time clicked in a chart. */
function onChartSeek({ target, detail: { run, time } }) {
  if (target.closest(".film")) return seekFilmTo(time);
  if (run !== state.run) choose(run);
  seek(time);
}

function listen() {
  const on = (selector, type, act) => $$(selector).forEach((element) => element.addEventListener(type, () => act(element)));
  document.addEventListener("keydown", onKey);
  document.addEventListener("chart-seek", onChartSeek);
  document.addEventListener("chart-place", ({ detail }) => playPatch(detail));
  on("[data-play]", "click", pressPlay);
  on("#seek", "input", (slider) => seek(Number(slider.value)));
  on("#volume", "input", (slider) => state.master && glide(state.master, Number(slider.value)));
  on("#choose, input[name=run], input[name=play-run]", "change", (choice) => choose(Number(choice.value)));
  on("#equal", "change", () => { mix(); showLoudness(); });
  on("#room", "change", showRoom);
  listenToHeard(seek);
  on("audio", "play", soundAlone);
  on("#compare-a, #compare-b", "change", endTest);
  on("#compare-a, #compare-b", "change", showDifference);
  on("#abx-begin", "click", beginTest);
  on("[data-abx]", "click", pressTest);
  on("#film-play", "click", playFilm);
  on("#film-real", "click", realTime);
  on("#film-rate", "change", showRate);
  on("#film-seek", "input", (slider) => { stopFilm(); seekFilm(Number(slider.value)); });
  on("#map-seek", "input", (slider) => { pause(); seek(timeOfMap(Number(slider.value))); });
  on("[data-wav]", "click", saveRecord);
  listenToCopying(say);
}

begin();
