// Drafts written without a name join the account that one then logs in to, as the server has a guest's attempts join it.

import { keep, recall } from "./storage.js";

const NAMELESS = "balise-sans-nom"; // the visitor or the guest whom this browser last was

export function noteAccount() {
  const { account, role } = document.querySelector("[data-part=account]").dataset;
  if (role === "visitor" || role === "guest") keep(NAMELESS, account);
}

// What stands under the key of whom this browser was before, if it is somebody else now: moved away, or null.
export function inherited(account, keyOf) {
  const before = recall(NAMELESS);
  if (before === null || before === account) return null;
  const draft = recall(keyOf(before));
  if (draft !== null) keep(keyOf(before), null);
  return draft;
}
