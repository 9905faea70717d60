"""Generate generatedSchema.usda and plugInfo.json from schema.usda.

Run ``python schemas/generate.py`` after editing schema.usda and commit what it writes; ``--check`` writes nothing and
fails where the committed files are not what the source gives. Needs usd-core and jinja2.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
GENERATED = ("generatedSchema.usda", "plugInfo.json")
# usdGenSchema leaves these for a build system; ours is that everything lies in one folder and nothing is compiled.
PLACEHOLDERS = {"LibraryPath": "", "ResourcePath": ".", "Root": "."}


def generate_files(source: Path) -> dict[str, str]:
    """Run usdGenSchema on a schema source and finish what it leaves open.

    Parameters
    ----------
    source
        The schema.usda to read.

    Returns
    -------
    dict of str to str
        Text by file name, the same bytes for the same source and version of USD.

    Raises
    ------
    RuntimeError
        With usdGenSchema's own words where it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pxr.Usd.usdGenSchema", "--quiet", str(source), folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        written = {name: Path(folder) / name for name in GENERATED}
        if done.returncode != 0 or not all(file_path.is_file() for file_path in written.values()):
            raise RuntimeError(f"usdGenSchema failed:\n{done.stdout}{done.stderr}")
        texts = {name: file_path.read_text(encoding="utf-8") for name, file_path in written.items()}
    texts["plugInfo.json"] = finish_plug_info(texts["plugInfo.json"])
    texts["generatedSchema.usda"] = texts["generatedSchema.usda"].rstrip() + "\n"
    return texts


def finish_plug_info(text: str) -> str:
    """Fill in the placeholders and write plain JSON, since comments before it stop every reader but USD's."""
    body = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    info = json.loads(body)
    for plugin in info["Plugins"]:
        plugin.update(PLACEHOLDERS)
    return json.dumps(info, indent=4, sort_keys=True) + "\n"


def find_drift(texts: dict[str, str], folder: Path) -> list[str]:
    """Name the files of a folder that are missing or differ from the texts."""
    committed = {name: folder / name for name in texts}
    return [
        name
        for name, file_path in committed.items()
        if not file_path.is_file() or file_path.read_text(encoding="utf-8") != texts[name]
    ]


def main(arguments: list[str] | None = None) -> int:
    """Write the generated files, or check them; the exit code is 1 where a check finds drift."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail where committed files have drifted")
    options = parser.parse_args(arguments)
    texts = generate_files(FOLDER / "schema.usda")
    drifted = find_drift(texts, FOLDER)
    if options.check:
        for name in drifted:
            print(f"schemas/{name} is not what schema.usda gives; run python schemas/generate.py", file=sys.stderr)
        return 1 if drifted else 0
    for name in drifted:
        (FOLDER / name).write_text(texts[name], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
