"""Where the USD plugin is, found without loading USD.

The folder is what ``PXR_PLUGINPATH_NAME`` takes so that other programs know the mtex schemas. An installed wheel has it
inside the package; a checkout and an editable install have it beside the package.
"""

import os
from pathlib import Path

from mtex_usd.errors import InputError

__all__ = ["announce_plugin", "plugin_path"]

_PACKAGE = Path(__file__).resolve().parent
_PLACES = (_PACKAGE / "_plugins" / "pxr_plugin", _PACKAGE.parent / "pxr_plugin")
_VARIABLE = "PXR_PLUGINPATH_NAME"


def plugin_path() -> Path:
    """Find the folder whose plugInfo.json registers the mtex schemas.

    Returns
    -------
    Path
        An absolute folder; this one entry on ``PXR_PLUGINPATH_NAME`` is enough.

    Raises
    ------
    InputError
        Where the installation lacks the plugin, naming the places looked at.
    """
    for place in _PLACES:
        if (place / "plugInfo.json").is_file() and (place.parent / "schemas" / "generatedSchema.usda").is_file():
            return place
    raise InputError(
        "the installation of usdmtex is incomplete",
        expected=f"plugInfo.json and the schemas in {' or '.join(map(str, _PLACES))}",
        found="neither",
        fix="Install usdmtex again.",
    )


def announce_plugin() -> None:
    """Put the plugin on this process's ``PXR_PLUGINPATH_NAME``, for a USD that is not loaded yet to find.

    What stands there goes first. Programs started from here inherit it: they know the schemas too.

    Raises
    ------
    InputError
        Where the installation lacks the plugin.
    """
    places = [place for place in os.environ.get(_VARIABLE, "").split(os.pathsep) if place]
    if str(plugin_path()) not in places:
        os.environ[_VARIABLE] = os.pathsep.join([*places, str(plugin_path())])
