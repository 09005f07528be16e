"""Mails that teachers ask for: subscriptions, a queue with retries, the server that takes them."""
