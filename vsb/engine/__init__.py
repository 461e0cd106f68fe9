"""The engine: waves, shell, water, motion and integration in time; it knows no study.

Arrays and small frozen records in, arrays out; every room is usable alone.
"""
