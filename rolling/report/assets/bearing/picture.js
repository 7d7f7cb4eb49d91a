// The picture of a bearing: rings, balls and cage that turn, and the loads of the balls around them.

import { RATE } from "../engine/rate.js";
import { frequenciesAt, loadAt, rest } from "./model.js";
import { $, digits, state } from "./state.js";

const SVG = "http://www.w3.org/2000/svg";
const EDGE = 76; // of the outer ring, in parts of the picture, which reaches to 100
const BASE = 79; // where the bars of the loads begin
const LONGEST = 19; // bar of a load
const MOST_STEP_S = 0.1; // between two frames, after which a hidden page does not catch up
const ZONE_STEPS = 120;
const DEGREES = 180 / Math.PI;

const parts = {}; // elements that move

/** Make an element of SVG within another. */
export function draw(parent, name, attributes = {}, text = "") {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  parent.append(element);
  return element;
}

/** Return the place in the picture of a radius and an angle; the load zone's middle, angle 0, is below. */
const placeOf = (radius, angle) => [radius * Math.sin(angle), radius * Math.cos(angle)];
const turned = (angle) => `rotate(${(-angle * DEGREES).toFixed(3)})`; // angles grow against the clock

/** Return the path of a ring between two radii. */
function ringPath(inner, outer) {
  const circle = (radius, sweep) => `M0 ${-radius}A${radius} ${radius} 0 1 ${sweep} 0 ${radius}A${radius} ${radius} 0 1 ${sweep} 0 ${-radius}Z`;
  return circle(outer, 1) + circle(inner, 0);
}

/** Draw the chosen bearing anew. */
export function drawBearing() {
  const svg = $("#bearing");
  svg.replaceChildren();
  const { drawn, bearing } = state.run;
  const scale = EDGE / drawn.outer;
  const of = (radius) => radius * scale;
  parts.zone = draw(svg, "path", { class: "zone" });
  const ring = (name, inner, outer) => {
    const group = draw(svg, "g");
    draw(group, "path", { class: `ring ${name}`, d: ringPath(of(inner), of(outer)) });
    draw(group, "path", { class: "mark", d: `M0 ${of(inner) + 1}V${of(outer) - 1}` });
    return group;
  };
  parts.outer = ring("outer", drawn.outerRaceway, drawn.outer);
  parts.inner = ring("inner", drawn.bore, drawn.innerRaceway);
  parts.cage = draw(svg, "g");
  draw(parts.cage, "circle", { class: "cage", r: of(drawn.pitch) });
  parts.balls = [];
  parts.bars = [];
  for (let j = 0; j < bearing.balls; j++) {
    const [x, y] = placeOf(of(drawn.pitch), (2 * Math.PI * j) / bearing.balls);
    const seat = draw(parts.cage, "g", { transform: `translate(${x} ${y})` });
    draw(seat, "circle", { class: j === drawn.faultBall ? "ball faulty" : "ball", r: of(drawn.ball) });
    const spun = draw(seat, "g");
    draw(spun, "path", { class: "mark", d: `M0 ${0.35 * of(drawn.ball)}V${0.9 * of(drawn.ball)}` });
    parts.balls.push(spun);
    parts.bars.push(draw(svg, "path", { class: "bar" }));
  }
  parts.load = draw(svg, "g");
  showZone();
  showTurn();
}

/** Show the load zone at rest: the load of a ball at each angle, by the settings. */
export function showZone() {
  const { bearing, settings } = { bearing: state.run.bearing, settings: state.settings };
  const balanced = rest(bearing, settings.axial, settings.radial);
  const loads = [];
  for (let k = 0; k < ZONE_STEPS; k++) {
    loads.push(loadAt(bearing, (2 * Math.PI * k) / ZONE_STEPS, balanced.place));
  }
  parts.largest = Math.max(...loads);
  const points = loads.map((load, k) => placeOf(BASE + (LONGEST * load) / parts.largest, (2 * Math.PI * k) / ZONE_STEPS));
  const outline = points.map(([a, b]) => `${a.toFixed(2)} ${b.toFixed(2)}`).join("L");
  parts.zone.setAttribute("d", `M${outline}Z${ringPath(BASE - 0.01, BASE)}`);
  const carrying = balanced.loads.filter((load) => load > 0).length;
  $("#zone").textContent = `${carrying} of ${bearing.balls} balls carry; the largest load of a ball is ${digits(parts.largest)}\u00a0N.`;
}

/** Show rings, balls and loads at the time of the picture. */
export function showTurn() {
  const { bearing, drawn } = state.run;
  const hz = frequenciesAt(bearing, state.settings.rpm);
  const angle = (name) => 2 * Math.PI * ((hz[name] * state.time) % 1);
  parts.inner.setAttribute("transform", turned(angle("inner")));
  parts.outer.setAttribute("transform", turned(angle("outer")));
  parts.cage.setAttribute("transform", turned(angle("cage")));
  const spin = drawn.turning === "inner" ? -angle("spin") : angle("spin");
  for (const ball of parts.balls) ball.setAttribute("transform", turned(spin));
  const loads = loadsNow();
  parts.bars.forEach((bar, j) => {
    const place = angle("cage") + (2 * Math.PI * j) / bearing.balls;
    const [x0, y0] = placeOf(BASE, place);
    const [x1, y1] = placeOf(BASE + LONGEST * Math.min(loads[j] / parts.largest, 1.1), place);
    bar.setAttribute("d", `M${x0.toFixed(2)} ${y0.toFixed(2)}L${x1.toFixed(2)} ${y1.toFixed(2)}`);
  });
}

/** Return the loads of the balls [N] at the time of the picture, or those at rest. */
function loadsNow() {
  const { moved, run } = state;
  const { balls } = run.bearing;
  const cage = frequenciesAt(run.bearing, state.settings.rpm).cage;
  // The record goes round in whole turns of the cage, so that the balls stay where they are drawn.
  const turns = moved ? Math.floor((moved.loads.length / balls / RATE) * moved.loadEvery * cage) : 0;
  if (turns < 1 || moved.settings.rpm !== state.settings.rpm) {
    return rest(run.bearing, state.settings.axial, state.settings.radial, 2 * Math.PI * cage * state.time).loads;
  }
  const seconds = turns / cage;
  const past = (((state.time - moved.begin) % seconds) + seconds) % seconds;
  const first = Math.floor((past * RATE) / moved.loadEvery) * balls;
  return moved.loads.subarray(first, first + balls);
}

let last = 0;

/** Turn on by a frame. */
function turnFrame(now) {
  if (!state.turning) return;
  const passed = Math.min((now - last) / 1000, MOST_STEP_S);
  last = now;
  state.time += passed / state.slow;
  showTurn();
  requestAnimationFrame(turnFrame);
}

/** Let the bearing turn, or stop it. */
export function turn(wanted) {
  state.turning = wanted;
  $("#turn").setAttribute("aria-pressed", String(wanted));
  $("#turn").textContent = wanted ? "Stop" : "Turn";
  last = performance.now();
  if (wanted) requestAnimationFrame(turnFrame);
}
