def repondre(contexte):
    for k in range(10**6):
        compile("(" * 60 + "1" + ")" * 60 + "+1" * 900, "x", "eval")
