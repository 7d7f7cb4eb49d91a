// ---- a room behind all sounds of the page, for listening only ----

import { $, data, state } from "./core.js";
import { glide, onContext } from "./audio.js";
import { samplesOf } from "./records.js";

let made = null; // a promise that the room stands behind the sounds

/** Return the gains of direct and diffuse sound for the run that is heard. */
const gains = () => ($("#room")?.checked ? data.room.gains[state.blind ?? state.run] : { direct: 1, diffuse: 0 });

/** Let the gains of the room follow the switch and the run that is heard. */
export function mixRoom() {
  if (!state.room) return;
  const { direct, diffuse } = gains();
  glide(state.direct, direct);
  glide(state.room, diffuse);
}

/** Convolve all that the page plays with the response of the room. */
async function makeRoom() {
  const buffer = await samplesOf($("#room-response"));
  const convolver = new ConvolverNode(state.context, { buffer, disableNormalization: true });
  state.room = new GainNode(state.context, { gain: 0 });
  state.master.connect(convolver);
  convolver.connect(state.room);
  state.room.connect(state.ear);
}

/** Put the room behind the sounds of the page, once it is asked for. */
export async function showRoom() {
  if (state.context && $("#room")?.checked) await (made ??= makeRoom());
  mixRoom();
}

onContext.push(showRoom);
