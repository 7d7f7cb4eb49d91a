// ---- start of a gallery: charts, and players with one of two gains for all ----

import { players } from "./plain.js";

const modes = [...document.querySelectorAll("input[name=mode]")];

/** Set the volume of each sound by the chosen gain. */
function setGains() {
  const { value } = modes.find((radio) => radio.checked);
  for (const player of players) player.volume = Math.min(1, Number(player.dataset[value]));
}

for (const radio of modes) radio.addEventListener("change", setGains);
setGains();
