// ---- the path of the ball on the plate, from above ----

import { $, modulo } from "./core.js";
import { digits } from "./play_meter.js";
import { live, liveOf } from "./play_live.js";

const [WIDE, HIGH, EDGE] = [320, 150, 8]; // of the picture, and free at its edges
const BAND = 24; // height of the picture of a track on a plate without edges
const mm = (metres) => `${digits(1e3 * metres, 3)} mm`;

/** Return length and width [m] of the plate as it is set, or null for one without edges. */
function sidesNow() {
  const { settings, fixed } = liveOf(), { length, width } = live.settings;
  if (!settings.length) return null;
  return [length, fixed.sideRatio ? length / fixed.sideRatio : width];
}

/** Return the places of a plate with edges in the picture: its corner, and how a place on it is drawn. */
function planOf([length, width]) {
  const scale = Math.min((WIDE - 2 * EDGE) / length, (HIGH - 2 * EDGE) / width);
  const left = (WIDE - scale * length) / 2, bottom = (HIGH + scale * width) / 2;
  return { scale, left, bottom, at: ([x, y]) => [left + scale * x, bottom - scale * y] };
}

/** Return the share of a path to and fro, or of a closed track, at which a ball is. */
function shareOf(ball, length, isBothWays) {
  if (!isBothWays) return modulo(ball / length, 1);
  const share = modulo(ball / length, 2);
  return share < 1 ? share : 2 - share;
}

/** Draw plate and path of the chosen run, and the ball at its place. */
export function drawPlan(ball) {
  const { ends } = liveOf(), sides = sidesNow(), track = live.report?.state.length, start = live.sounding?.prepared.start ?? 0;
  const plan = sides ? planOf(sides) : null;
  const line = plan ? (ends.length > 1 ? ends.map(plan.at) : null) : [[EDGE, HIGH / 2], [WIDE - EDGE, HIGH / 2]];
  const long = !plan ? track : ends.length > 1 ? Math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]) : 0;
  const share = long && line ? shareOf(ball - start, long, Boolean(plan)) : 0;
  const [from, to] = line ?? [plan.at(ends[0]), plan.at(ends[0])], place = [0, 1].map((axis) => from[axis] + share * (to[axis] - from[axis]));
  $("#play-plan-plate").setAttribute("d", plan ? `M${plan.left} ${plan.bottom}h${plan.scale * sides[0]}v${-plan.scale * sides[1]}h${-plan.scale * sides[0]}Z` : "");
  $("#play-plan-path").setAttribute("d", line ? `M${from.join(" ")}L${to.join(" ")}` : "");
  $("#play-plan").setAttribute("viewBox", plan ? `0 0 ${WIDE} ${HIGH}` : `0 ${HIGH / 2 - BAND / 2} ${WIDE} ${BAND}`);
  $("#play-plan-contact").style.display = plan ? "" : "none";
  for (const [circle, [x, y]] of [["#play-plan-ball", place], ["#play-plan-contact", from]]) {
    $(circle).setAttribute("cx", x.toFixed(1));
    $(circle).setAttribute("cy", y.toFixed(1));
  }
  $("#play-plan-words").textContent = wordsOf(sides, ends, long);
}

/** Say what the picture shows, and where the plate is heard. */
function wordsOf(sides, ends, long) {
  if (!sides) return long ? `From above: the solved track of ${mm(long)}, over which the ball rolls again and again on a plate without edges.` : "From above: the solved track on a plate without edges.";
  const plate = `From above: the plate of ${mm(sides[0])} x ${mm(sides[1])}`;
  if (ends.length > 1) return `${plate}, and the path of ${mm(long)} on which the ball goes to and fro. The plate sounds as if the ball stayed at the ring.`;
  return `${plate}. Its modes are those of a ball that stays at the ring, while its surface passes.`;
}
