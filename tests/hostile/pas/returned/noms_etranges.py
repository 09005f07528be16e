def suivre():
    exec("é" * 60 + " = 1\n" + "x" * 5000 + " = 2", globals())
    code = compile("def g(" + "\u00e9" * 200 + "=1):\n    a\u0301 = 2\n    return a\u0301", "solution.py", "exec")
    exec(code, espace := {})
    g = espace["g"]
    g()
    g.__code__ = g.__code__.replace(co_name="\u202e\x1b[2J" * 500, co_firstlineno=2**31 - 1)
    g()
    g.__code__ = g.__code__.replace(co_firstlineno=0, co_linetable=b"")
    g()
    return "rien"
