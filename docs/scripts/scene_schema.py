"""The JSON Schema of scene files, for editors; ``--write`` puts it into docs/scene.schema.json."""

from __future__ import annotations

import argparse
from pathlib import Path

from ccgen.generator.scene.editor_schema import editor_schema

PLACE = Path(__file__).parents[1] / "scene.schema.json"


def main() -> None:
    """Print the schema, or write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/scene.schema.json")
    if parser.parse_args().write:
        PLACE.write_text(editor_schema(), encoding="utf-8")
    else:
        print(editor_schema(), end="")


if __name__ == "__main__":
    main()
