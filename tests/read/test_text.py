"""Text and numbers: encodings, Fortran's ways of writing numbers, and what must not pass for a number."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fowtio.errors import FormatError
from fowtio.read.text import number, number_rows, number_table, numbers, read_lines


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("-2.5D+03", -2500.0),
        ("1.d-3", 1e-3),
        ("1.234-103", 1.234e-103),
        ("-.5+100", -0.5e100),
        ("+7", 7.0),
    ],
)
def test_number_reads_fortran_forms(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    "text", ["*****", "NaN", "Infinity", "1e999", "0x10", "1_000", "", "1.5.2", "--1", "１２", "2-100", "1.2E", "T"]
)
def test_number_refuses_what_is_none(text):
    # 2-100 has no point: it may be two integers grown together, so it is not taken for 2e-100
    with pytest.raises(ValueError):
        number(text)


@given(st.lists(st.floats(-1e9, 1e9).filter(lambda v: v == 0 or abs(v) > 1e-9), min_size=2, max_size=6))
def test_merged_columns_come_apart(values):
    # Fortran columns without blanks between: every number but the first brings its sign
    text = "".join(f"{v:+.6E}" for v in values)
    np.testing.assert_allclose(numbers(text), values, rtol=1e-6, atol=0)  # seven digits were written


def test_number_table_agrees_with_the_slow_way(tmp_path):
    lines = ["1.0 2.0D+00 -3.0", " 4, 5, 6", "", "-1.0E+00-2.0E+00-3.0E+00"]
    assert number_table(tmp_path, lines, 1, 3, "row").tolist() == [[1, 2, -3], [4, 5, 6], [-1, -2, -3]]
    assert number_table(tmp_path, ["1 2 3", "4 5 6"], 1, 3, "row").tolist() == [[1, 2, 3], [4, 5, 6]]
    assert number_table(tmp_path, ["", " "], 1, 3, "row").shape == (0, 3)


@pytest.mark.parametrize(
    ("bad", "line"), [("1 2", 12), ("1 2 3 4", 12), ("1 x 3", 12), ("1 NaN 3", 12), ("1 ***** 3", 12)]
)
def test_number_table_names_the_bad_line(tmp_path, bad, line):
    with pytest.raises(FormatError) as error:
        number_table(tmp_path / "a.txt", ["1 2 3", "4 5 6", bad, "7 8 9"], 10, 3, "a row of three")
    assert error.value.line == line
    assert "a row of three" in str(error.value)


def test_number_rows_accepts_several_widths(tmp_path):
    assert number_rows(tmp_path, ["1 2", "", "1 2 3"], 1, (2, 3), "row") == [[1, 2], [1, 2, 3]]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_whatever_encoding_and_line_end(tmp_path, encoding, end):
    path = tmp_path / "a.txt"
    path.write_bytes(end.join(["é 1", "2", ""]).encode(encoding))
    assert read_lines(path) == ["é 1", "2"]


def test_line_numbers_do_not_depend_on_odd_characters(tmp_path):
    # a form feed or Latin-1 next-line character is no line end for any editor
    path = tmp_path / "a.txt"
    path.write_bytes(b"one\x0c\x85\ntwo\n")
    assert len(read_lines(path)) == 2


@pytest.mark.parametrize("content", [b"", b" \n\n", b"a\0b"])
def test_files_without_text(tmp_path, content):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        read_lines(path)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(FormatError, match="does not exist"):
        read_lines(tmp_path / "no.txt")
    with pytest.raises(FormatError):
        read_lines(tmp_path)
