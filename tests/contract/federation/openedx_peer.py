"""Open edX's own code of LTI 1.3, `lti-consumer-xblock`, on a port of this machine: run by the Python of its own
environment. What it wants of the rest of Open edX stands here: one course, one component, its people, its gradebook.

Usage: openedx_peer.py FOLDER PORT TOOL
"""

import sys
from pathlib import Path
from types import SimpleNamespace

import django
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from django.conf import settings
from django.core.management import call_command
from django.http import HttpResponseRedirect, JsonResponse
from django.urls import include, path

COURSE, COMPONENT = "course-v1:Lycee+ROB+2026", "block-v1:Lycee+ROB+2026+type@lti_consumer+block@balise"
STUDENTS = 130  # more than one page of a list
published: dict[str, list[float]] = {}
urlpatterns = []


class Block(SimpleNamespace):
    """The component, as far as the gradebook asks it."""

    def is_past_due(self) -> bool:
        return False

    def max_score(self) -> float:
        return 1.0

    def set_user_module_score(self, user: str, score: float, *_) -> None:
        published.setdefault(user, []).append(score)


class Person(SimpleNamespace):
    """A person of the course: `prof` teaches it, and `s0`, `s1`… learn there."""

    is_active = is_authenticated = True

    @property
    def role(self) -> str:
        return "staff" if self.name == "prof" else "student"


def recognise(get_response):
    def middleware(request):
        request.user = Person(name=request.COOKIES.get("who", ""))
        return get_response(request)

    return middleware


def members() -> dict[int, dict]:
    names = ["prof", *(f"s{number}" for number in range(STUDENTS))]
    return {
        number: {
            "id": number,
            "external_id": name,
            "username": name,
            "email": f"{name}@lycee.example",
            "name": f"Nom {name}",
            "roles": [Person(name=name).role],
        }
        for number, name in enumerate(names)
    }


def new_key() -> str:
    """Return a private key; Open edX's own generator takes seconds."""
    key = rsa.generate_private_key(65537, 2048)
    form = serialization.Encoding.PEM, serialization.PrivateFormat.TraditionalOpenSSL, serialization.NoEncryption()
    return key.private_bytes(*form).decode()


def main(folder: Path, port: str, tool: str) -> None:
    here = f"http://127.0.0.1:{port}"
    settings.configure(
        SECRET_KEY="of-a-test",
        ALLOWED_HOSTS=["*"],
        ROOT_URLCONF=__name__,
        INSTALLED_APPS=[
            *(f"django.contrib.{name}" for name in ("auth", "contenttypes")),
            "rest_framework", "django_filters", "config_models", "lti_consumer",
        ],
        MIDDLEWARE=["edx_django_utils.cache.middleware.RequestCacheMiddleware", f"{__name__}.recognise"],
        MIGRATION_MODULES=dict.fromkeys(["auth", "contenttypes", "config_models", "lti_consumer"]),
        DATABASES={"default": {"ENGINE": "django.db.backends.sqlite3", "NAME": str(folder / "openedx.sqlite3")}},
        DEFAULT_AUTO_FIELD="django.db.models.AutoField",
        TEMPLATES=[{"BACKEND": "django.template.backends.django.DjangoTemplates", "APP_DIRS": True}],
        STATIC_URL="/static/",
        USE_TZ=True,
        LMS_ROOT_URL=here,
        LTI_BASE=here,
        LTI_API_BASE=here,
        PLATFORM_NAME="Open edX",
        USAGE_ID_PATTERN=r"(?P<usage_id>(?:i4x://?[^/]+/[^/]+/[^/]+/[^@]+(?:@[^/]+)?)|(?:[^/]+))",
    )  # fmt: skip
    from lti_consumer.plugin import compat

    for flag in (
        "external_config",
        "external_user_id_1p1_launches",
        "database_config",
        "external_multiple_launch_urls",
    ):
        setattr(compat, f"get_{flag}_waffle_flag", lambda: SimpleNamespace(is_enabled=lambda *_: False))
    django.setup()
    call_command("migrate", run_syncdb=True, verbosity=0)
    from lti_consumer.api import get_lti_1p3_launch_info, get_lti_1p3_launch_start_url
    from lti_consumer.data import Lti1p3LaunchData
    from lti_consumer.models import CourseAllowPIISharingInLTIFlag, Lti1p3Passport, LtiConfiguration
    from lti_consumer.plugin.views import LtiNrpsContextMembershipViewSet
    from opaque_keys.edx.keys import CourseKey, UsageKey

    course, component = CourseKey.from_string(COURSE), UsageKey.from_string(COMPONENT)
    block = Block(
        display_name="Balise", context_id=course, lti_1p3_passport_id="", weight=1, has_score=True,
        accept_grades_past_due=True, scope_ids=SimpleNamespace(usage_id=component),
    )  # fmt: skip
    compat.load_enough_xblock = compat.load_block_as_user = lambda _: block
    compat.get_user_from_external_user_id = str
    compat.get_course_members = lambda _: members()
    compat.user_has_studio_write_access = lambda user, _: user.role == "staff"
    LtiNrpsContextMembershipViewSet.attach_external_user_ids = lambda *_: None
    CourseAllowPIISharingInLTIFlag.objects.create(course_id=course, enabled=True)
    passport = Lti1p3Passport.objects.create(
        lti_1p3_tool_keyset_url=f"{tool}/lti/cles.json",
        lti_1p3_internal_private_key=new_key(),
        lti_1p3_internal_private_key_id="of-a-test",
    )
    configuration = LtiConfiguration.objects.create(
        version=LtiConfiguration.LTI_1P3,
        config_store=LtiConfiguration.CONFIG_ON_DB,
        location=component,
        lti_1p3_passport=passport,
        lti_1p3_oidc_url=f"{tool}/lti/connexion",
        lti_1p3_launch_url=f"{tool}/lti/lancement",
        lti_advantage_enable_nrps=True,
        lti_advantage_deep_linking_enabled=True,
        lti_advantage_deep_linking_launch_url=f"{tool}/lti/lancement",
    )

    def launch_data(name: str) -> Lti1p3LaunchData:
        return Lti1p3LaunchData(
            user_id=name, user_role=Person(name=name).role, config_id=configuration.config_id,
            resource_link_id=COMPONENT, name=f"Nom {name}", context_id=COURSE, context_type=["course_offering"],
            context_title="Robotique", launch_presentation_document_target="iframe",
        )  # fmt: skip

    def open_component(request, name: str):
        """Begin a launch, or the choice of a content; where one has been chosen, the launch is of it."""
        chosen = configuration.ltidlcontentitem_set.first()
        chooses = "choose" in request.GET
        content = None if chooses or chosen is None else chosen.pk
        address = get_lti_1p3_launch_start_url(launch_data(name), deep_link_launch=chooses, dl_content_id=content)
        answer = HttpResponseRedirect(address)
        answer.set_cookie("who", name)
        return answer

    def describe(_):
        return JsonResponse({**get_lti_1p3_launch_info(launch_data("prof")), "issuer": here})

    urlpatterns.extend(
        [
            path("api/", include("lti_consumer.plugin.urls")),
            path("open/<name>", open_component),
            path("description", describe),
            path("published", lambda _: JsonResponse(published)),
        ]
    )
    call_command("runserver", f"127.0.0.1:{port}", "--noreload")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], sys.argv[3])
