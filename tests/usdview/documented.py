"""usdview's interface for plugins, as OpenUSD documents it: names and parameters, to check every use against.

From OpenUSD's *Creating a Usdview Plugin* (openusd.org, tested with 23.08) and the docstrings of
``pxr/usdImaging/usdviewq/usdviewApi.py``, ``plugin.py`` and ``rootDataModel.py`` (release branch). Where an installed
usdview is at hand (``MTEX_USDVIEW_PYTHON``) ``test_loading.py`` compares this table with it.
"""

API_PROPERTIES = frozenset(
    {
        "cameraPrim",
        "configDir",
        "currentGfCamera",
        "dataModel",
        "frame",
        "layer",
        "prim",
        "property",
        "qMainWindow",
        "selectedInstances",
        "selectedPaths",
        "selectedPoint",
        "selectedPrims",
        "spec",
        "stage",
        "stageIdentifier",
        "viewerMode",
        "viewportSize",
    }
)
API_METHODS = {
    "AddPrimToSelection": ("prim",),
    "ClearPrimSelection": (),
    "ComputeModelsFromSelection": (),
    "ComputeSelectedPrimsOfType": ("schemaType",),
    "GetSettings": (),
    "GetViewportRendererNames": (),
    "GrabViewportShot": (),
    "GrabWindowShot": (),
    "PrintStatus": ("msg",),
    "SetViewportRenderer": ("plugId",),
    "UpdateGUI": (),
    "UpdateViewport": (),
}

# Of the data model what a plugin may use: properties, those that can be set, and signals.
MODEL_PROPERTIES = frozenset({"currentFrame", "includedPurposes", "playing", "stage", "useExtentsHint"})
MODEL_SETTABLE = frozenset({"currentFrame", "playing", "useExtentsHint"})
MODEL_SIGNALS = frozenset({"signalPrimsChanged", "signalStageReplaced"})
MODEL_METHODS = {
    "computeBoundMaterial": ("prim", "purpose"),
    "computeWorldBound": ("prim",),
    "getLocalToWorldTransform": ("prim",),
}

# Parameters without self; a default as usdview has it.
PLUGIN_METHODS = {
    "PluginContainer.deferredImport": "(moduleName)",
    "PluginContainer.registerPlugins": "(plugRegistry, plugCtx)",
    "PluginContainer.configureView": "(plugRegistry, plugUIBuilder)",
    "PluginRegistry.registerCommandPlugin": "(name, displayName, callback, description='')",
    "PluginRegistry.getCommandPlugin": "(name)",
    "PluginUIBuilder.findOrCreateMenu": "(menuName)",
    "PluginMenu.addItem": "(commandPlugin, shortcut=None)",
    "PluginMenu.findOrCreateSubmenu": "(menuName)",
    "PluginMenu.addSeparator": "()",
}
