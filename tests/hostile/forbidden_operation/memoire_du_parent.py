def repondre(contexte):
    with open(f"/proc/{contexte['parent']}/mem", "rb") as memoire:
        return memoire.read(1)
