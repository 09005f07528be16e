// Questions of a lesson, marked in place: what is wrong says why, and one may answer again.

export function setUpQuestions(page) {
  const said = parse(page.dataset.said);
  for (const section of page.querySelectorAll(".asked[data-question]")) {
    const form = section.querySelector("form");
    if (form) new Question(form, page.dataset.answers, section.dataset.question, said[section.dataset.question]);
  }
  for (const form of page.querySelectorAll(".recalled form")) new Retrieval(form);
}

class Question {
  constructor(form, address, name, first) {
    this.form = form;
    this.address = address;
    this.name = name;
    this.place = form.querySelector(".asked-mark");
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#check();
    });
    form.addEventListener("change", () => this.place.replaceChildren());
    for (const id of (first ?? "").split(",")) {
      const input = [...form.elements].find((one) => one.value === id && id);
      if (input) input.checked = true;
    }
  }

  async #check() {
    const ids = new FormData(this.form).getAll("reponse").sort();
    if (!ids.length) {
      this.#tell("", "Choisissez d’abord une réponse.");
      return;
    }
    const answer = await fetch(this.address, {
      method: "POST",
      headers: { "Content-Type": "application/json", Accept: "application/json" },
      body: JSON.stringify({ question: this.name, answer: ids.join(",") }),
    }).catch(() => null);
    const told = await answer?.json().catch(() => null);
    if (!answer?.ok || !told) this.#tell("", told?.detail ?? "Le serveur n’a pas répondu. Réessayez.");
    else this.#tell(told.right ? "right" : "wrong", told.right ? "✓ Juste." : "✗ Pas encore.", told.why);
  }

  #tell(kind, words, html = "") {
    tell(this.place, kind, words, html);
  }
}

// A question with fresh numbers: the form is sent as it stands, and marked where it is.
class Retrieval {
  constructor(form) {
    this.form = form;
    this.place = form.querySelector(".asked-mark");
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#check();
    });
    form.addEventListener("input", () => this.place.replaceChildren());
  }

  async #check() {
    const typed = new FormData(this.form);
    if (!typed.get("reponse")) return tell(this.place, "", "Répondez d’abord : essayer de se souvenir apprend plus que relire.");
    const answer = await fetch(this.form.action, {
      method: "POST",
      headers: { Accept: "application/json" },
      body: new URLSearchParams(typed),
    }).catch(() => null);
    const told = await answer?.json().catch(() => null);
    if (!answer?.ok || !told) return tell(this.place, "", told?.detail ?? "Le serveur n’a pas répondu. Réessayez.");
    return tell(this.place, told.right ? "right" : "wrong", told.right ? "✓ Juste." : "✗ Pas cela.", told.why);
  }
}

function tell(place, kind, words, html = "") {
  const head = document.createElement("p");
  head.className = `asked-${kind}`;
  head.textContent = words;
  const why = document.createElement("div");
  why.className = "prose";
  why.innerHTML = html; // the server's own, from the course's files
  place.replaceChildren(head, why);
}

function parse(text) {
  try {
    return JSON.parse(text ?? "{}") ?? {};
  } catch {
    return {};
  }
}
