"""Emit: Programs as standalone C and CasADi text."""

from phichain.emit.folder import folder_files, library_files
from phichain.emit.manifest import with_proof

__all__ = ["folder_files", "library_files", "with_proof"]
