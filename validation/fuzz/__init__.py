"""Seeded damage to scenes and to files of every kind the program reads, and what it may answer.

`python -m validation.fuzz` damages scenes and files, each by a case's own random numbers, and hands them to the readers
and to what a run computes first from them. Laws: it is taken, or refused as InputError or SchemaError in one printable
line of 1000 characters at most; nothing is printed beside it, warnings included; it takes seconds, and less than 1 GB.
"""
