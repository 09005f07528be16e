import re
def repondre(contexte):
    return bool(re.match(r"(a+)+$", "a" * 60 + "b"))
