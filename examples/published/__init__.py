"""Numbers of README.md and docs/: computed by commands, stored with them, written into sentences, tables and a picture.

    python -m examples.published                 # everything anew, most of an hour of CPU time: make published
    python -m examples.published study claims    # some sources by name
    python -m examples.published --stored        # pages from the values stored, nothing is computed

`sources` says which command a number comes from; `docs/published/values.json` stores what they gave. A page holds
numbers in sentences, whose wording `docs/published/sentences.yaml` repeats with the name of a value in place of each
number, and in blocks between `<!-- published: NAME -->` and `<!-- end -->`, which `tables` writes whole.
"""
