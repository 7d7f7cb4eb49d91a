// Start of the page of a bearing, and its events.

import { openCharts } from "../page/chart.js";
import { listenToCopying } from "../page/copy.js";
import { drawSpectrum } from "./charts.js";
import { drawBearing, showTurn, showZone, turn } from "./picture.js";
import { hear, soundLatest } from "./sound.js";
import { $, $$, data, digits, state, velocity } from "./state.js";

const motionUnwanted = matchMedia("(prefers-reduced-motion: reduce)");
const sliders = ["rpm", "axial", "radial"];
const worker = { thread: null, busy: false, behind: false };

/** Move the ring at the present settings, or once more when the worker is free. */
function askMotion() {
  if (worker.busy) {
    worker.behind = true;
    return;
  }
  worker.thread ??= openWorker();
  worker.busy = true;
  $("#model").setAttribute("aria-busy", "true");
  worker.thread.postMessage({ bearing: state.run.bearing, settings: { ...state.settings }, bands: state.run.bandsHz });
}

function openWorker() {
  const thread = new Worker(`data:text/javascript;charset=utf-8,${encodeURIComponent($("#engine").textContent)}`);
  thread.onmessage = ({ data: moved }) => {
    worker.busy = false;
    if (worker.behind) {
      worker.behind = false;
      askMotion();
      return;
    }
    state.moved = moved;
    $("#model").setAttribute("aria-busy", "false");
    showLevels();
    drawSpectrum();
    showTurn();
    soundLatest();
  };
  thread.onerror = () => { $("#levels").textContent = "The small model does not start in this browser; picture and lines follow the sliders."; };
  return thread;
}

/** Say what the small model has at the settings, beside the run. */
function showLevels() {
  const numbers = state.moved.levels.map(({ radial }) => velocity(radial));
  const { rpm, axial, radial } = state.settings;
  const at = [`${digits(rpm, 4)} rpm`, axial > 0 && `${digits(axial)} N axial`, radial > 0 && `${digits(radial)} N radial`].filter(Boolean);
  const end = state.run.bandsHz.at(-1)[1] > state.run.bendingHz - 1 ? ", up to the bending of the ring" : "";
  $("#levels").textContent = `At ${at.join(", ")}: ${numbers.slice(0, -1).join(", ")} and ${numbers.at(-1)} µm/s radial${end}.`;
}

/** Return the largest radial load [N] that an axial load holds on the balls; none is too large for lines that turn. */
function mostRadial(axial) {
  const { alpha, balls, curvature } = state.run.bearing;
  return alpha > 0 && curvature === 0 ? (0.9 * axial * Math.cos(Math.PI / balls)) / Math.tan(alpha) : Infinity;
}

/** Take the settings of the sliders, and show what follows at once. */
function takeSliders() {
  for (const name of sliders) state.settings[name] = Number($(`#${name}`).value);
  const radial = $("#radial");
  const most = Math.min(state.run.ranges.radial[1], mostRadial(state.settings.axial));
  if (state.settings.radial > most) {
    state.settings.radial = most;
    radial.value = most;
  }
  const units = { rpm: "rpm", axial: "N", radial: "N" };
  for (const name of sliders) {
    const text = `${digits(state.settings[name], name === "rpm" ? 4 : 3)} ${units[name]}`;
    $(`#${name}-value`).textContent = text;
    $(`#${name}`).setAttribute("aria-valuetext", text);
  }
  showZone();
  showTurn();
  drawSpectrum();
  askMotion();
}

/** Set the sliders to the values of the run. */
function resetSliders() {
  const { ranges, settings } = state.run;
  for (const name of sliders) {
    const slider = $(`#${name}`);
    const [low, high, step] = ranges[name];
    Object.assign(slider, { min: low, max: high, step });
    slider.value = settings[name];
    slider.closest(".slider").hidden = high <= low;
  }
  takeSliders();
}

/** Choose the run to see. */
function choose(number) {
  state.run = data.runs[number];
  state.moved = null;
  state.settings = { ...state.run.settings };
  for (const part of $$("[data-only]")) part.hidden = Number(part.dataset.only) !== number;
  drawBearing();
  resetSliders();
}

function begin() {
  document.documentElement.classList.add("scripted");
  openCharts(data.charts, data.runs.map((run) => run.label));
  listenToCopying();
  choose(0);
  for (const name of sliders) $(`#${name}`).addEventListener("input", takeSliders);
  $("#reset").addEventListener("click", resetSliders);
  $("#turn").addEventListener("click", () => turn(!state.turning));
  $("#slow").addEventListener("change", ({ target }) => { state.slow = Number(target.value); });
  $("#hear").addEventListener("click", () => hear($("#hear").getAttribute("aria-pressed") !== "true"));
  $("#choose")?.addEventListener("change", ({ target }) => choose(Number(target.value)));
  for (const player of $$("audio")) {
    player.addEventListener("play", () => {
      hear(false);
      for (const other of $$("audio")) if (other !== player) other.pause();
    });
  }
  new ResizeObserver(drawSpectrum).observe($("#live-spectrum").parentElement);
  if (!motionUnwanted.matches) turn(true);
}

begin();
