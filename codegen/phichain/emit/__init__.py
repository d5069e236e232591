"""Emit: Programs as standalone C and CasADi text."""

from phichain.emit.folder import folder_files, library_files

__all__ = ["folder_files", "library_files"]
