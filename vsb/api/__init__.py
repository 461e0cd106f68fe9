"""What a user of Python holds: run a study, open results, plot them, put arrays in and get arrays out.

Everything here returns pandas tables or labelled xarray data with units.
"""
