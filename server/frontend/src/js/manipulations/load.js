/** The answer of a scene; what the server refuses is said in its own words. */
export async function load(address, settings = {}) {
  const query = new URLSearchParams(settings).toString();
  const answer = await fetch(query ? `${address}?${query}` : address, { headers: { Accept: "application/json" } });
  if (!answer.headers.get("content-type")?.includes("json")) throw new Error("Le serveur n’a pas pu calculer.");
  const data = await answer.json();
  if (!answer.ok) throw new Error(data.detail);
  return data;
}
