// Steps to be put in order: two lists, and three ways to move a step: drag, arrow keys on its handle, buttons.
//
// The selects that work without script stay in the form, hidden: what is sent is the same.

import { announce } from "../follow.js";

const HELP =
  "Appuyez sur « Placer », ou faites glisser une étape par sa poignée ⠿. " +
  "Au clavier, sur la poignée : flèche droite pour placer, flèche gauche pour écarter, haut et bas pour déplacer.";

export function setUpOrder(question, onChange) {
  const pool = question.querySelector(".pieces");
  const proof = element("ol", "pieces");
  const help = element("p", "soft small", HELP);
  help.id = `${question.id || "etapes"}-aide`;
  pool.before(help, heading("Votre démonstration", proof), proof, heading("À placer, ou à laisser de côté", pool));
  proof.dataset.empty = "Faites glisser une étape ici, ou appuyez sur « Placer ».";
  pool.dataset.empty = "Toutes les étapes sont placées.";
  question.classList.add("order-ready");
  for (const piece of pool.children) dress(piece, help.id);

  const placed = (piece) => piece.parentElement === proof;
  const name = (piece) => `Étape ${piece.dataset.piece}`;
  const selectOf = (piece) => piece.querySelector("select");

  function number() {
    [...proof.children].forEach((piece, place) => {
      selectOf(piece).value = String(place + 1);
    });
    for (const piece of pool.children) selectOf(piece).value = "";
    for (const list of [proof, pool]) {
      list.dataset.count = list.children.length;
      for (const piece of list.children) dressButtons(piece, list === proof);
    }
  }

  function tell(piece) {
    const place = [...proof.children].indexOf(piece) + 1;
    announce(place ? `${name(piece)} : place ${place} sur ${proof.children.length}` : `${name(piece)} laissée de côté`);
  }

  // Moves a piece, keeps the focus where it was, and says where it is now.
  function move(piece, list, before) {
    const focused = piece.contains(document.activeElement) ? document.activeElement : null;
    list.insertBefore(piece, before);
    number();
    (focused && !focused.disabled ? focused : focused && piece.querySelector(".handle"))?.focus();
    tell(piece);
    onChange();
  }

  const actions = {
    up: (piece) => placed(piece) && piece.previousElementSibling && move(piece, proof, piece.previousElementSibling),
    down: (piece) =>
      placed(piece) && piece.nextElementSibling && move(piece, proof, piece.nextElementSibling.nextElementSibling),
    toggle: (piece) => (placed(piece) ? move(piece, pool, null) : move(piece, proof, null)),
  };
  const keys = {
    ArrowUp: actions.up,
    ArrowDown: actions.down,
    ArrowLeft: (piece) => placed(piece) && move(piece, pool, null),
    ArrowRight: (piece) => !placed(piece) && move(piece, proof, null),
  };

  question.addEventListener("click", (event) => {
    const button = event.target.closest("[data-action]");
    if (button) actions[button.dataset.action](button.closest(".piece"));
  });
  question.addEventListener("keydown", (event) => {
    if (!event.target.matches(".handle") || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key](event.target.closest(".piece"));
  });
  setUpDrag(question, [proof, pool], move);

  // After the selects were set, from the server or from a draft.
  function show() {
    const pieces = [...question.querySelectorAll(".piece")];
    const chosen = pieces.filter((piece) => selectOf(piece).value);
    chosen.sort((one, other) => Number(selectOf(one).value) - Number(selectOf(other).value));
    proof.append(...chosen);
    pool.append(...pieces.filter((piece) => !chosen.includes(piece)));
    number();
  }
  return { show };
}

function element(tag, name, text = "") {
  const made = document.createElement(tag);
  made.className = name;
  made.textContent = text;
  return made;
}

let headings = 0;
function heading(text, list) {
  const made = element("h3", "pieces-title", text);
  made.id = `etapes-${(headings += 1)}`;
  list.setAttribute("aria-labelledby", made.id);
  return made;
}

function dress(piece, help) {
  const handle = button("handle", `Étape ${piece.dataset.piece} : déplacer`, "⠿");
  handle.setAttribute("aria-describedby", help);
  piece.prepend(handle);
  const row = element("div", "piece-actions");
  const letter = piece.dataset.piece;
  row.append(
    action("up", `Monter l’étape ${letter}`, "↑"),
    action("down", `Descendre l’étape ${letter}`, "↓"),
    action("toggle", "", ""),
  );
  piece.append(row);
}

function action(kind, label, text) {
  const made = button("piece-button", label, text);
  made.dataset.action = kind;
  return made;
}

function button(name, label, text) {
  const made = element("button", name, text);
  made.type = "button";
  if (label) made.setAttribute("aria-label", label);
  return made;
}

function dressButtons(piece, placed) {
  const [up, down, toggle] = piece.querySelectorAll("[data-action]");
  up.hidden = down.hidden = !placed;
  up.disabled = !piece.previousElementSibling;
  down.disabled = !piece.nextElementSibling;
  toggle.textContent = placed ? "Écarter" : "Placer";
  toggle.setAttribute("aria-label", `${toggle.textContent} l’étape ${piece.dataset.piece}`);
}

// Pointer events serve mouse, pen and finger alike; only the handle starts a drag, so that a finger still scrolls.
function setUpDrag(question, lists, move) {
  question.addEventListener("pointerdown", (event) => {
    const handle = event.target.closest(".handle");
    if (!handle || event.button !== 0) return;
    const piece = handle.closest(".piece");
    let target = null;
    const follow = (moved) => {
      piece.classList.add("dragged");
      scrollNear(moved.clientY);
      target = under(moved, piece, lists);
      mark(question, target);
    };
    const end = (ended) => {
      handle.removeEventListener("pointermove", follow);
      piece.classList.remove("dragged");
      mark(question, null);
      if (ended.type === "pointerup" && target && target.before !== piece) move(piece, target.list, target.before);
    };
    handle.setPointerCapture(event.pointerId);
    handle.addEventListener("pointermove", follow);
    handle.addEventListener("pointerup", end, { once: true });
    handle.addEventListener("pointercancel", end, { once: true });
  });
}

// A proof may be longer than the window.
const EDGE = 70;
function scrollNear(y) {
  if (y < EDGE) window.scrollBy(0, -EDGE / 4);
  else if (y > window.innerHeight - EDGE) window.scrollBy(0, EDGE / 4);
}

// The list under the pointer, and the piece before which it would fall.
function under({ clientX, clientY }, piece, lists) {
  const inside = (list) => {
    const box = list.getBoundingClientRect();
    return clientX >= box.left && clientX <= box.right && clientY >= box.top - 8 && clientY <= box.bottom + 8;
  };
  const list = lists.find(inside);
  if (!list) return null;
  const others = [...list.children].filter((one) => one !== piece);
  const before = others.find((one) => {
    const box = one.getBoundingClientRect();
    return clientY < box.top + box.height / 2;
  });
  return { list, before: before ?? null };
}

function mark(question, target) {
  for (const old of question.querySelectorAll(".drop-here, .drop-before")) old.classList.remove("drop-here", "drop-before");
  target?.list.classList.add("drop-here");
  target?.before?.classList.add("drop-before");
}
