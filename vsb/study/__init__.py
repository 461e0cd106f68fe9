"""The files a user writes: a study of a buoy or a body, a campaign; what they ask for, and the plan of its jobs.

Sections of a file are in modules of their names, such as `device`, `take_off`, `waves`, `drag`, the small ones in
`sections`; `keys` explains every key; `specs`, `plan` and `jobs` say what is computed.
Pure Python, read at every parse of the Snakefile: no numpy, nothing that solves. May import errors and tools.
"""
