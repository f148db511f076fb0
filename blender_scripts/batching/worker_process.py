"""One worker process with a Blender in it: started, given files one after another, watched, ended.

Talks in lines of JSON over the process's input and output; whatever else Blender prints goes to a log. Holds no Blender
itself, and no knowledge of what is done with a file.
"""

import contextlib
import json
import os
import queue
import signal
import subprocess
import threading
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MARK = b"SMOOTH-POLYLINES-BATCH "
START_SECONDS = 180.0  # a first start from a cold network disk
SCRIPT = Path(__file__).with_name("inside") / "worker.py"
LOG_LIMIT = 20_000_000  # bytes of a worker's log, beyond which it begins anew


@dataclass(frozen=True)
class WorkerDied:
    """The process ended, or was ended, before it had answered."""

    error: str  # as the report names it
    message: str


class WorkerStartError(Exception):
    """No worker process can be had at all; the message says what was tried."""


def find_worker_command(blender: str | None) -> list[str]:
    """The command of a worker: in the Blender program given, or in this Python, which must have bpy then."""
    if blender is not None:
        return [blender, "--background", "--python-exit-code", "3", "--python", str(SCRIPT)]
    import sys

    same = ["-S"] if sys.flags.no_site else []
    return [sys.executable, "-u", *same, str(SCRIPT)]


class WorkerProcess:
    """A worker, alive from the first `ask` on until `close` or its death; can be asked again after that."""

    def __init__(self, command: list[str], setup: dict[str, Any], log: Path) -> None:
        self._command = command
        self._setup = setup  # "job", "output", "fingerprint", "profile": what holds for all files
        self.limits = setup["job"]["limits"]
        self.output = Path(setup["output"])
        self._log_path = log
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: queue.Queue[dict[str, Any] | None] = queue.Queue()
        self._is_stopped = False
        self.files = 0
        self.token = ""  # of the process: another after each start
        self.hello: dict[str, Any] = {}

    def start(self) -> None:
        """Start the process and wait until Blender is ready; WorkerStartError otherwise."""
        if self._is_stopped:
            raise WorkerStartError("the run has been stopped")
        if self._process is not None:
            return
        self._log_path.parent.mkdir(parents=True, exist_ok=True)
        is_long = self._log_path.exists() and self._log_path.stat().st_size > LOG_LIMIT
        environment = {**os.environ, "PYTHONUNBUFFERED": "1", "PYTHONIOENCODING": "utf-8:backslashreplace"}
        if self._setup["profile"] is not None:
            environment["BLENDER_USER_RESOURCES"] = os.path.abspath(self._setup["profile"])
        with open(self._log_path, "wb" if is_long else "ab") as log:
            try:
                self._process = subprocess.Popen(
                    self._command,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=log,
                    env=environment,
                    # Ctrl-C in the terminal is for the run, which then ends its workers.
                    start_new_session=os.name != "nt",
                    creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
                )
            except OSError as error:
                raise WorkerStartError(f"{self._command[0]} cannot be started: {error.strerror}") from error
        if self._is_stopped:  # in the meantime, by another thread
            self.kill()
            raise WorkerStartError("the run has been stopped")
        self._answers = queue.Queue()
        self.files = 0
        threading.Thread(target=self._read, args=(self._process, self._answers), daemon=True).start()
        self.token = uuid.uuid4().hex[:8]
        self._send({**self._setup, "token": self.token})
        hello = self._wait(START_SECONDS)
        if hello is None or "refused" in hello:
            reason = f"ended or was silent ({self._describe_end()})" if hello is None else hello["refused"]
            self.kill()
            raise WorkerStartError(f"the worker process {reason}; its log is {self._log_path}")
        self.hello = hello

    def ask(self, request: dict[str, Any], seconds: float) -> dict[str, Any] | WorkerDied:
        """Have one file done; the worker's answer, or how it died. Not answered after `seconds`: it is ended."""
        self.start()
        self.files += 1
        self._send(request)
        try:
            answer = self._answers.get(timeout=seconds)
        except queue.Empty:
            self.kill()
            return WorkerDied("TimeLimitError", f"not done after {seconds:g} seconds, the limit for one file")
        if answer is None:
            died = WorkerDied("WorkerDiedError", f"Blender ended in the middle of it ({self._describe_end()})")
            self.kill()
            return died
        return answer

    def close(self) -> None:
        """Let the process end by itself; by force when it does not."""
        if self._process is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(10)
        self.kill()

    def stop(self) -> None:
        """End the process at once and for good."""
        self._is_stopped = True
        self.kill()

    def kill(self) -> None:
        """End the process at once, and what it may have started."""
        process, self._process = self._process, None
        if process is None:
            return
        if process.poll() is None:
            with contextlib.suppress(OSError):
                if os.name == "nt":
                    process.kill()
                else:
                    os.killpg(process.pid, signal.SIGKILL)
        with contextlib.suppress(OSError):
            process.stdin.close()
        process.wait()

    @property
    def process_id(self) -> int | None:
        """Of the process, while there is one."""
        return None if self._process is None else self._process.pid

    def _send(self, message: dict[str, Any]) -> None:
        # A broken pipe is a dead process: the answer's absence says so.
        with contextlib.suppress(OSError):
            self._process.stdin.write(json.dumps(message).encode("ascii") + b"\n")
            self._process.stdin.flush()

    def _wait(self, seconds: float) -> dict[str, Any] | None:
        try:
            return self._answers.get(timeout=seconds)
        except queue.Empty:
            return None

    @staticmethod
    def _read(process: subprocess.Popen[bytes], answers: queue.Queue[dict[str, Any] | None]) -> None:
        """Take the worker's lines; None at its end. Blender itself may print before the script has begun."""
        for line in process.stdout:
            at = line.find(MARK)
            if at >= 0:
                with contextlib.suppress(ValueError):
                    answers.put(json.loads(line[at + len(MARK) :]))
        process.stdout.close()
        answers.put(None)

    def _describe_end(self) -> str:
        process = self._process
        if process is None:
            return "it was ended"
        try:
            code = process.wait(5)
        except subprocess.TimeoutExpired:
            return "still there, but silent"
        if code >= 0:
            return f"exit code {code}"
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"{name}, perhaps for lack of memory" if name == "SIGKILL" else name
