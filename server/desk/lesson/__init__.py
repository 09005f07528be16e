"""The lesson of a class while it goes on: its page, its changes, and its view for the projector."""
