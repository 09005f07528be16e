import array, os, socket
from outils import fil
def repondre(contexte):
    prise = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, 0, fileno=os.dup(fil()))
    prise.sendmsg([b"20"], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [0, 1]))])
    return "des descripteurs sont partis"
