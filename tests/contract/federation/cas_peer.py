"""A CAS server, `django-cas-server`, on a port of this machine: run by the Python of its own environment.

Usage: cas_peer.py FOLDER PORT SERVICE-PATTERN
"""

import sys
from pathlib import Path

import django
from django.conf import settings
from django.core.management import call_command
from django.urls import include, path

PUPIL = {
    "ENTPersonNom": "Lovelace",
    "ENTPersonPrenom": "Ada",
    "ENTPersonProfils": "National_ELV",
    "ENTPersonStructRattachUAI": "0750001A",
    "ENTEleveClasses": ["ENTStructureSIREN=1,ou=structures$2NDE5", "ENTStructureSIREN=1,ou=structures$GR MATHS"],
}
urlpatterns = []


def main(folder: Path, port: str, pattern: str) -> None:
    applications = ["auth", "contenttypes", "sessions", "messages"]
    middleware = (
        "contrib.sessions.middleware.SessionMiddleware",
        "middleware.csrf.CsrfViewMiddleware",
        "contrib.auth.middleware.AuthenticationMiddleware",
        "contrib.messages.middleware.MessageMiddleware",
    )
    settings.configure(
        SECRET_KEY="of-a-test",
        ALLOWED_HOSTS=["*"],
        ROOT_URLCONF=__name__,
        INSTALLED_APPS=[*(f"django.contrib.{name}" for name in applications), "cas_server"],
        MIDDLEWARE=[f"django.{name}" for name in middleware],
        MIGRATION_MODULES=dict.fromkeys([*applications, "cas_server"]),
        DATABASES={"default": {"ENGINE": "django.db.backends.sqlite3", "NAME": str(folder / "cas.sqlite3")}},
        DEFAULT_AUTO_FIELD="django.db.models.AutoField",
        TEMPLATES=[
            {
                "BACKEND": "django.template.backends.django.DjangoTemplates",
                "APP_DIRS": True,
                "OPTIONS": {"context_processors": ["django.template.context_processors.request"]},
            }
        ],
        STATIC_URL="/static/",
        USE_TZ=True,
        CAS_AUTH_CLASS="cas_server.auth.TestAuthUser",
        CAS_TEST_USER="ada",
        CAS_TEST_PASSWORD="a pass phrase",
        CAS_TEST_ATTRIBUTES=PUPIL,
        CAS_NEW_VERSION_HTML_WARNING=False,
    )
    django.setup()
    call_command("migrate", run_syncdb=True, verbosity=0)
    urlpatterns.append(path("cas/", include("cas_server.urls", namespace="cas_server")))
    from cas_server.models import ReplaceAttributName, ServicePattern

    service = ServicePattern.objects.create(pos=1, name="balise", pattern=pattern, single_log_out=True)
    for name in PUPIL:
        ReplaceAttributName.objects.create(name=name, service_pattern=service)
    call_command("runserver", f"127.0.0.1:{port}", "--noreload")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], sys.argv[3])
