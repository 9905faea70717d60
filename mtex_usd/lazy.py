"""Packages whose public names are loaded when they are first used, so that importing them stays quick."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module

__all__ = ["load_lazily"]


def load_lazily(
    package: str, homes: Mapping[str, Sequence[str]], *, packages: Sequence[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Give a package's ``__getattr__`` and ``__dir__``.

    Type checkers do not see through them: the package imports the same names where ``TYPE_CHECKING`` is true.

    Parameters
    ----------
    package
        Its name.
    homes
        The public names by the module below the package that they live in.
    packages
        Public packages below it.
    """
    places = {name: home for home, names in homes.items() for name in names}

    def load(name: str) -> object:
        """Load a public name from the module it lives in, or a public package."""
        if name in packages:
            return import_module(f"{package}.{name}")
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{places[name]}"), name)

    def list_names() -> list[str]:
        """List the public names without loading them."""
        return sorted({*vars(sys.modules[package]), *places, *packages})

    return load, list_names
