"""Process This Animation: a job in a process of its own, with progress and cancel."""

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mtex_usd.errors import InputError
from mtex_usd.usd.session import add_result, write_snapshot

from .window import guard, load_qt, show_error
from .worker import make_command

__all__ = ["ProcessJob", "check_idle", "running_job"]

_running: list["ProcessJob"] = []


def running_job() -> "ProcessJob | None":
    """Give the job that is under way; None where there is none."""
    return _running[0] if _running else None


def check_idle() -> None:
    """Refuse a second job beside one that is under way.

    Raises
    ------
    InputError
        Where there is one.
    """
    if _running:
        raise InputError("an animation is being processed", fix="Wait for it, or cancel it.")


class ProcessJob:
    """One job: files in a folder of its own, a child process, and the dialog that shows how far it is.

    Parameters
    ----------
    api
        The API of usdview.
    animations
        Paths of the sketches.
    """

    def __init__(self, api: Any, animations: Sequence[Any]) -> None:
        self.api, self.stage = api, api.stage
        self.animations = [str(path) for path in animations]
        self.answer: dict[str, Any] = {}
        self.cancelled = False
        self._rest = ""
        self.folder = tempfile.TemporaryDirectory(prefix="usdmtex-")

    def start(self) -> None:
        """Begin; returns at once.

        Raises
        ------
        InputError
            Where another process cannot see what the stage shows, or there is no Python to run it.
        """
        try:
            command = self._prepare()
        except BaseException:
            self.folder.cleanup()
            raise
        qt = load_qt()
        self.process = qt.core.QProcess(self.api.qMainWindow)
        self.process.readyReadStandardOutput.connect(guard(self.api, self._read))
        self.process.finished.connect(guard(self.api, lambda *_: self._finish()))
        self.process.errorOccurred.connect(guard(self.api, lambda *_: self._fail_to_start()))
        self.dialog = self._make_dialog(qt)
        _running.append(self)
        self.process.start(command[0], command[1:])
        self.dialog.show()

    def _prepare(self) -> list[str]:
        if not sys.executable:
            raise InputError("there is no Python to process with", fix="Run usdmtex in a terminal.")
        folder = Path(self.folder.name)
        snapshot = write_snapshot(self.stage, folder)
        return make_command({"stage": str(snapshot), "out": str(folder / "result.usd"), "animations": self.animations})

    def _make_dialog(self, qt: Any) -> Any:
        names = ", ".join(path.rpartition("/")[2] for path in self.animations)
        dialog = qt.widgets.QProgressDialog(f"Processing {names}\nStarting", "Cancel", 0, 0, self.api.qMainWindow)
        dialog.setWindowTitle("Process This Animation")
        dialog.setMinimumWidth(380)
        dialog.setAutoClose(False)
        dialog.setAutoReset(False)
        dialog.setMinimumDuration(0)
        dialog.canceled.connect(guard(self.api, self.cancel))
        return dialog

    def cancel(self) -> None:
        """End it; the stage stays as it is and nothing is left in any folder."""
        if self in _running and not self.cancelled:
            self.cancelled = True
            self.process.kill()

    def _read(self) -> None:
        self._rest += bytes(self.process.readAllStandardOutput().data()).decode("utf-8", "replace")
        *lines, self._rest = self._rest.split("\n")
        for line in lines:
            self.answer |= json.loads(line)
        if "total" in self.answer and not self.cancelled:
            self._show_progress()

    def _show_progress(self) -> None:
        done, total, what = self.answer["done"], self.answer["total"], self.answer["what"]
        # One animation gives no steps to count: the bar moves to show that it is alive.
        self.dialog.setRange(0, total if total > 1 else 0)
        self.dialog.setValue(done)
        if what:
            count = f" ({done + 1} of {total})" if total > 1 else ""
            self.dialog.setLabelText(f"Processing {what}{count}")

    def _fail_to_start(self) -> None:
        if self.process.state() == load_qt().core.QProcess.NotRunning and not self.answer and not self.cancelled:
            self._end()
            show_error(self.api, f"The process that makes paths does not start: {self.process.errorString()}.")

    def _finish(self) -> None:
        if self not in _running:
            return
        self._read()
        said = bytes(self.process.readAllStandardError().data()).decode("utf-8", "replace")
        try:
            if not self.cancelled and "made" in self.answer:
                self._show_result()
        finally:
            self._end()
        if self.cancelled:
            self.api.PrintStatus("Processing was cancelled; nothing has changed.")
        elif "error" in self.answer:
            show_error(self.api, self.answer["error"])
        elif "made" not in self.answer:
            sys.stderr.write(said)
            show_error(self.api, "The process that makes paths ended before its time. The terminal has the details.")

    def _show_result(self) -> None:
        if self.api.stage is not self.stage and self.api.stage != self.stage:
            self.api.PrintStatus("Another stage was opened meanwhile; what was made for the one before is dropped.")
            return
        add_result(self.stage, Path(self.folder.name) / "result.usd")
        self.api.PrintStatus("; ".join([*self.answer["made"], *self.answer["notes"]]))
        self.api.UpdateGUI()

    def _end(self) -> None:
        _running.remove(self)
        self.dialog.canceled.disconnect()
        self.dialog.close()
        self.dialog.deleteLater()
        self.process.deleteLater()
        self.folder.cleanup()
