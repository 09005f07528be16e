def repondre(contexte):
    groupe = ValueError("fond")
    for _ in range(5000):
        groupe = ExceptionGroup("\u202e{{ 7*7 }}", [groupe] * 2)
    raise groupe
