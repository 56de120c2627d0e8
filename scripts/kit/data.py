"""What a script measured, as JSON that people can look through too."""

import json
import re


def as_json(data: object) -> str:
    """Items on lines of their own, but those that hold no others in one line each."""
    innermost = re.compile(r"[\[{][^\[\]{}]*[\]}]")
    text = json.dumps(data, indent=1)
    # No string has a line's end in it: those are escaped.
    return innermost.sub(lambda found: re.sub(r"\n\s*", " ", found.group()), text) + "\n"
