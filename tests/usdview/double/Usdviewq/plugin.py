"""Loading plugins as usdview's documentation says it is done, and what plugins are given to register with."""

# ruff: noqa: N802, N803, N818 (the names are those of usdview)

import importlib

from pxr import Plug, Tf

from .qt import QtGui, QtWidgets


class DuplicateCommandPlugin(Exception):
    """Two commands of one name."""


class _Deferred:
    def __init__(self, module_name, package):
        self._where = (module_name, package)

    def __getattr__(self, name):
        def call(*args, **kwargs):
            return getattr(importlib.import_module(self._where[0], self._where[1]), name)(*args, **kwargs)

        return call


class PluginContainer:
    """What a plugin derives from."""

    def deferredImport(self, moduleName):
        return _Deferred(moduleName, self.__module__)

    def registerPlugins(self, plugRegistry, plugCtx):
        raise NotImplementedError

    def configureView(self, plugRegistry, plugUIBuilder):
        raise NotImplementedError


PluginContainerTfType = Tf.Type.Define(PluginContainer)


class CommandPlugin:
    """A command as the registry keeps it."""

    def __init__(self, name, displayName, callback, description, usdviewApi):
        assert callable(callback)
        self.name, self.displayName, self.description = name, displayName, description
        self._callback, self._api = callback, usdviewApi

    def run(self):
        self._callback(self._api)


class PluginMenu:
    """A menu that takes commands."""

    def __init__(self, qMenu):
        self._menu = qMenu
        self._below = {}

    def addItem(self, commandPlugin, shortcut=None):
        assert isinstance(commandPlugin, CommandPlugin)
        action = self._menu.addAction(commandPlugin.displayName, commandPlugin.run)
        action.setToolTip(commandPlugin.description)
        if shortcut is not None:
            action.setShortcut(QtGui.QKeySequence(shortcut))
        return action

    def findOrCreateSubmenu(self, menuName):
        if menuName not in self._below:
            self._below[menuName] = PluginMenu(self._menu.addMenu(menuName))
        return self._below[menuName]

    def addSeparator(self):
        self._menu.addSeparator()


class PluginRegistry:
    """All commands by name."""

    def __init__(self, usdviewApi):
        self._api = usdviewApi
        self._commands = {}

    def registerCommandPlugin(self, name, displayName, callback, description=""):
        if name in self._commands:
            raise DuplicateCommandPlugin(name)
        self._commands[name] = CommandPlugin(name, displayName, callback, description, self._api)
        return self._commands[name]

    def getCommandPlugin(self, name):
        return self._commands.get(name)


class PluginUIBuilder:
    """The menus of usdview's window."""

    def __init__(self, mainWindow):
        self._bar = mainWindow.menuBar()
        menus = [child for child in self._bar.children() if isinstance(child, QtWidgets.QMenu)]
        self._menus = {menu.title().replace("&", ""): PluginMenu(menu) for menu in menus}

    def findOrCreateMenu(self, menuName):
        if menuName not in self._menus:
            self._menus[menuName] = PluginMenu(self._bar.addMenu(menuName))
        return self._menus[menuName]


def loadPlugins(usdviewApi, mainWindow):
    """Load every plugin that declares a container type, and let each register commands and build menus."""
    types = Plug.Registry.GetAllDerivedTypes(PluginContainerTfType)
    owners = {}
    for each in types:
        owners.setdefault(Plug.Registry().GetPluginForType(each), []).append(each)
    containers = []
    for plugin in sorted(owners, key=lambda plugin: plugin.name):
        plugin.Load()
        for each in sorted(owners[plugin], key=lambda each: each.typeName):
            assert each.pythonClass is not None, f"{each.typeName} is not defined by the module that plugInfo names"
            containers.append(each.pythonClass())
    registry = PluginRegistry(usdviewApi)
    for container in containers:
        container.registerPlugins(registry, usdviewApi)
    builder = PluginUIBuilder(mainWindow)
    for container in containers:
        container.configureView(registry, builder)
    return registry
