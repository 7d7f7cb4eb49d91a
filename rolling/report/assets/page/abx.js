// ---- the blind test: is X the run A or the run B? ----

import { $, $$, state } from "./core.js";
import { mix, play } from "./player.js";
import { setMode } from "./choices.js";
import { pair } from "./compare.js";

export const abx = { x: null, trials: 0, right: 0 };

/** Probability to have at least so many right by chance. */
export function byChance(right, trials) {
  let [sum, term] = [0, 0.5 ** trials];
  for (let k = 0; k <= trials; k++) {
    if (k >= right) sum += term;
    term *= (trials - k) / (k + 1);
  }
  return sum;
}

/** Marks the button that is heard: a, b or x; none without a name. */
export function press(name) {
  for (const button of $$("[data-abx][aria-pressed]")) button.setAttribute("aria-pressed", String(button.dataset.abx === name));
}

/** Lets a run through under the name of a button. */
export function hearBlind(name, number) {
  state.blind = number;
  press(name);
  if (state.wanted) mix();
  else play();
}

export function beginTest() {
  Object.assign(abx, { trials: 0, right: 0 });
  setMode("equal"); // otherwise the level alone would tell the runs apart
  chooseX();
  $("#abx-result").textContent = "Listen, then say what X is.";
}

/** Makes X one of both runs in random order. */
export function chooseX() {
  const [a, b] = pair();
  abx.x = Math.random() < 0.5 ? a : b;
  for (const button of $$("[data-abx]")) button.disabled = a === b;
}

export function endTest() {
  abx.x = state.blind = null;
  press();
  for (const button of $$("[data-abx]")) button.disabled = true;
  if ($("#abx-result")) $("#abx-result").textContent = "";
  if (state.playing) mix();
}

export function answer(number) {
  const right = number === abx.x;
  abx.trials += 1;
  abx.right += right;
  const percent = 100 * byChance(abx.right, abx.trials);
  const chance = percent < 0.1 ? "less than 0.1" : Number(percent.toPrecision(2));
  const text = `${right ? "Right" : "Wrong"}. ${abx.right} of ${abx.trials} right; guessing gives that or more in ${chance} % of tests.`;
  $("#abx-result").textContent = text;
  chooseX();
  if ($("[data-abx=x]").ariaPressed === "true") hearBlind("x", abx.x); // the new one
}

export const ABX = {
  a: () => hearBlind("a", pair()[0]),
  b: () => hearBlind("b", pair()[1]),
  x: () => hearBlind("x", abx.x),
  "is-a": () => answer(pair()[0]),
  "is-b": () => answer(pair()[1]),
};
