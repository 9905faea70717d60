"""The errors users see, each with the exit code the commands end with.

Every message says what is wrong and, where it helps, what was expected, what was found and what to do. The parts are
kept as attributes so that a pipeline can act on them without parsing text.
"""

__all__ = ["InputError", "MtexError", "NoSolutionError", "ResultError", "StageError"]


class MtexError(Exception):
    """Base of all errors a user can mend.

    Parameters
    ----------
    message
        What is wrong, naming the file, prim, joint or value it is about.
    expected, found, fix
        What would have been right, what is there instead, and what to do; any may be empty.
    """

    exit_code = 70

    def __init__(self, message: str, *, expected: str = "", found: str = "", fix: str = "") -> None:
        self.message = message
        self.expected = expected
        self.found = found
        self.fix = fix
        super().__init__(self._sentence())

    def _sentence(self) -> str:
        parts = [self.message]
        if self.expected:
            parts.append(f"expected {self.expected}")
        if self.found:
            parts.append(f"found {self.found}")
        text = "; ".join(parts)
        return f"{text}. {self.fix}" if self.fix else text


class InputError(MtexError):
    """Usage or input: an unknown joint, a bad range, an unreadable or unwritable file."""

    exit_code = 2


class StageError(MtexError):
    """The stage: no recipe, no animation, nothing to write to, blocked by a stronger opinion."""

    exit_code = 3


class NoSolutionError(MtexError):
    """Constraints that cannot be met together."""

    exit_code = 4


class ResultError(MtexError):
    """The written result does not say what was computed."""

    exit_code = 5
