"""A process that answers requests, one JSON object a line. Standard library only."""

import json
import os
import select
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Self

COLD = {"MALLOC_MMAP_THRESHOLD_": "131072", "MALLOC_TRIM_THRESHOLD_": "131072"}
"""Settings of glibc with which freed memory goes back to the system at once.

By default it keeps what was freed, up to 64 MiB, so that the next run finds it warm.
"""


class Failed(Exception):
    """The process cannot do what was asked, or is no more; the message says why."""


class Worker:
    """One long-lived process. What it prints to stderr is kept for the reason of a failure."""

    def __init__(self, command: list[str], environment: dict[str, str] | None = None) -> None:
        """Starts it."""
        self.log = tempfile.TemporaryFile()
        self.buffer = b""
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.log,
            env=os.environ | (environment or {}),
        )

    def ask(self, request: dict, limit_s: float = 600.0) -> dict:
        """The answer to a request; raises `Failed` on an error, a crash or a time-out."""
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            self.process.stdin.flush()
        except OSError:
            raise Failed(self._last_words()) from None
        answer = json.loads(self._line(limit_s))
        if answer.get("error"):
            raise Failed(answer["error"])
        return answer

    def close(self) -> None:
        """Ends it, by force if it has to be."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout, self.log):
            try:
                stream.close()
            except OSError:
                pass  # what could not be flushed has no reader any more

    def __enter__(self) -> Self:
        """For `with`."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Ends it."""
        self.close()

    def _line(self, limit_s: float) -> bytes:
        stream = self.process.stdout.fileno()
        end = time.monotonic() + limit_s
        while b"\n" not in self.buffer:
            left = end - time.monotonic()
            if left <= 0 or not select.select([stream], [], [], left)[0]:
                self.process.kill()
                raise Failed(f"no answer within {limit_s:g} s")
            part = os.read(stream, 1 << 16)
            if not part:
                raise Failed(self._last_words())
            self.buffer += part
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line

    def _last_words(self) -> str:
        code = self.process.wait()
        self.log.seek(0)
        lines = self.log.read().decode(errors="replace").strip().splitlines()
        how = f"ended by signal {-code}" if code < 0 else f"ended with exit {code}"
        return f"{how}: {lines[-1][-200:]}" if lines else how
