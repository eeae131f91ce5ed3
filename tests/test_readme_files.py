"""Where the READMEs are, what they link to, and what they name."""

from importlib.util import find_spec
from pathlib import Path
import re

from paths import ROOT
import pytest
from readmes import READMES, TOP, name_of, rows, text_of

PACKAGE = ROOT / "pbpf_drake"
DIAGRAMS = ROOT / "diagrams"

every_readme = pytest.mark.parametrize("readme", READMES, ids=name_of)


def links(readme: Path) -> list[tuple[Path, str]]:
    """The file that each link is to, and the heading in it, if any."""
    found = re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", text_of(readme))
    return [
        ((readme.parent / path).resolve() if path else readme, heading)
        for path, heading in found
        if not path.startswith("http")
    ]


def headings(readme: Path) -> set[str]:
    """The headings, as GitHub writes them in links."""
    titles = re.findall(r"^#+ (.*)", text_of(readme), re.MULTILINE)
    return {
        re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        for title in titles
    }


def test_first_readme_is_short():
    assert len(TOP.read_bytes()) <= 14_000


def test_every_readme_is_linked_from_the_first():
    assert set(READMES) - {TOP} <= {file for file, _ in links(TOP)}


@every_readme
def test_readme_begins_with_what_there_is(readme):
    title, paragraph, *_ = text_of(readme).split("\n\n")
    assert re.fullmatch(r"# .+", title)
    assert paragraph[0].isalpha() and "." in paragraph


@every_readme
def test_files_and_headings_that_are_linked_exist(readme):
    for file, heading in links(readme):
        assert file.exists(), file
        assert not heading or heading in headings(file), heading


@every_readme
def test_pictures_are_small(readme):
    for file, _ in links(readme):
        if file.suffix == ".png":
            assert file.stat().st_size < 300_000, file


@every_readme
def test_files_that_are_named_exist(readme):
    text = text_of(readme)
    for path in re.findall(
        r"`((?:diagrams|pbpf_drake|tests|\.ci)/[^`]+)`", text
    ):
        assert (ROOT / path).exists(), path
    names = {f.name for f in (*PACKAGE.rglob("*.py"), *DIAGRAMS.rglob("*.py"))}
    for name in re.findall(r"`(\w+\.py)`", text):
        assert name in names, name


def test_something_is_linked_and_named():
    assert any(file.suffix == ".png" for file, _ in links(TOP))
    assert sum(len(links(readme)) for readme in READMES) > 50


def test_rooms_are_those_of_the_package():
    rooms = {
        folder.name
        for folder in PACKAGE.iterdir()
        if (folder / "__init__.py").exists() and not folder.is_symlink()
    }
    named = [re.search(r"`(\w+)`", row[0]) for row in rows("room.*?")]
    assert {name.group(1) for name in named if name} == rooms


def test_commands_are_those_that_can_be_run():
    commands = {
        file.stem
        for file in DIAGRAMS.glob("*.py")
        if file.name != "__init__.py"
    }
    assert {row[0].strip("`") for row in rows("command")} == commands
    for name in commands:
        assert find_spec(f"pbpf_drake.diagrams.{name}")


def test_scene_files_are_those_of_the_folder():
    text = text_of(DIAGRAMS / "scenes" / "README.md")
    for file in (DIAGRAMS / "scenes").glob("*.yaml"):
        series = re.sub(r"_[234]$", "_1", file.stem)
        assert f"`{file.stem}`" in text or f"`{series}`" in text, file


def test_results_that_are_shown_first_are_those_of_the_experiments():
    table = rows("what is tracked")
    assert len(table) == 8
    for title, *cells in table:
        if link := re.search(r"\]\(([^)#]+)", title):
            # Until the next link, rows are of the same experiment.
            text = text_of(ROOT / link.group(1))
        means = re.findall(r"\d+ ± \d+", title)
        for shown in means + [x for cell in cells for x in cell.split(", ")]:
            assert in_its_units(shown) in text, shown


def in_its_units(shown: str) -> str:
    """Means of the paper's scenes are in meters where they come from."""
    if "±" not in shown:
        return shown
    return " ± ".join(f"{int(mm) / 1000:.3f}" for mm in shown.split(" ± "))
