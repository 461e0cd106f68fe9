"""The errors a user can meet; every one says what was received, what is needed and what to do."""


class VsbError(Exception):
    """Base of all errors that are the user's to mend: reported as one line, exit code 2."""


class ConfigError(VsbError):
    """The study file cannot be used: names the file, the key, the value received and the value needed."""


class DatabaseError(VsbError):
    """A result file is missing, corrupt, foreign, or fails its checks."""


class ConvergenceError(VsbError):
    """An iteration or a fit did not reach its tolerance."""


class StabilityError(VsbError):
    """A model that must be passive or stable is not."""
