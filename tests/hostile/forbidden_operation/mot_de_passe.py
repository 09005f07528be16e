def repondre(contexte):
    return open("/etc/passwd").read()
