"""Stages from text, fresh processes, and what every schema property must have."""

import os
import subprocess
import sys
from pathlib import Path

from pxr import Sdf, Usd

PROJECT = Path(__file__).resolve().parents[2]


def open_text(text: str) -> Usd.Stage:
    """Open a stage from the body of a .usda file."""
    layer = Sdf.Layer.CreateAnonymous("stage.usda")
    assert layer.ImportFromString(f"#usda 1.0\n{text}")
    return Usd.Stage.Open(layer)


def open_sublayer(text: str, offset: Sdf.LayerOffset) -> Usd.Stage:
    """Open a stage over one sublayer that is moved in time; keeps the sublayer alive through the stage."""
    sublayer = Sdf.Layer.CreateAnonymous("sublayer.usda")
    assert sublayer.ImportFromString(f"#usda 1.0\n{text}")
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths.append(sublayer.identifier)
    stage.GetRootLayer().subLayerOffsets[0] = offset
    return stage


def run_python(code: str, *, folder: Path = PROJECT, plugin_folder: Path | None = None, package: bool = False) -> str:
    """Run code in a fresh process that knows our plugin only where told; gives what it prints.

    With `package` it can import ours from any folder.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PXR_PLUGINPATH_NAME"}
    if package:
        environment["PYTHONPATH"] = str(PROJECT)
    if plugin_folder is not None:
        environment["PXR_PLUGINPATH_NAME"] = str(plugin_folder)
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def property_contract(api_name: str) -> dict[str, tuple[str, object]]:
    """Give the type and fallback of every property of a registered schema; a relationship's type is ``rel``."""
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(api_name)
    contract: dict[str, tuple[str, object]] = {}
    for name in definition.GetPropertyNames():
        attribute = definition.GetSchemaAttributeSpec(name)
        if attribute is None:
            contract[name] = ("rel", None)
        else:
            value = definition.GetAttributeFallbackValue(name)
            contract[name] = (str(attribute.typeName), plain(value))
    return contract


def plain(value: object) -> object:
    """Make arrays and vectors comparable."""
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def is_sentence(text: str) -> bool:
    """Tell whether a doc string survived generation whole; what is too long ends in dots there."""
    return text[:1].isupper() and text.endswith(".") and not text.endswith("...")


def check_presentation(api_name: str) -> None:
    """Check what every property needs to be understood in a user interface, and that it does not vary."""
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(api_name)
    assert is_sentence(definition.GetDocumentation())
    for name in definition.GetPropertyNames():
        spec = definition.GetSchemaPropertySpec(name)
        assert spec.variability == Sdf.VariabilityUniform, name
        assert is_sentence(definition.GetPropertyDocumentation(name)), name
        assert spec.displayGroup.startswith("Mtex "), name
        assert spec.displayName, name
