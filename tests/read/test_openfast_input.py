"""The text form shared by OpenFAST's input files: names decide; every error has its line and says what to do."""

import numpy as np
import pytest

from fowtio.errors import FormatError
from fowtio.read.openfast_input import read_input, tokens, unquote

TEXT = """\
------- a file -----------------------
a title that begins 3 Name
False   Echo  - write an echo file
12.5D0  Length  - a length (m)
"DEFAULT"  Density - by default
'two words'  Label - text
 "my folder\\sub folder\\a file.dat"   FileName - a path
1, 2  3   Three - numbers
---------------------- TABLE ----------
  2   NRows - rows of the table
 ID   Value  Flag
 (-)   (m)    (-)
 1    1.0E+3  True   ! comment
! a comment in between
 2    -4      False
---------------------- MATRIX --------
 1 2   Stiff - matrix
 3 4
"""


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "in.dat"
    path.write_text(TEXT)
    return read_input(path)


def test_values_by_name(source):
    assert source.flag("echo") is False
    assert source.number("LENGTH") == 12.5
    assert source.number("Density", 7.0) == 7.0
    assert source.text("Label") == "two words"
    assert source.values("Three") == ["1", "2", "3"]
    assert source.array("Stiff", 2, 2).tolist() == [[1, 2], [3, 4]]
    assert not source.has("Name")


def test_table(source):
    table = source.table("NRows")
    assert table.columns == ["ID", "Value", "Flag"]
    assert table.integers("id").tolist() == [1, 2]
    assert table.numbers("Value").tolist() == [1000, -4]
    assert table.column("Flag") == ["True", "False"]
    assert table.numbers_of_lines == [13, 15]


@pytest.mark.parametrize("change", ["crlf", "tabs", "latin-1", "upper", "blank lines"])
def test_the_same_values_in_other_dress(tmp_path, source, change):
    text = {
        "crlf": TEXT.replace("\n", "\r\n"),
        "tabs": TEXT.replace("  ", "\t"),
        "latin-1": TEXT.replace("a length", "eine Länge"),
        "upper": TEXT.replace("Length", "LENGTH").replace("NRows", "nrows"),
        "blank lines": TEXT.replace("\n 2 ", "\n\n 2 "),
    }[change]
    path = tmp_path / "other.dat"
    path.write_bytes(text.encode("latin-1"))
    other = read_input(path)
    assert other.number("Length") == source.number("Length")
    assert other.table("NRows").rows == source.table("NRows").rows


def check(error, line, *parts):
    """The message names the line and has all the parts."""
    assert error.value.line == line, str(error.value)
    for part in parts:
        assert part in str(error.value), str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "read", "line", "part"),
    [
        ("12.5D0", "12.5X0", lambda s: s.number("Length"), 4, "12.5X0"),
        ("12.5D0", "NaN", lambda s: s.number("Length"), 4, "NaN"),
        ("False   Echo", "Fals   Echo", lambda s: s.flag("Echo"), 3, "True or False"),
        ("  2   NRows", "2.5   NRows", lambda s: s.table("NRows"), 10, "whole number"),
        ("  2   NRows", "  3   NRows", lambda s: s.table("NRows"), 16, "2 rows"),
        ("  2   NRows", "  1   NRows", lambda s: s.table("NRows"), 15, "after 1 rows"),
        ("  2   NRows", " -1   NRows", lambda s: s.table("NRows"), 10, "at least 0"),
        ("-4  ", "x4  ", lambda s: s.table("NRows").numbers("Value"), 15, "x4"),
        (" 2    -4      False", " 2", lambda s: s.table("NRows").numbers("Value"), 15, "column Value"),
        (" 3 4", " 3", lambda s: s.array("Stiff", 2, 2), 18, "row 2 of Stiff"),
        (" 3 4", " 3 x", lambda s: s.array("Stiff", 2, 2), 18, "row 2 of Stiff"),
        (" 1 2   Stiff", " 1 y2   Stiff", lambda s: s.array("Stiff", 2, 2), None, "Stiff"),
    ],
)
def test_errors_have_their_line(tmp_path, old, new, read, line, part):
    path = tmp_path / "bad.dat"
    assert old in TEXT
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(FormatError) as error:
        read(read_input(path))
    check(error, line, part)


def test_unknown_name_names_the_nearest(source):
    with pytest.raises(FormatError) as error:
        source.number("Lenght")
    check(error, None, "Lenght", "Length")


def test_unknown_column_lists_the_known(source):
    with pytest.raises(FormatError, match="ID Value Flag"):
        source.table("NRows").numbers("Volume")


def test_two_values_of_one_name_are_refused(tmp_path):
    path = tmp_path / "twice.dat"
    path.write_text(TEXT + "13.0  Length - again\n")
    with pytest.raises(FormatError) as error:
        read_input(path).number("Length")
    check(error, 19, "line 4")


def test_files_are_found_with_backslashes_and_blanks(tmp_path, source):
    with pytest.raises(FormatError) as error:
        source.file("FileName")
    check(error, 7, "my folder", "relative to in.dat")
    folder = tmp_path / "my folder" / "sub folder"
    folder.mkdir(parents=True)
    (folder / "A file.dat").write_text("x")
    with pytest.raises(FormatError, match=r"There is A file\.dat"):
        source.file("FileName")
    (folder / "a file.dat").write_text("x")
    assert source.file("FileName").read_text() == "x"


def test_tokens_keep_quoted_text_whole():
    assert [unquote(t) for t in tokens("1, 'a b' \"c, d\"  e")] == ["1", "a b", "c, d", "e"]


def test_array_is_finite(tmp_path):
    path = tmp_path / "inf.dat"
    path.write_text("1 Infinity  Stiff - matrix\n3 4\n")
    with pytest.raises(FormatError) as error:
        read_input(path).array("Stiff", 2, 2)
    assert error.value.line == 1
    assert np.isfinite(read_input_of(tmp_path, "1 2  Stiff - m\n3 4\n").array("Stiff", 2, 2)).all()


def read_input_of(folder, text):
    path = folder / "x.dat"
    path.write_text(text)
    return read_input(path)
