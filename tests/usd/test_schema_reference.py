"""The reference of the edit schema says what the registered schema says."""

import re
from pathlib import Path

from mtex_usd.edit.stack.operations import OPERATIONS, SPAN
from tests.usd.schema_support import property_contract

REFERENCE = Path(__file__).parents[2] / "schemas" / "EDITS.md"
PREFIX = "mtex:edit:__INSTANCE_NAME__:"


def _rows(heading: str) -> list[list[str]]:
    section = REFERENCE.read_text(encoding="utf-8").split(f"## {heading}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    lines = [line for line in lines if not line.startswith("| `op` | what")]  # the head of the table
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def _names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def _shown(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    return str(value).removesuffix(".0")


def test_every_setting_stands_in_the_reference_with_its_type_and_fallback() -> None:
    said = {
        name: (type_name, fallback) for names, type_name, _, fallback, _ in _rows("Settings") for name in _names(names)
    }
    registered = {
        name.removeprefix(PREFIX): (type_name, "`[]`" if type_name.endswith("[]") else _shown(fallback))
        for name, (type_name, fallback) in property_contract("MtexEditAPI").items()
    }
    assert said == registered


def test_every_operation_stands_in_the_reference_with_what_it_takes() -> None:
    said = {}
    for ops, _, needs, takes, _ in _rows("Operations"):
        settings = {*_names(needs), *_names(takes)} | (set(SPAN) if "*span*" in takes else set())
        said.update(dict.fromkeys(_names(ops), settings))
    assert said == {op: set(operation.settings) for op, operation in OPERATIONS.items()}
