"""The errors that flycontrol raises on purpose. Each message says what was required, what arrived, and what to do."""

LONGEST_SENTENCE = 1000  #: characters that a refusal needs at most


class FlycontrolError(Exception):
    """Base of every error with a sentence for the user; the command line prints it and exits with status 2."""


class InvalidParameterError(FlycontrolError, ValueError):
    """A value that no system can have: a negative inertia, a delay that is not a number."""


class InvalidInputError(FlycontrolError, ValueError):
    """A file, a mapping or a recording that cannot be used as it is.

    Its sentence quotes what strangers wrote: it is kept to one printable line of ordinary length.
    """

    def __init__(self, sentence: str) -> None:
        text = (
            sentence if sentence.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in sentence)
        )
        super().__init__(text if len(text) <= LONGEST_SENTENCE else f"{text[:700]} ... {text[-200:]}")


class OutputError(FlycontrolError, OSError):
    """A result that could not be written; nothing half-written is left behind."""


class NeutralSystemError(FlycontrolError, ValueError):
    """A delay system whose highest derivative is delayed too, or an algebraic loop through a delay."""


class AlgebraicLoopError(FlycontrolError, ValueError):
    """A feedback whose undelayed direct path has no unique solution."""


class UnstableSystemError(FlycontrolError, ValueError):
    """A quantity asked for that only a stable loop has."""


class WorkerLostError(FlycontrolError, RuntimeError):
    """A worker process that died twice over the same part of a job, or could not start at all."""
