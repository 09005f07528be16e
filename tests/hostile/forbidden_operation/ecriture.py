import os, numpy
def repondre(contexte):
    with open(os.path.dirname(numpy.__file__) + "/note.txt", "w") as fichier:
        fichier.write("20/20")
