"""What a user of Python holds: run a study, open results, plot them, put arrays in and get arrays out.

May import every room but `cli`. Everything here returns pandas tables or labelled xarray data with units.
"""
