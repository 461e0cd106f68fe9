"""The stages of the workflow and the commands: what reads files, computes, and writes files.

A stage is a row of `STAGES` and a task in `vsb.pipeline`, a specification of `vsb.study.specs`, a function `run_NAME`.
"""
