"""Numbers of equations: those of docs/theory.md count up in each section, and every one that is cited exists."""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path

from ..support.folders import ROOT

NUMBER = r"\d+(?:\.\d+)?[a-z]?['′]*"
CITED = re.compile(rf"\b[Ee]q\.\s+({NUMBER}(?:(?:,\s*| and\s+| to\s+){NUMBER})*)")
SOURCES = ("generator/**/*.py", "runtime/**/*.py", "runtime/**/*.[ch]", "tests/**/*.py", "templates/*", "docs/*.md")


def tags(text: str) -> list[tuple[str, str]]:
    """Section and number of every equation, in order."""
    found, section = [], ""
    for line in text.splitlines():
        section = head[1] if (head := re.match(r"## (\d+)\.", line)) else section
        found += [(section, tag) for tag in re.findall(r"\\tag\{([^}]+)\}", line)]
    return found


def cited(text: str) -> set[str]:
    return {number for one in CITED.finditer(text) for number in re.findall(NUMBER, one[1])}


def test_equations_count_up_in_their_sections() -> None:
    found = tags((ROOT / "docs" / "theory.md").read_text())
    wanted: dict[str, int] = {}
    for section, tag in found:
        wanted[section] = wanted.get(section, 0) + 1
        assert tag == f"{section}.{wanted[section]}"
    assert len(found) > 50


def citations() -> set[tuple[str, str]]:
    """File and number of every equation that is cited; a number's own tag is no citation."""
    found = chain(*(ROOT.glob(pattern) for pattern in SOURCES))
    files = [file for file in found if file.is_file() and file != Path(__file__)]
    return {(file.name, number) for file in files for number in cited(file.read_text())}


def test_every_equation_that_is_cited_exists() -> None:
    numbers = {tag for _, tag in tags((ROOT / "docs" / "theory.md").read_text())}
    found = citations()
    missing = {(file, number) for file, number in found if number not in numbers}
    assert not missing
    assert len({number for _, number in found}) > 40


def test_every_numbered_equation_is_cited() -> None:
    """An equation that nothing cites needs no number."""
    numbers = {tag for _, tag in tags((ROOT / "docs" / "theory.md").read_text())}
    uncited = numbers - {number for _, number in citations()}
    assert not uncited


def test_the_check_sees_a_number_that_does_not_exist() -> None:
    assert cited("by eq. 4.7, 4.8 and 99.1, (eq. 3) and Eq. 22b.") == {"4.7", "4.8", "99.1", "3", "22b"}


def test_a_tag_is_no_citation() -> None:
    assert not cited(r"x = y \tag{4.7}")
    assert tags("## 4. The recursion\nx = y \\tag{4.7}") == [("4", "4.7")]


def test_sections_are_numbered_in_order() -> None:
    """One after the other; the contents at the head have the number of the last equation of each."""
    text = (ROOT / "docs" / "theory.md").read_text()
    contents = re.findall(r"^(\d+)\. \[.*?\]\(#.*?\)(?:: (?:equations )?(.*))?$", text, re.MULTILINE)
    assert len(contents) == len(re.findall(r"^## \d+\. ", text, re.MULTILINE))
    for chapter, told in contents:
        found = [int(number) for number in re.findall(rf"^### {chapter}\.(\d+) ", text, re.MULTILINE)]
        assert found == [*range(1, len(found) + 1)], chapter
        last = [tag for section, tag in tags(text) if section == chapter][-1:]
        assert re.findall(r"[\d.]+", told)[-1:] == last, chapter
