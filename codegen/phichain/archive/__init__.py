"""Records on file: what each kind holds, and how it is read back without belief in the file."""

from phichain.archive.possible import Part, Possible
from phichain.archive.reader import read_archive, refuse
from phichain.archive.schema import (
    COUNT,
    COUNTS,
    DURATION,
    LARGEST,
    META,
    NUMBER,
    TEXT,
    TRUTH,
    VALUES,
    Array,
    Field,
    Schema,
    complex_numbers,
    names,
    real,
    signs,
    whole,
    word,
)

__all__ = [
    "COUNT",
    "COUNTS",
    "DURATION",
    "LARGEST",
    "META",
    "NUMBER",
    "TEXT",
    "TRUTH",
    "VALUES",
    "Array",
    "Field",
    "Part",
    "Possible",
    "Schema",
    "complex_numbers",
    "names",
    "read_archive",
    "real",
    "refuse",
    "signs",
    "whole",
    "word",
]
