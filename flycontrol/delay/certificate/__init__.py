"""Proofs of stability for constant delays: Lyapunov-Krasovskii functionals that a solver finds and a check confirms."""

from flycontrol.delay.certificate.certify import DelayCertificate, check_matrices, stability_certificate
from flycontrol.delay.certificate.interval import IntervalCertificate, certify_interval, largest_certified_delay

__all__ = [
    "DelayCertificate",
    "IntervalCertificate",
    "certify_interval",
    "check_matrices",
    "largest_certified_delay",
    "stability_certificate",
]
