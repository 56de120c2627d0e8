"""Runs the `isokit` program. Standard library only."""

import json
import os
import subprocess
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


class Isokit:
    """One built program."""

    def __init__(self, path: Path, environment: dict[str, str] | None = None) -> None:
        """Takes the path of the executable; a bare name is looked up by the system.

        The environment is what is added to that of this process.
        """
        self.path, self.environment = path, environment or {}

    def run(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        """Runs a command and returns its status and its two streams."""
        command = [str(self.path), *map(str, arguments)]
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
            env=os.environ | self.environment,
        )

    def json(self, *arguments: object) -> dict:
        """What a command prints as JSON; raises `Failed` with its message if it fails."""
        return json.loads(self._checked(*arguments).stdout)

    def extract(self, volume: Path, out: Path, *options: object) -> dict:
        """Writes a mesh and returns the report about it."""
        report = out.with_suffix(".json")
        self._checked("extract", volume, *options, "-o", out, "--report", report)
        return json.loads(report.read_text())

    def _checked(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        done = self.run(*arguments)
        if done.returncode != 0:
            raise Failed(f"exit {done.returncode}: {done.stderr.strip()[-300:]}")
        return done


class Failed(Exception):
    """The program did not exit with 0."""
