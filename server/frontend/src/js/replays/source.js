// Answers from the server: one request at a time, and of the wishes that come in meanwhile only the last one counts.

export class Source {
  /** Where answers come from: an archive, which has no server, puts its own in this place. */
  static answer = fromServer;

  #wanted = null;
  #busy = false;

  constructor(address, { answered, failed, waiting }) {
    this.address = address;
    this.answered = answered;
    this.failed = failed;
    this.waiting = waiting;
  }

  /** True when something newer is asked for than what was just answered. */
  get waits() {
    return this.#wanted !== null;
  }

  /** Ask for the data with these settings, `{name: text}`. */
  async ask(settings) {
    this.#wanted = settings;
    if (this.#busy) return;
    this.#busy = true;
    this.waiting(true);
    while (this.#wanted) {
      const asked = this.#wanted;
      this.#wanted = null;
      try {
        const data = await Source.answer(this.address, asked);
        this.answered(data);
      } catch (error) {
        if (!this.#wanted) this.failed(error);
      }
    }
    this.#busy = false;
    this.waiting(false);
  }
}

/** The answer of a scene; what the server refuses is said in its own words. */
export async function fromServer(address, settings) {
  const query = new URLSearchParams(settings).toString();
  const answer = await fetch(query ? `${address}?${query}` : address, { headers: { Accept: "application/json" } });
  if (!answer.headers.get("content-type")?.includes("json")) throw new Error("Le serveur n’a pas pu calculer.");
  const data = await answer.json();
  if (!answer.ok) throw new Error(data.detail);
  return data;
}
