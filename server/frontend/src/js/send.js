// Send a form without leaving the page.

import { announce } from "./follow.js";

const PROBLEM = "urn:balise:probleme:";
const STORAGE_FULL = 507;

// The headers of a request for the account that the page shows: the server refuses it for any other.
export function headersFor(account) {
  return { Accept: "application/json", "Balise-Compte": account };
}

// {accepted: the answer} or {refusal: its sentence, undefined when the server cannot be reached; problem: its document;
// retryAfter: after how many seconds the same may be sent again, where nothing of it was stored}.
export async function post(address, body, account) {
  const timer = setTimeout(() => announce("Envoi en cours"), 400);
  const response = await fetch(address, { method: "POST", body, headers: headersFor(account) }).catch(() => null);
  clearTimeout(timer);
  const answer = await readAnswer(response);
  if (response?.ok && answer) return { accepted: answer };
  const retryAfter = response?.status === STORAGE_FULL ? Number(response.headers.get("retry-after")) : 0;
  return { refusal: answer?.detail, problem: answer ?? {}, retryAfter };
}

// The fields of a page's form that say for what it was drawn; they are no part of what is written.
export const STATE_FIELDS = ["pour", "controle", "depuis"];

export function withState(form, body) {
  for (const name of STATE_FIELDS) if (form.elements[name]) body.set(name, form.elements[name].value);
  return body;
}

// The step by which a refused page goes on, or null: log in and come back, or send all the same.
export function wayOn(form, problem) {
  if (problem.type === `${PROBLEM}session-terminee`) {
    const link = document.createElement("a");
    link.href = problem.login;
    return labelled(link, "Se connecter et revenir ici");
  }
  if (!problem.button) return null;
  const button = document.createElement("button");
  button.type = "button";
  button.addEventListener("click", () => {
    adopt(form, problem);
    form.requestSubmit();
  });
  return labelled(button, problem.button);
}

// The form stands now for what the server has said.
export function adopt(form, { account, ...state }) {
  if (account) form.dataset.account = form.elements.pour.value = account;
  for (const name of STATE_FIELDS) if (name in state && form.elements[name]) form.elements[name].value = state[name];
}

function labelled(element, text) {
  element.className = "button";
  element.textContent = text;
  return element;
}
// JSON when all went well; a refusal may also come as a page, whose sentence is what matters.
async function readAnswer(response) {
  if (!response) return null;
  if (response.headers.get("content-type")?.includes("json")) return response.json().catch(() => null);
  const parsed = new DOMParser().parseFromString(await response.text(), "text/html");
  return { detail: parsed.getElementById("detail")?.textContent };
}
