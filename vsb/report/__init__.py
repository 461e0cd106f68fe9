"""Figures, pages and answers in words, made from results alone.

Those of a study are `answer`, `page` and `figures`; `campaign_*` and `design_*` are of the others.
"""
