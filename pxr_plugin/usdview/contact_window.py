"""Edit Contact: a step moved in time and space, and the motion near it solved for again while it moves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mtex_usd.constraints.planting.steps import MovedStep, Step, StepMover, prepare_steps
from mtex_usd.errors import InputError, NoSolutionError
from mtex_usd.usd.contact_edits import ContactMotion, author_motion, keep_specs, put_back

from .slider_row import SliderRow
from .window import guard, load_qt, seek

__all__ = ["ContactWindow"]

_WAIT_MS = 40  # one solve per pause of the hand; it takes about as long
_REACH_M = 0.5  # how far sliders go; the numbers beside them go on
_REACH_FRAMES = 12
_TIMES = ("Shift", "First", "Last")
_WIDTHS = (200, 60, 60)
_HINT = "The motion near the contact is solved for again while it is moved."


class ContactWindow:
    """The list of steps, and rows to move the one that is chosen.

    Parameters
    ----------
    api
        The API of usdview.
    motions
        Of the characters that were selected.
    """

    def __init__(self, api: Any, motions: Sequence[ContactMotion]) -> None:
        self.api, self.stage, self.motions = api, api.stage, tuple(motions)
        self.qt = load_qt()
        self.before = keep_specs(self.stage)
        self.movers = [_prepare(motion) for motion in self.motions]
        self.moved: dict[int, MovedStep] = {}
        self.settled: set[int] = set()
        self.chosen = (0, 0)
        self.timer = self.qt.core.QTimer()
        self.timer.setSingleShot(True)
        self.timer.setInterval(_WAIT_MS)
        self.timer.timeout.connect(guard(api, self._solve))
        self.dialog = self._make_dialog()
        self._fill_list()
        self._choose(0, 0)

    def _make_dialog(self) -> Any:
        widgets = self.qt.widgets
        dialog = widgets.QDialog(self.api.qMainWindow)
        dialog.setWindowTitle("Edit Contact")
        dialog.resize(760, 430)
        self.tree = widgets.QTreeWidget()
        self.tree.setHeaderLabels(["Contact", "First", "Last"])
        self.tree.setRootIsDecorated(False)
        for column, width in enumerate(_WIDTHS):
            self.tree.setColumnWidth(column, width)
        self.tree.currentItemChanged.connect(guard(self.api, lambda item, _: self._choose_item(item)))
        side = widgets.QVBoxLayout()
        self.times = [self._make_row(name) for name in _TIMES]
        self.places = [self._make_row(name) for name in "XYZ"]
        for title, rows in (("Time", self.times), ("Place in the world", self.places)):
            box = widgets.QGroupBox(title)
            grid = widgets.QGridLayout(box)
            for number, row in enumerate(rows):
                row.add_to(grid, number)
            side.addWidget(box)
        self.status = widgets.QLabel()
        self.status.setWordWrap(True)
        self.status.setMinimumHeight(54)
        self.status.setAlignment(self.qt.core.Qt.AlignTop | self.qt.core.Qt.AlignLeft)
        side.addWidget(self.status)
        side.addStretch(1)
        side.addLayout(self._make_buttons(dialog))
        layout = widgets.QHBoxLayout(dialog)
        layout.addWidget(self.tree, 1)
        layout.addLayout(side, 1)
        dialog.rejected.connect(guard(self.api, self._take_back))
        return dialog

    def _make_row(self, name: str) -> SliderRow:
        return SliderRow(self.qt, name, self.timer.start)

    def _make_buttons(self, dialog: Any) -> Any:
        buttons = self.qt.widgets.QHBoxLayout()
        actions = (("&Reset", self._reset), ("&Keep", dialog.accept), ("Cancel", dialog.reject))
        for name, action in actions:
            button = self.qt.widgets.QPushButton(name)
            button.setAutoDefault(False)
            button.clicked.connect(guard(self.api, lambda *_, action=action: action()))
            buttons.addWidget(button)
            if name == "&Reset":
                buttons.addStretch(1)
        return buttons

    def _fill_list(self) -> None:
        for motion, mover in zip(self.motions, self.movers, strict=True):
            head = self.qt.widgets.QTreeWidgetItem(self.tree, [motion.label])
            head.setFirstColumnSpanned(True)
            head.setFlags(self.qt.core.Qt.ItemIsEnabled)
            for step in mover.steps:
                times = (f"{motion.clip.time_codes[frame]:g}" for frame in (step.first, step.last))
                self.qt.widgets.QTreeWidgetItem(head, [_name(step), *times])
            head.setExpanded(True)
        self.tree.setCurrentItem(self.tree.topLevelItem(0).child(0))

    def _choose_item(self, item: Any) -> None:
        if item is None or item.parent() is None:
            return
        head = item.parent()
        who, which = self.tree.indexOfTopLevelItem(head), head.indexOfChild(item)
        if (who, which) != self.chosen:
            self._choose(who, which)
            seek(self.api, float(self.motions[who].clip.time_codes[self.movers[who].steps[which].first]))

    def _choose(self, who: int, which: int) -> None:
        self.timer.stop()
        self._settle()
        self.chosen = (who, which)
        self._show_step()

    def _settle(self) -> None:
        """Go on from what was moved, before another step is."""
        who, _ = self.chosen
        moved = self.moved.pop(who, None)
        if moved is not None:
            self.settled.add(who)
            motion = self.motions[who]
            self.movers[who] = prepare_steps(moved.clip, moved.holds, frequency=motion.frequency, limits=motion.limits)

    def _show_step(self) -> None:
        motion, _, step = self._current()
        clip, per_frame = motion.clip, motion.clip.time_codes_per_frame
        reach = _REACH_FRAMES * per_frame
        self.times[0].show(0.0, step=per_frame, reach=reach)
        for row, frame in zip(self.times[1:], (step.first, step.last), strict=True):
            bounds = (float(clip.time_codes[0]), float(clip.time_codes[-1]))
            row.show(float(clip.time_codes[frame]), step=per_frame, reach=reach, bounds=bounds)
        unit = self._meters_per_unit()
        for row, value in zip(self.places, self._to_world(step.place), strict=True):
            row.show(float(value), step=0.005 / unit, reach=_REACH_M / unit)
        self.status.setText(_HINT)

    def _current(self) -> tuple[ContactMotion, StepMover, Step]:
        who, which = self.chosen
        return self.motions[who], self.movers[who], self.movers[who].steps[which]

    def _meters_per_unit(self) -> float:
        motion, _, _ = self._current()
        scale = float(np.linalg.norm(motion.to_world[0, :3]))
        return motion.clip.skeleton.meters_per_unit / scale

    def _to_world(self, place: Any) -> Any:
        return (np.array([*place, 1.0]) @ self._current()[0].to_world)[:3]

    def _solve(self) -> None:
        """Move the step to where the rows say, and show it."""
        motion, mover, step = self._current()
        shift, *ends = (row.value for row in self.times)
        frames = [round((shift + end - motion.clip.start) / motion.clip.time_codes_per_frame) for end in ends]
        if not any(row.change for row in (*self.times, *self.places)):
            self._show_unmoved()
        else:
            by = np.array([row.change for row in self.places]) @ np.linalg.inv(motion.to_world[:3, :3])
            try:
                moved = mover.move(self.chosen[1], by=by, first=frames[0], last=frames[1])
            except (InputError, NoSolutionError) as error:
                self.status.setText(f"{_name(step)} stays where it was: {error}")
                return
            self.moved[self.chosen[0]] = moved
            self._show_motion(moved)
        self._show_times(frames)
        self.api.UpdateViewport()

    def _show_motion(self, moved: MovedStep) -> None:
        motion, mover, _ = self._current()
        author_motion(self.stage, motion, moved.clip, moved.holds)
        before = mover.solution.clips[0]
        changed = np.flatnonzero((moved.clip.rotations != before.rotations).any(axis=(1, 2)))
        times = motion.clip.time_codes[changed[[0, -1]]] if changed.size else motion.clip.time_codes[[0, 0]]
        self.status.setText(f"The motion is changed from {times[0]:g} to {times[1]:g}.")

    def _show_unmoved(self) -> None:
        """Show the motion as it was before this step was moved."""
        who, _ = self.chosen
        motion, mover, _ = self._current()
        self.moved.pop(who, None)
        if who in self.settled:
            holds = [hold for step in mover.steps for hold in step.holds]
            author_motion(self.stage, motion, mover.solution.clips[0], holds)
        else:
            put_back(self.stage, motion, self.before)
        self.status.setText(_HINT)

    def _show_times(self, frames: Sequence[int]) -> None:
        who, which = self.chosen
        item = self.tree.topLevelItem(who).child(which)
        for column, frame in enumerate(frames, start=1):
            item.setText(column, f"{self.motions[who].clip.time_codes[frame]:g}")

    def _reset(self) -> None:
        for row in (*self.times, *self.places):
            row.reset()
        self.timer.stop()
        self._solve()

    def _take_back(self) -> None:
        self.timer.stop()
        for motion in self.motions:
            put_back(self.stage, motion, self.before)
        self.api.UpdateViewport()


def _name(step: Step) -> str:
    return step.name.replace(".", " ")


def _prepare(motion: ContactMotion) -> StepMover:
    return prepare_steps(motion.clip, motion.holds, frequency=motion.frequency, limits=motion.limits)
