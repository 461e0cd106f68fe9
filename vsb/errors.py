"""The errors a user can meet; every one says what was received, what is needed and what to do."""

from collections.abc import Sequence

INTERRUPTED = "vsb: interrupted; run the same command again to go on from here"
"""What a command says that Ctrl-C ended."""


class VsbError(Exception):
    """Base of all errors that are the user's to mend: reported as one line, exit code 2."""


class ConfigError(VsbError):
    """The study file cannot be used: names the file, the key, the value received and the value needed.

    `mistakes` are all that were found, one line each; the message of the error is the first.
    """

    def __init__(self, message: str, mistakes: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.mistakes = tuple(mistakes) or (message,)


class DatabaseError(VsbError):
    """A result file is missing, corrupt, foreign, or fails its checks."""


class ConvergenceError(VsbError):
    """An iteration or a fit did not reach its tolerance."""


class StabilityError(VsbError):
    """A model that must be passive or stable is not."""
