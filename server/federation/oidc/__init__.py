"""Sign-in by an OpenID Connect server (Core 1.0): discovery, code flow with PKCE, logout from there."""
