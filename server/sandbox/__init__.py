"""Runs a student's code behind walls, and answers with plain values or with a fault. See README.md in this folder."""

from server.sandbox.child.codec import Value
from server.sandbox.faults import FaultKind, Frame, ProgramFault, SandboxFault
from server.sandbox.messages import judging_too_long
from server.sandbox.policy import Policy
from server.sandbox.pool import Sandbox
from server.sandbox.probe import WallReport, WallStatus, is_safe_to_serve, probe
from server.sandbox.session import Session
from server.sandbox.values import CallBatch, Kit, LibraryFile, Replies, Reply, TraceResult, Usage

__all__ = [
    "CallBatch",
    "FaultKind",
    "Frame",
    "Kit",
    "LibraryFile",
    "Policy",
    "ProgramFault",
    "Replies",
    "Reply",
    "Sandbox",
    "SandboxFault",
    "Session",
    "TraceResult",
    "Usage",
    "Value",
    "WallReport",
    "WallStatus",
    "is_safe_to_serve",
    "judging_too_long",
    "probe",
]
