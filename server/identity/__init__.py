"""Who one is: accounts, guests, sessions, tokens, invitations."""
