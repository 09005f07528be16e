import os, struct
from outils import enfant, fil, trame
def texte(mot):
    return b"s" + struct.pack("<I", len(mot)) + mot
def repondre(contexte):
    champs = {b"kind": texte(b"syntax_error"), b"exception": texte(b"E"), b"line": b"N", b"frames": b"t\0\0\0\0", b"detail": texte(b""),
              b"text": texte(b"closing parenthesis '(' does not match" + b"'('" * 20000 + b"\n")}
    contenu = b"d" + struct.pack("<I", len(champs)) + b"".join(texte(nom) + valeur for nom, valeur in champs.items())
    os.write(fil(), trame(enfant()._token, 20, contenu))
    return 1
