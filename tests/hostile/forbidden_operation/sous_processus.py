import subprocess
def repondre(contexte):
    return subprocess.run(["id"], capture_output=True).stdout.decode()
