// ---- the blind test: is X the run A or the run B? ----

import { $, $$, state } from "./core.js";
import { mix, play } from "./player.js";
import { pair } from "./compare.js";

const test = { x: null, trials: 0, right: 0 };
const sides = () => ({ a: pair()[0], b: pair()[1], x: test.x });

/** Return the probability of at least so many right answers by chance. */
function byChance(right, trials) {
  let [sum, term] = [0, 0.5 ** trials];
  for (let k = 0; k <= trials; k++) {
    if (k >= right) sum += term;
    term *= (trials - k) / (k + 1);
  }
  return sum;
}

/** Play a side, a, b or x, and mark its button; without a side, the chosen run. */
function hearSide(side = null) {
  state.blind = sides()[side] ?? null;
  for (const button of $$("[data-abx][aria-pressed]")) button.ariaPressed = String(button.dataset.abx === side);
  if (state.wanted) mix();
  else if (side) play();
}

/** Make X one of both runs in random order. */
function chooseX() {
  const [a, b] = pair();
  test.x = Math.random() < 0.5 ? a : b;
  $("#abx").disabled = a === b;
}

export function beginTest() {
  Object.assign(test, { trials: 0, right: 0 });
  $("#equal").checked = true; // otherwise the level alone would tell the runs apart
  mix();
  chooseX();
  $("#abx-result").textContent = $("#abx").disabled ? "A and B are the same run." : "Listen, then say what X is.";
}

export function endTest() {
  if (!$("#abx")) return;
  hearSide();
  $("#abx").disabled = true;
  $("#abx-result").textContent = "";
}

function answer(side) {
  const isRight = sides()[side] === test.x;
  test.trials += 1;
  test.right += isRight;
  const percent = 100 * byChance(test.right, test.trials), chance = percent < 0.1 ? "less than 0.1" : Number(percent.toPrecision(2));
  $("#abx-result").textContent = `${isRight ? "Right" : "Wrong"}. ${test.right} of ${test.trials} right; guessing gives that or more in ${chance} % of tests.`;
  chooseX();
  if ($("[data-abx=x]").ariaPressed === "true") hearSide("x"); // the new one
}

/** Act on a button: a, b and x are heard, is-a and is-b are answers. */
export const pressTest = ({ dataset: { abx } }) => (abx in sides() ? hearSide(abx) : answer(abx.slice(-1)));
