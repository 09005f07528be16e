"""Routes for monitoring: orchestrators, load balancers, Prometheus."""

from secrets import compare_digest
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import JSONResponse

from server.base.app_services import app_service
from server.base.counters import VISITS
from server.base.errors import Forbidden, NotFound, Unauthorised
from server.base.logs import RECENT_ERRORS
from server.base.settings import Settings
from server.base.version import VERSION
from server.database.dependencies import Db
from server.grading.supervisor import WorkerSupervisor
from server.health import service_status
from server.health.metrics import PrometheusMetrics
from server.health.readiness import BROKER_CHECK, DISK_CHECK, ReadinessChecks
from server.health.service_status import RecentError, WebProcessStatus
from server.identity.dependencies import ApiAccount
from server.submissions.job_events import JobEvents

router = APIRouter(include_in_schema=False)

SettingsOf = Annotated[Settings, Depends(app_service(Settings))]
MetricsOf = Annotated[PrometheusMetrics, Depends(app_service(PrometheusMetrics))]
EventsOf = Annotated[JobEvents, Depends(app_service(JobEvents))]
SupervisorOf = Annotated[WorkerSupervisor, Depends(app_service(WorkerSupervisor))]
ReadinessOf = Annotated[ReadinessChecks, Depends(app_service(ReadinessChecks))]
NO_STORE = {"Cache-Control": "no-store"}
SCHEME = "bearer"


@router.get("/healthz")
async def answer_liveness_probe() -> Response:
    """Answer while the process lives; it does not read the database."""
    return JSONResponse({"status": "ok", "version": VERSION}, headers=NO_STORE)


@router.get("/readyz")
def answer_readiness_probe(readiness: ReadinessOf) -> Response:
    """Return 503 with the failed checks where no visitor should come; `degraded` where they still may."""
    checks = readiness.run_checks()
    failed_checks = {name for name, state in checks.items() if state != "ok"}
    status = "ok" if not failed_checks else "degraded" if failed_checks <= {BROKER_CHECK, DISK_CHECK} else "unready"
    body = {"status": status, "checks": checks}
    return JSONResponse(body, status_code=503 if status == "unready" else 200, headers=NO_STORE)


@router.get("/statusz")
def show_service_status(
    account: ApiAccount,
    db: Db,
    events: EventsOf,
    supervisor: SupervisorOf,
    prometheus: MetricsOf,
    readiness: ReadinessOf,
) -> Response:
    """Return the state of the service, for an administrator's token; `balise top` shows it."""
    if not account.is_administrator:
        raise Forbidden("L’état du service se lit avec le jeton d’un administrateur.")
    process = WebProcessStatus(
        visitors=VISITS.recent_visitors(),
        requests_per_minute=VISITS.requests_in_last_minute(),
        following=events.count_watchers(),
        workers=supervisor.alive_worker_count(),
        wanted=supervisor.target_worker_count,
        walls=prometheus.wall_states,
        checks=readiness.run_checks(),
    )
    faults = [RecentError(at, where, message) for at, where, message in RECENT_ERRORS.latest()]
    return JSONResponse(
        service_status.service_status_to_json(service_status.load_service_status(db, process, faults)), headers=NO_STORE
    )


@router.get("/metrics")
def show_metrics(request: Request, settings: SettingsOf, prometheus: MetricsOf) -> Response:
    """Return the metrics for the token of the settings; without one, for nobody."""
    if not settings.metrics_token:
        raise NotFound("Les mesures ne sont pas publiées : BALISE_METRICS_TOKEN n’est pas réglé.")
    scheme, _, token = request.headers.get("authorization", "").partition(" ")
    if scheme.lower() != SCHEME or not compare_digest(token.encode(), settings.metrics_token.encode()):
        raise Unauthorised("Le jeton de BALISE_METRICS_TOKEN est attendu dans l’en-tête « Authorization: Bearer … ».")
    content, media_type = prometheus.render()
    return Response(content, media_type=media_type, headers=NO_STORE)
