def repondre(contexte):
    return eval("[" + "(1, [2], {3: 4})," * 200000 + "]")
