"""Hydro databases of other codes: capytaine, WAMIT and BEMIO read and checked, WAMIT and BEMIO written.

One module per format, `common` for what formats share, `checks` for the verdict, `exchange` for any file.
Imports from hydro and the rooms below it.
"""
