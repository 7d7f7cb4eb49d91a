// ---- player: records loop in step, but those of what ends, and one of them is heard ----

import { $, $$, lengthOf, ownTime, position, runs, seconds, solvedTime, soundOf, state } from "./core.js";
import { RATE } from "../engine/rate.js";
import { RESTING_MS, audioContext, glide, restContext, soundAlone, sounds, starting, stopVoice } from "./audio.js";
import { roundOf } from "./records.js";
import { mixRoom } from "./room.js";
import { showMap } from "./contact.js";
import { setPlayhead } from "./chart_touch.js";
import { showHeard } from "./heard.js";

const STILL_MS = 2000; // without a sound after which the page says so
const READY_S = 0.05; // within which a record is ready, and begins whole, although the clock of the audio went on

const heardRun = () => state.blind ?? state.run;
const gainOf = (number) => (number === heardRun() ? soundOf(number).playback[$("#equal")?.checked ? "equal" : "calibrated"] : 0);

/** Tell whether the record of a run does not go round, and is over. */
const hasEnded = (number) => soundOf(number).ends && ownTime(number) >= lengthOf(number);

/** Make one run audible; only gains change. */
export function mix() {
  state.voices?.forEach((voice, number) => voice && glide(voice.gain, gainOf(number)));
  mixRoom();
}

/** Start the records of all runs in step, each as soon as it is decoded. */
function startVoices() {
  const { context } = state, voices = runs.map(() => null);
  const first = context.currentTime;
  Object.assign(state, { voices, origin: first - state.at });
  runs.forEach(async (_, number) => {
    const { lap: { begin, end, overlap }, ends } = soundOf(number);
    const buffer = await roundOf(number);
    if (voices !== state.voices || hasEnded(number)) return;
    const source = new AudioBufferSourceNode(context, { buffer, loop: !ends, loopStart: (begin + overlap) / RATE, loopEnd: end / RATE });
    const gain = new GainNode(context, { gain: 0 });
    source.connect(gain).connect(state.master);
    const now = context.currentTime, when = now - first < READY_S ? first : now;
    source.start(when, ownTime(number, when - state.origin));
    voices[number] = { source, gain };
    glide(gain, gainOf(number));
  });
}

function stopVoices() {
  state.at = position();
  state.voices?.filter(Boolean).forEach(stopVoice);
  state.voices = null;
}

/** Show a note while the browser waits for a sound device. */
function sayIfStill() {
  $("#no-sound").hidden = !state.wanted || state.context.state === "running";
}

export async function play() {
  if (state.wanted) return;
  soundAlone(pause);
  state.wanted = true;
  showButton();
  setTimeout(sayIfStill, STILL_MS);
  await starting(() => Promise.all([audioContext().resume(), roundOf(heardRun())]));
  if (!state.wanted || state.voices) return;
  $("#no-sound").hidden = true;
  if (hasEnded(heardRun())) state.at = 0;
  startVoices();
  tick();
}

export function pause() {
  state.wanted = false;
  stopVoices();
  setTimeout(restContext, RESTING_MS);
  showButton();
  render();
}

/** Move the playhead to a time in the record of the chosen run. */
export function seek(time) {
  const goesOn = state.voices !== null;
  stopVoices();
  state.at = Math.max(0, time);
  if (goesOn) startVoices();
  render();
}

// ---- playhead ----

function tick() {
  if (!state.voices) return;
  if (hasEnded(heardRun())) return pause();
  render();
  requestAnimationFrame(tick);
}

const WORDS = { played: "Play", released: "Released power" };

function showButton() {
  for (const button of $$("[data-play]")) {
    const sounds = state.wanted && state.released === (button.dataset.play === "released");
    button.querySelector("span").textContent = sounds ? "Pause" : WORDS[button.dataset.play];
    button.toggleAttribute("data-playing", sounds);
  }
}

/** Hear what plays first, or the released power. */
export function hear(released) {
  if (state.released === released) return;
  stopVoices();
  state.released = released;
  showHeard();
  if (state.wanted) startVoices();
  showButton();
  render();
}

export function render() {
  const time = ownTime(state.run), length = lengthOf(state.run);
  Object.assign($("#seek"), { max: length, value: time });
  $("#seek").setAttribute("aria-valuetext", seconds(time));
  $("#heard").style.setProperty("--at", time / length);
  $("#time").textContent = `${seconds(time)} / ${seconds(length)}`;
  showPlayheads();
  showMap();
}

/** Move the playheads of charts over time, but those of the slow motion. */
function showPlayheads() {
  for (const figure of $$("figure.timeline")) {
    if (figure.plot && !figure.closest(".film")) setPlayhead(figure.plot, solvedTime(figure.plot.chart.run));
  }
}

sounds.push({ stop: pause, isHeard: () => state.wanted || state.voices !== null });
