"""Why something of a file could not be made: the name of the error and what was found. Holds nothing else."""


class FileFault(Exception):  # noqa: N818  (its name in the report is given by the one who raises it)
    """`error` is its name in the report; the text says what was found and, after a semicolon, what to do."""

    def __init__(self, error: str, message: str) -> None:
        super().__init__(message)
        self.error = error
