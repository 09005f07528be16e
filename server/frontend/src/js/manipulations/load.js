// Where a manipulation comes from: the service, unless an archive puts something else in its place.

export const Origin = {
  /** The answer of a scene; what the server refuses is said in its own words. */
  async answer(address, settings) {
    const query = new URLSearchParams(settings).toString();
    const answer = await fetch(query ? `${address}?${query}` : address, { headers: { Accept: "application/json" } });
    if (!answer.headers.get("content-type")?.includes("json")) throw new Error("Le serveur n’a pas pu calculer.");
    const data = await answer.json();
    if (!answer.ok) throw new Error(data.detail);
    return data;
  },

  /** The script that follows the hand, as a module. */
  script: (address) => import(new URL(`${address}/main.js`, location.href).href),
};

export const load = (address, settings = {}) => Origin.answer(address, settings);
