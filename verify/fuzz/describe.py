#!/usr/bin/python3
"""A result file as the lines of which readers_fuzz.cpp makes one. Usage: verify/fuzz/describe.py FILE"""

import sys

import h5py
import numpy as np


def words(values):
    return [one if isinstance(one, str) else one.decode() if isinstance(one, bytes) else repr(one) for one in np.ravel(values).tolist()]


def kind_of(values, of_texts, of_numbers, of_integers):
    return {"f": of_numbers, "i": of_integers}.get(np.asarray(values).dtype.kind, of_texts)


def line(kind, *rest):
    print(kind, *(word.replace("\t", " ").replace("\n", " ") for word in rest), sep="\t")


def describe(path, thing):
    if isinstance(thing, h5py.Group):
        line("g", path, "")
    else:
        line(kind_of(thing[()], "t", "n", "i"), path, *words(thing[()]))
    for name, value in thing.attrs.items():
        line(kind_of(value, "T", "N", "I"), path, name, *words(value))


with h5py.File(sys.argv[1]) as file:
    describe("/", file)
    file.visititems(lambda name, thing: describe("/" + name, thing))
