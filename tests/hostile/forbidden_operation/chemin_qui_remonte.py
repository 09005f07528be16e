def repondre(contexte):
    return open("../../../../etc/hostname").read()
