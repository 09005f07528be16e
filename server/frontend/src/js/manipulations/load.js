// Where a manipulation comes from: the service, unless an archive puts something else in its place.

import { fromServer } from "../replays/source.js";

export const Origin = {
  answer: fromServer,

  /** The script that follows the hand, as a module. */
  script: (address) => import(new URL(`${address}/main.js`, location.href).href),
};

export const load = (address, settings = {}) => Origin.answer(address, settings);
