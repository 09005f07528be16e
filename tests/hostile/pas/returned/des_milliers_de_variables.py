# left: variables
def suivre():
    for lettre in "abc":
        exec("\n".join(f"{lettre}{k} = {k}" for k in range(500)), globals())
    exec("def large():\n " + ";".join(f"v{k}={k}" for k in range(500)) + "\n return 1", globals())
    return "rien"
exec(compile("def large():\n " + ";".join(f"v{k}={k}" for k in range(500)) + "\n return 1", "solution.py", "exec"))
petite = suivre
def suivre():
    large()
    return petite()
