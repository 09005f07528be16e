open('/etc/passwd').read()
def compter_mots(texte):
    return {}
