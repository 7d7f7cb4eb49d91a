// ---- the beginning of a page without players: charts alone ----

import { openCharts } from "./chart.js";

document.documentElement.classList.add("scripted");
openCharts(JSON.parse(document.querySelector("#data").textContent).charts, []);
