"""Server and version of this client; the service writes its own when it hands the client out."""

SERVER = ""
VERSION = ""
