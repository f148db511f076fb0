"""The refusals of a batch run as a whole. What goes wrong in one file is an entry of the report, not one of these."""


class JobError(Exception):
    """The job cannot be run as it is; `faults` has one line for each thing that is wrong."""

    def __init__(self, *faults: str) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


class StopRun(Exception):  # noqa: N818  (no error: a reason to end early)
    """The run ends early, and can be started again: the reason and what to do."""
