"""Planted errors: each law of the program, moved a little, turns the check red that is to guard it.

A row names a file, its text, the wrong text, and a judge: the test or validation case that must fail. `rows_*` hold the
rows by half of the program, `running` plants them in copies of the tree.
"""
