def repondre(contexte):
    erreur = None
    for k in range(100000):
        suivante = ValueError("\x1b[2J<script>" + str(k))
        suivante.__cause__ = erreur
        erreur = suivante
    raise erreur
