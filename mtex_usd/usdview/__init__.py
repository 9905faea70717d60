"""The way from usdview to its plugin, which lies beside plugInfo.json in a checkout and in a wheel.

usdview imports a plugin by the module name that plugInfo.json gives, whatever the layout. This package gives the
plugin one name, ``mtex_usd.usdview``, in all of them, so that one variable, ``PXR_PLUGINPATH_NAME``, is all to be set.
Importing it needs neither Qt nor usdview.
"""

from mtex_usd.plugin_path import plugin_path

__all__: list[str] = []

__path__ = [str(plugin_path() / "usdview")]
