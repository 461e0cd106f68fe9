"""Motion of a scene in time by one of several methods, steady states in regular waves, and the energy audit of a run.

`simulate` chooses the method and follows a run; each method is a module of its own (docs/extending.md).
Of motion it imports `system` alone, beside errors, tools, study, waves and hydro.
"""
