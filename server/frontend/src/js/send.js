// Send a form without leaving the page.

import { announce } from "./follow.js";

// {accepted: what the server answers} or {refusal: its sentence, undefined when it cannot be reached}.
export async function post(address, body) {
  const timer = setTimeout(() => announce("Envoi en cours"), 400);
  const response = await fetch(address, { method: "POST", body, headers: { Accept: "application/json" } }).catch(
    () => null,
  );
  clearTimeout(timer);
  const answer = await readAnswer(response);
  return response?.ok && answer ? { accepted: answer } : { refusal: answer?.detail };
}

// JSON when all went well; a refusal may also come as a page, whose sentence is what matters.
async function readAnswer(response) {
  if (!response) return null;
  if (response.headers.get("content-type")?.includes("json")) return response.json().catch(() => null);
  const parsed = new DOMParser().parseFromString(await response.text(), "text/html");
  return { detail: parsed.getElementById("detail")?.textContent };
}
