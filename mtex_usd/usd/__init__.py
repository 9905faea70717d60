"""The edge to USD: the only package that imports ``pxr``.

Importing it registers the mtex schemas, which has to happen before the first stage of the process is opened.
"""

from mtex_usd.usd.plugin import register_plugin

register_plugin()
