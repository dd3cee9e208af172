# SPDX-License-Identifier: Apache-2.0
"""Sweeps: every combination of arrays, foci and paths, a row of numbers each, computed on Dask and kept as Parquet."""
