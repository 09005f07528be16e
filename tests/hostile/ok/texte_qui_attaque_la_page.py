def repondre(contexte):
    print("<script>alert(1)</script>{{ 7*7 }}\x1b[2J\x1b]0;titre\x07\u202erouge\0\ud800")
    return "rien"
