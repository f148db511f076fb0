"""What is seen of a run while it goes on: a bar with the time left on a terminal, plain lines otherwise."""

import shutil
import sys
import time
from typing import Any

BAR_WIDTH = 24
REDRAW_SECONDS = 0.1


class Progress:
    """Counts files; writes to the standard error, which leaves the standard output to the summary."""

    def __init__(
        self, total: int, done_before: int, *, is_quiet: bool = False, words: tuple[str, str] = ("to do", "done")
    ) -> None:
        """`words`: what is before the files, and what is behind each."""
        self._to_do, self._done = words
        self.total = total
        self.finished = 0
        self.failed = 0
        self._done_before = done_before
        self._begin = time.monotonic()
        self._last_draw = 0.0
        self._is_quiet = is_quiet
        self._is_terminal = sys.stderr.isatty()

    def begin(self, what: str) -> None:
        """Say what is about to be done."""
        before = f", {self._done_before} were done before" if self._done_before else ""
        self._print(f"{self.total} files {self._to_do}{before}; {what}")

    def add(self, name: str, entries: list[dict[str, Any]], seconds: float) -> None:
        """One more file is done."""
        failures = [entry for entry in entries if entry["status"] == "failed"]
        self.finished += 1
        self.failed += bool(failures)
        word = "FAILED" if failures else self._done
        if failures or not self._is_terminal:
            count = f"{self.finished}/{self.total}"
            left = "" if self._is_terminal else f", {self.tell_time_left()} left"
            self._print(f"{count} {word} {name} ({seconds:.1f} s{left})")
        for entry in failures:
            place = " ".join(f"{kind} {entry[kind]}:" for kind in ("object", "line") if entry[kind] is not None)
            self._print(f"    {place}{' ' if place else ''}{entry['error']}: {entry['message']}; {entry['advice']}")
        self._draw_bar()

    def end(self) -> None:
        """Take the bar away."""
        if self._is_terminal and not self._is_quiet:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def say(self, message: str) -> None:
        """One line beside the count."""
        self._print(message)

    def tell_time_left(self) -> str:
        """From the mean so far."""
        if self.finished == 0:
            return "?"
        return tell_duration((time.monotonic() - self._begin) / self.finished * (self.total - self.finished))

    def _print(self, line: str) -> None:
        if self._is_quiet:
            return
        clear = "\r\x1b[K" if self._is_terminal else ""
        text = f"{clear}{line}\n"
        encoding = sys.stderr.encoding or "utf-8"
        sys.stderr.write(text.encode(encoding, "backslashreplace").decode(encoding))
        sys.stderr.flush()

    def _draw_bar(self) -> None:
        now = time.monotonic()
        is_due = now - self._last_draw >= REDRAW_SECONDS or self.finished == self.total
        if not self._is_terminal or self._is_quiet or not is_due:
            return
        self._last_draw = now
        filled = BAR_WIDTH * self.finished // max(1, self.total)
        failed = f", {self.failed} failed" if self.failed else ""
        bar = f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] {self.finished}/{self.total}{failed}"
        line = f"{bar}, {self.tell_time_left()} left"
        sys.stderr.write("\r\x1b[K" + line[: shutil.get_terminal_size().columns - 1])
        sys.stderr.flush()


def tell_duration(seconds: float) -> str:
    """Seconds in words: 3 h 20 min, 5 min 10 s, 12 s."""
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    if whole >= 60:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole} s"
