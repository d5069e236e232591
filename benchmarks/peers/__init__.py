"""The peers, one file or folder each; every one hands back a ``Candidate``, a C function pointer timed like our own
code.
"""
