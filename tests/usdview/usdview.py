"""usdview without its viewport: a window, a stage, a selection, and an API that refuses what is not documented."""

# ruff: noqa: N802, N815 (the names are those of usdview)

import inspect

from pxr import Tf, Usd
from PySide6 import QtCore, QtWidgets

from tests.usdview import documented


class DataModel(QtCore.QObject):
    """What usdview knows of stage and time; tells of changes by its documented signals."""

    signalStageReplaced = QtCore.Signal()
    signalPrimsChanged = QtCore.Signal(int, int)

    def __init__(self, stage):
        super().__init__()
        self._stage, self._frame = stage, Usd.TimeCode(stage.GetStartTimeCode())
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._notice, stage)

    def _notice(self, *_):
        self.signalPrimsChanged.emit(1, 1)

    @property
    def stage(self):
        return self._stage

    @property
    def currentFrame(self):
        return self._frame

    @currentFrame.setter
    def currentFrame(self, value):
        if not isinstance(value, Usd.TimeCode):
            raise ValueError(f"Expected Usd.TimeCode, got: {value}")
        self._frame = value

    def replace(self, stage):
        """Open another stage."""
        self._listener.Revoke()
        self._stage = stage
        self.signalStageReplaced.emit()


class Documented:
    """Lets through what a table names, with the parameters it names, and records it."""

    def __init__(self, inner, *, properties, settable, methods):
        object.__setattr__(self, "_parts", (inner, properties, settable, methods))
        object.__setattr__(self, "used", [])

    def __getattr__(self, name):
        inner, properties, _, methods = self._parts
        if name in properties:
            self.used.append(name)
            return getattr(inner, name)
        assert name in methods, f"usdview documents no {name}"
        return lambda *args, **kwargs: self._call(name, args, kwargs)

    def __setattr__(self, name, value):
        inner, _, settable, _ = self._parts
        assert name in settable, f"usdview does not let plugins set {name}"
        self.used.append(f"{name}=")
        setattr(inner, name, value)

    def _call(self, name, args, kwargs):
        inner, _, _, methods = self._parts
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        signature = inspect.Signature([inspect.Parameter(each, kind) for each in methods[name]])
        signature.bind(*args, **kwargs)
        self.used.append(name)
        return getattr(inner, name)(*args, **kwargs)


class _Inner:
    """What stands behind the API."""

    def __init__(self, window, model):
        self.qMainWindow = window
        self.dataModel = Documented(
            model,
            properties=documented.MODEL_PROPERTIES | documented.MODEL_SIGNALS,
            settable=documented.MODEL_SETTABLE,
            methods=documented.MODEL_METHODS,
        )
        self.selectedPrims = [model.stage.GetPseudoRoot()]
        self.model, self.messages, self.redraws = model, [], 0

    @property
    def stage(self):
        return self.model.stage

    @property
    def frame(self):
        return self.model.currentFrame

    def PrintStatus(self, msg):
        assert isinstance(msg, str)
        self.messages.append(msg)

    def UpdateGUI(self):
        pass

    def UpdateViewport(self):
        self.redraws += 1


class Usdview:
    """One running usdview.

    Its timeline has the field that usdview's window has, which moves the slider when it is edited.
    """

    def __init__(self, stage):
        self.window = QtWidgets.QMainWindow()
        self.window.menuBar().addMenu("&File")
        self.field = QtWidgets.QLineEdit(self.window)
        self.field.setObjectName("frameField")
        self.timeline = []
        self.field.editingFinished.connect(lambda: self.timeline.append(float(self.field.text())))
        self.model = DataModel(stage)
        self.inner = _Inner(self.window, self.model)
        self.api = Documented(
            self.inner, properties=documented.API_PROPERTIES, settable=set(), methods=documented.API_METHODS
        )
        self.registry = None

    def load(self):
        from pxr.Usdviewq.plugin import loadPlugins

        self.registry = loadPlugins(self.api, self.window)
        return self

    def select(self, *prim_paths):
        self.inner.selectedPrims = [self.model.stage.GetPrimAtPath(path) for path in prim_paths]

    @property
    def menu(self):
        (found,) = [each for each in self.window.menuBar().actions() if each.text() == "Motion Texture"]
        return found.menu()

    def action(self, name):
        (found,) = [each for each in self.menu.actions() if each.text() == name]
        return found

    def trigger(self, name):
        """Do what a click on a menu entry does."""
        self.action(name).trigger()
        QtWidgets.QApplication.processEvents()

    @property
    def last_message(self):
        return self.inner.messages[-1]


def wait_until(condition, seconds=60.0):
    """Let Qt's loop run until something holds."""
    loop, timer = QtCore.QEventLoop(), QtCore.QTimer()
    timer.timeout.connect(lambda: loop.quit() if condition() else None)
    QtCore.QTimer.singleShot(int(1000 * seconds), loop.quit)
    timer.start(5)
    loop.exec()
    assert condition(), f"nothing came of it in {seconds:g} s"
