"""The peers, one file each; every one hands back a ``Candidate``, a C function pointer timed like our own
code.
"""
