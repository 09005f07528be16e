"""Declared exercises that teachers write in the browser: drafts, trials behind the walls, published versions."""
