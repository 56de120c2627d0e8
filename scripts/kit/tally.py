"""Counts checks, one printed line each.

Standard library only: Blender's interpreter uses it too.
"""

import sys
from dataclasses import dataclass, field


class Tally:
    """Passed, failed and skipped checks of one script."""

    def __init__(self, script: str, quiet: bool = False) -> None:
        """`quiet` prints failures only, for scripts that make thousands of checks."""
        self.script = script
        self.quiet = quiet
        self.passed = self.failed = self.skipped = 0

    def check(self, subject: str, claim: str, holds: bool, found: object = "") -> bool:
        """Counts one claim about a subject and says what was found instead or beside it."""
        holds = bool(holds)
        self.passed += holds
        self.failed += not holds
        if not (holds and self.quiet):
            tail = f": {found}" if str(found) else ""
            print(f"{'ok  ' if holds else 'FAIL'} {subject}: {claim}{tail}", flush=True)
        return holds

    def skip(self, subject: str, why: str) -> None:
        """Counts a check that could not be made here; never without a line."""
        self.skipped += 1
        print(f"skip {subject}: {why}", flush=True)

    def replay(self, record: "Record") -> None:
        """Counts what another process recorded."""
        for claim in record.claims:
            self.check(*claim)

    def finish(self) -> int:
        """Prints the totals, in the form that `scripts/test` adds up; returns the exit code."""
        tail = f", {self.skipped} skipped" if self.skipped else ""
        print(f"{self.script}: {self.passed} passed, {self.failed} failed{tail}", flush=True)
        if self.passed + self.failed + self.skipped == 0:
            print(f"{self.script}: nothing was checked", file=sys.stderr)
            return 1
        return int(self.failed > 0)


@dataclass
class Record:
    """Takes the same checks as a tally and keeps them, so that processes can hand them over."""

    claims: list[tuple[str, str, bool, str]] = field(default_factory=list)

    def check(self, subject: str, claim: str, holds: bool, found: object = "") -> bool:
        """Keeps one claim."""
        self.claims.append((subject, claim, bool(holds), str(found)))
        return bool(holds)
