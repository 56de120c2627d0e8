"""What a figure must be, what is aimed at, and which of them it reaches."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """What is wanted of a ratio; nothing, if there is no number that it must be."""

    must: float | None
    aim: float | None = None
    at_least: bool = True

    def verdict(self, ratio: float) -> str:
        """Whether the ratio is what was wanted, and by how much it is not."""
        if self.must is None:
            return ""
        if self._reaches(self.aim, ratio):
            return "aim"
        if self._reaches(self.must, ratio):
            return "must"
        gap = self.must / ratio if self.at_least else ratio / self.must
        return f"short by {100 * (gap - 1):.0f} %"

    def words(self) -> list[str]:
        """What must be and what is aimed at, for people."""
        sign = "≥" if self.at_least else "≤"
        both = (self.must, self.aim)
        return [f"{sign} {wanted:.3g}" if wanted is not None else "" for wanted in both]

    def cells(self, ratio: float, of: str = "") -> dict[str, str]:
        """The same and the verdict, as cells of a table; `of` goes before their names."""
        cells = zip(("must", "aim", "reached"), [*self.words(), self.verdict(ratio)], strict=True)
        return {f"{of}{name}": cell for name, cell in cells if cell}

    def _reaches(self, wanted: float | None, ratio: float) -> bool:
        if wanted is None:
            return False
        return ratio >= wanted if self.at_least else ratio <= wanted
