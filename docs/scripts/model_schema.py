"""The schema of model.json, for the runtime and as the table in docs/model.md; ``--write`` puts it in their places."""

from __future__ import annotations

import argparse
from pathlib import Path

from ccgen.generator.package.schema import schema_text, table

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = ROOT / "runtime" / "loading" / "model.schema.json"
PAGE = ROOT / "docs" / "model.md"
BEGIN, END = "<!-- keys -->\n", "\n<!-- end of keys -->"


def page() -> str:
    """docs/model.md with the table as it is now."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


def main() -> None:
    """Print the table, or write schema and table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--write", action="store_true", help="write runtime/loading/model.schema.json and docs/model.md"
    )
    if not parser.parse_args().write:
        print(table())
        return
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
