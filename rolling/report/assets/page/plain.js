// ---- start of a page of charts and plain players, of which one sounds at a time ----

import { openCharts } from "./chart.js";
import { listenToCopying } from "./copy.js";

export const players = [...document.querySelectorAll("audio")];
const { charts, labels } = JSON.parse(document.querySelector("#data").textContent);

document.documentElement.classList.add("scripted");
openCharts(charts, labels);
for (const player of players) {
  player.addEventListener("play", () => players.forEach((other) => other !== player && other.pause()));
}
listenToCopying();
