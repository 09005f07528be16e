"""The client of one file, `balise.pyz`, which each service hands out at its own version."""
