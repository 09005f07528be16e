"""The version of Balise: the package, the commands, the pages and the verdicts all read it here.

Semantic versioning; `server/docs/versions.md` says what of the API, of authors' Python and of files is stable.
"""

VERSION = "1.0.0"
