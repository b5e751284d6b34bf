"""Errors of a sweep that are neither a wrong value (``ValueError``) nor a wrong type (``TypeError``)."""


class SweepError(RuntimeError):
    """A sweep that cannot go on; its text says why and what to do. What is in its store stays there."""


class StoreMismatch(ValueError):
    """A store that holds another sweep: another grid, function, seed or version. Its text names each difference."""


class StoreInUse(SweepError):
    """A store that another sweep is writing."""


class ClusterLost(SweepError):
    """A scheduler that no longer answers, or has no workers for too long."""
