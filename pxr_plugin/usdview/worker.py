"""The process that makes paths while usdview stays alive: takes one job as its argument, answers in lines of JSON."""

import json
import os
import sys
from typing import IO, Any

from mtex_usd.errors import MtexError

__all__ = ["main", "make_command"]


def make_command(job: dict[str, Any]) -> list[str]:
    """Give the command that runs a job in a process of its own.

    Parameters
    ----------
    job
        ``stage``, ``out`` and ``animations``.
    """
    code = f"import sys; sys.path[:] = {sys.path!r}; from mtex_usd.usdview.worker import main; main(sys.argv[1])"
    return [sys.executable, "-c", code, json.dumps(job)]


def main(text: str) -> None:
    """Do one job, and say on stdout how far it is and how it ended.

    Parameters
    ----------
    text
        The job, as JSON.
    """
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what anything prints must not come between the answers
    _say(answers, begun=True)
    try:
        _say(answers, **_process(json.loads(text), answers))
    except MtexError as error:
        _say(answers, error=str(error))


def _process(job: dict[str, Any], answers: IO[str]) -> dict[str, Any]:
    from mtex_usd.api import process  # noqa: PLC0415

    results = process(
        job["stage"],
        out=job["out"],
        anim=job["animations"],
        progress=lambda done, total, what: _say(answers, done=done, total=total, what=what),
    )
    return {
        "made": [f"{result.model}: {len(result.variants)} paths" for result in results],
        "notes": [f"{result.anim}: {note}" for result in results for note in result.notes],
    }


def _say(answers: IO[str], **words: object) -> None:
    answers.write(json.dumps(words) + "\n")
    answers.flush()
