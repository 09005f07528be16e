// An OpenID Connect server, `oidc-provider`, on a port of this machine: run by the Node of its own environment.
// Usage: node oidc_peer.mjs NODE_MODULES PORT RETURN-ADDRESS LOGOUT-ADDRESS
import { pathToFileURL } from "node:url";

const [modules, port, back, logout] = process.argv.slice(2);
const { Provider } = await import(pathToFileURL(`${modules}/oidc-provider/lib/index.js`));

const provider = new Provider(`http://127.0.0.1:${port}`, {
  clients: [{
    client_id: "balise",
    client_secret: "secret-of-a-test",
    redirect_uris: [back],
    grant_types: ["authorization_code"],
    response_types: ["code"],
    backchannel_logout_uri: logout,
    backchannel_logout_session_required: true,
  }],
  claims: { openid: ["sub"], profile: ["name", "given_name", "family_name"], groups: ["groups"] },
  scopes: ["openid", "groups", "profile"],
  features: {
    backchannelLogout: { enabled: true },
    devInteractions: { enabled: true },
    rpInitiatedLogout: { enabled: true },
  },
  pkce: { required: () => true },
  cookies: { keys: ["of a test"] },
  // Ours is on this machine too, where it does not send orders by itself.
  fetch: (address, { dispatcher, ...options }) => fetch(address, options),
  findAccount: (_, sub) => ({
    accountId: sub,
    claims: () => ({
      sub,
      name: "Ada Lovelace",
      given_name: "Ada",
      family_name: "Lovelace",
      groups: ["/classes/L2 info", "/roles/etudiant"],
    }),
  }),
});
provider.on("backchannel.error", (_, error) => console.error("logout refused", error, error.response));
provider.on("backchannel.success", () => console.error("logout accepted"));
provider.listen(Number(port), "127.0.0.1", () => console.log("ready"));
