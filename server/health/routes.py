"""What whoever watches the service asks: an orchestrator, a load balancer, Prometheus."""

from secrets import compare_digest
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import JSONResponse

from server.base.app_services import app_service
from server.base.counters import VISITS
from server.base.errors import Forbidden, NotFound, Unauthorised
from server.base.logs import RECENT_ERRORS
from server.base.settings import Settings
from server.database.dependencies import Db
from server.grading.supervisor import WorkerSupervisor
from server.health import service_status
from server.health.metrics import PrometheusMetrics
from server.health.readiness import BROKER_CHECK, Readiness
from server.health.service_status import RecentError, WebProcessStatus
from server.identity.dependencies import ApiAccount
from server.submissions.job_events import JobEvents

router = APIRouter(include_in_schema=False)

SettingsOf = Annotated[Settings, Depends(app_service(Settings))]
MetricsOf = Annotated[PrometheusMetrics, Depends(app_service(PrometheusMetrics))]
EventsOf = Annotated[JobEvents, Depends(app_service(JobEvents))]
SupervisorOf = Annotated[WorkerSupervisor, Depends(app_service(WorkerSupervisor))]
ReadinessOf = Annotated[Readiness, Depends(app_service(Readiness))]
NO_STORE = {"Cache-Control": "no-store"}
SCHEME = "bearer"


@router.get("/healthz")
async def alive() -> Response:
    """That the process answers: whoever gets no answer starts it again. It asks nothing of the database."""
    return JSONResponse({"status": "ok"}, headers=NO_STORE)


@router.get("/readyz")
def ready(readiness: ReadinessOf) -> Response:
    """Whether to send visitors here: 503 where not, with what is amiss. `degraded`: they may come all the same."""
    checks = readiness.checks()
    amiss = {name for name, state in checks.items() if state != "ok"}
    status = "ok" if not amiss else "degraded" if amiss == {BROKER_CHECK} else "unready"
    body = {"status": status, "checks": checks}
    return JSONResponse(body, status_code=503 if status == "unready" else 200, headers=NO_STORE)


@router.get("/statusz")
def status(
    account: ApiAccount, db: Db, events: EventsOf, supervisor: SupervisorOf, measured: MetricsOf, readiness: ReadinessOf
) -> Response:
    """What the service does now, for an administrator's token: what `balise top` shows."""
    if not account.is_administrator:
        raise Forbidden("L’état du service se lit avec le jeton d’un administrateur.")
    process = WebProcessStatus(
        visitors=VISITS.recent_visitors(),
        requests_per_minute=VISITS.requests_in_last_minute(),
        following=events.count_watchers(),
        workers=supervisor.alive_count(),
        wanted=supervisor.target_count,
        walls=measured.walls,
        checks=readiness.checks(),
    )
    faults = [RecentError(at, where, message) for at, where, message in RECENT_ERRORS.latest()]
    return JSONResponse(service_status.to_json(service_status.load_status(db, process, faults)), headers=NO_STORE)


@router.get("/metrics")
def metrics(request: Request, settings: SettingsOf, measured: MetricsOf) -> Response:
    """For who shows the token of the settings; without one there, for nobody."""
    if not settings.metrics_token:
        raise NotFound("Les mesures ne sont pas publiées : BALISE_METRICS_TOKEN n’est pas réglé.")
    scheme, _, token = request.headers.get("authorization", "").partition(" ")
    if scheme.lower() != SCHEME or not compare_digest(token.encode(), settings.metrics_token.encode()):
        raise Unauthorised("Le jeton de BALISE_METRICS_TOKEN est attendu dans l’en-tête « Authorization: Bearer … ».")
    content, media_type = measured.render()
    return Response(content, media_type=media_type, headers=NO_STORE)
