// ---- two runs compared: the difference of their spectra, and the blind test ----

import { $, $$, data, runs, state } from "./core.js";
import { openChart } from "./chart.js";
import { showLoudness } from "./heard.js";
import { mix, play } from "./player.js";

const pair = () => ["#compare-a", "#compare-b"].map((selector) => Number($(selector).value));

/** Return the band differences [dB] of two runs with standard uncertainties, null without a level. */
function differences(a, b) {
  return data.bands.map((_, band) => {
    const [one, other] = [runs[a], runs[b]].map(({ bands, spreads }) => [bands[band], spreads[band]]);
    if (one[0] === null || other[0] === null) return null;
    return [other[0] - one[0], Math.hypot(one[1] ?? 0, other[1] ?? 0)];
  });
}

/** Draw the difference B - A of the chosen runs. */
export function showDifference() {
  const figure = $("#difference");
  if (!figure) return;
  const [a, b] = pair(), levels = differences(a, b), middle = data.bands.map(Number), half = 10 ** 0.05;
  const known = levels.flatMap((level, k) => (level ? [{ x: middle[k], value: level[0], spread: level[1] }] : []));
  const ends = known.flatMap(({ value, spread }) => [value - Math.min(spread, 6), value + Math.min(spread, 6)]), room = [Math.min(-1, ...ends), Math.max(1, ...ends)];
  const round = (value) => Number(value.toFixed(3));
  openChart(figure, {
    title: `${runs[b].label} minus ${runs[a].label}`, note: "third octaves, Z-weighted",
    x: { label: "third octave, nominal mid frequency", unit: "Hz", log: true, limits: [middle[0] / half, middle.at(-1) * half], names: data.bands.map((name, k) => [middle[k], shortName(name)]) },
    y: [{ label: "B − A", unit: "dB", log: false, limits: room.map((limit) => 1.05 * limit), names: [] }],
    xs: [known.map(({ x }) => x)], curves: [{ name: "", colour: "#0072b2", dash: "-", marker: "o" }], paints: [`var(--run-${b})`],
    parts: [
      ...known.map(({ x, value }) => ({ kind: "bar", of: 0, alpha: 0.6, ends: [x / half ** 0.8, x * half ** 0.8, 0, round(value)] })),
      { kind: "errors", of: 0, x: 0, low: known.map(({ value, spread }) => round(value - spread)), high: known.map(({ value, spread }) => round(value + spread)) },
      { kind: "rule", along: false, at: 0 },
    ],
  });
}

const shortName = (name) => (Number(name) >= 1000 ? `${Number(name) / 1000}k` : name);

// ---- the blind test: is X the run A or the run B? ----

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
  showLoudness();
  chooseX();
  $("#abx-result").textContent = $("#abx").disabled ? "A and B are the same run." : "Listen, then say what X is.";
}

export function endTest() {
  if (!$("#abx")) return;
  hearSide();
  $("#abx").disabled = true;
  $("#abx-result").textContent = "";
}

/** Compare the right answers with guessing, of which half are right on average. */
function chanceOf({ right, trials }) {
  if (2 * right <= trials) return "no more than guessing gives on average";
  const percent = 100 * byChance(right, trials);
  return `guessing gives that or more in ${percent < 0.1 ? "less than 0.1" : Number(percent.toPrecision(2))} % of tests`;
}

function answer(side) {
  const isRight = sides()[side] === test.x;
  test.trials += 1;
  test.right += isRight;
  $("#abx-result").textContent = `${isRight ? "Right" : "Wrong"}. ${test.right} of ${test.trials} right; ${chanceOf(test)}.`;
  chooseX();
  if ($("[data-abx=x]").ariaPressed === "true") hearSide("x"); // the new one
}

/** Act on a button: a, b and x are heard, is-a and is-b are answers. */
export const pressTest = ({ dataset: { abx } }) => (abx in sides() ? hearSide(abx) : answer(abx.slice(-1)));
