"""Records: all numbers of one prediction, with their signatures, and tables of several."""

from npss._analysis.blocks import Groups
from npss.records._measure import NUMBERS, Record, Unwrapped, measure, signature_of
from npss.records._summary import summary

__all__ = ["NUMBERS", "Groups", "Record", "Unwrapped", "measure", "signature_of", "summary"]
