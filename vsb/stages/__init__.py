"""The stages of the workflow and the commands: what reads files, computes, and writes files.

A stage is a row of the table in `stage.py`, a specification of `vsb.study.specs` and a function `run_NAME`.
"""
