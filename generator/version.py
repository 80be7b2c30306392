"""The version of ccgen, stated once."""

VERSION = "0.1.0"
