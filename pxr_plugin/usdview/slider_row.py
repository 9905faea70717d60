"""A number to be dragged or typed."""

from collections.abc import Callable
from typing import Any

from .window import Qt

__all__ = ["SliderRow"]

_TICKS = 200


class SliderRow:
    """A label, a slider around where the number began, and the number.

    Parameters
    ----------
    qt
        Qt.
    name
        What the number is.
    changed
        Called whenever the user changes it.
    """

    def __init__(self, qt: Qt, name: str, changed: Callable[[], object]) -> None:
        self._block = qt.core.QSignalBlocker
        self.label = qt.widgets.QLabel(name)
        self.slider = qt.widgets.QSlider(qt.core.Qt.Horizontal)
        self.slider.setRange(-_TICKS, _TICKS)
        self.spin = qt.widgets.QDoubleSpinBox()
        self.spin.setKeyboardTracking(False)
        self.spin.setMinimumWidth(96)
        for widget in (self.slider, self.spin):
            widget.setAccessibleName(name)
        self._begin, self._tick, self._changed = 0.0, 1.0, changed
        self.slider.valueChanged.connect(lambda ticks: self.spin.setValue(self._begin + ticks * self._tick))
        self.spin.valueChanged.connect(self._follow)

    def add_to(self, grid: Any, row: int) -> None:
        """Put it into a grid.

        Parameters
        ----------
        grid
            With three columns.
        row
            Of the grid.
        """
        for column, widget in enumerate((self.label, self.slider, self.spin)):
            grid.addWidget(widget, row, column)

    @property
    def value(self) -> float:
        """The number."""
        return float(self.spin.value())

    @property
    def change(self) -> float:
        """How far it is from where it began."""
        return self.value - self._begin

    def show(self, value: float, *, step: float, reach: float, bounds: tuple[float, float] = (-1e7, 1e7)) -> None:
        """Begin with another number.

        Parameters
        ----------
        value
            The number.
        step
            How far an arrow goes.
        reach
            How far the slider goes, to either side.
        bounds
            Smallest and largest number.
        """
        self._begin = value
        ticks = max(1, min(_TICKS, round(reach / step)))
        self._tick = reach / ticks
        blockers = [self._block(widget) for widget in (self.slider, self.spin)]
        self.slider.setRange(-ticks, ticks)
        self.slider.setValue(0)
        self.spin.setDecimals(0 if step == int(step) and value == int(value) else 3)
        self.spin.setRange(*bounds)
        self.spin.setSingleStep(step)
        self.spin.setValue(value)
        self._begin = self.value
        for blocker in blockers:
            blocker.unblock()

    def reset(self) -> None:
        """Go back to the number it began with."""
        self.spin.setValue(self._begin)

    def _follow(self, value: float) -> None:
        blocker = self._block(self.slider)
        self.slider.setValue(round((value - self._begin) / self._tick))
        blocker.unblock()
        self._changed()
